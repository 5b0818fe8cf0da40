"""What is not as a user may expect, found before a render, and shown where they look."""

from .finding import Finding
from .findings import of_scene, register, unregister

__all__ = ["Finding", "of_scene", "register", "unregister"]
