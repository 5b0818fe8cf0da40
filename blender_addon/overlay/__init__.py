"""What 3D viewports show of spacetime, in any shading and with any engine: circles, outlines and curved rays."""

from .draw import register, unregister

__all__ = ["register", "unregister"]
