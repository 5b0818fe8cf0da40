"""Scene: the core's handle with the numpy-facing methods of every topic."""

from . import _core
from .geometry import GeometryMethods
from .motion import MotionMethods
from .render import RenderMethods
from .shading import ShadingMethods
from .stars import StarMethods


class Scene(GeometryMethods, MotionMethods, RenderMethods, ShadingMethods, StarMethods, _core.Scene):
    """A scene: edit it from one thread, commit(), then read it from many."""
