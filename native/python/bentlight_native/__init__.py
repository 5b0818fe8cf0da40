"""Light in curved spacetime: the numpy-facing side of Bentlight's native core.

Arrays go in and come out as numpy arrays; shapes, units and errors are in each docstring. Units G = c = 1, lengths in
scene units, angles in radians.
"""

from ._core import Cancelled, Progress, Spacetime, contains, instruction_set, lapse, local_from_covector
from .render import CHANNELS, RenderSettings, RenderStatistics
from .scene import Scene
from .trace import FATES, trace_rays

__all__ = [
    "CHANNELS",
    "FATES",
    "Cancelled",
    "Progress",
    "RenderSettings",
    "RenderStatistics",
    "Scene",
    "Spacetime",
    "contains",
    "instruction_set",
    "lapse",
    "local_from_covector",
    "trace_rays",
]
