"""Light in curved spacetime: the numpy-facing side of Bentlight's native core.

Arrays go in and come out as numpy arrays; shapes, units and errors are in each docstring. Units G = c = 1, lengths in
scene units, angles in radians.
"""

from ._core import Cancelled, Progress, Spacetime, contains, instruction_set, lapse, local_from_covector
from .embree import embree_version, load_embree
from .program import OPERATIONS, Program, ProgramBuilder
from .render import CHANNELS, RenderSettings, RenderStatistics
from .scene import Scene
from .trace import FATES, ray_path, trace_rays

__all__ = [
    "CHANNELS",
    "FATES",
    "OPERATIONS",
    "Cancelled",
    "Program",
    "ProgramBuilder",
    "Progress",
    "RenderSettings",
    "RenderStatistics",
    "Scene",
    "Spacetime",
    "contains",
    "embree_version",
    "instruction_set",
    "lapse",
    "load_embree",
    "local_from_covector",
    "ray_path",
    "trace_rays",
]
