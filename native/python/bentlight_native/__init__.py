"""Light in curved spacetime: the numpy-facing side of Bentlight's native core.

Arrays go in and come out as numpy arrays; shapes, units and errors are in each docstring. Units G = c = 1, lengths in
scene units, angles in radians.
"""

from ._core import (
    Cancelled,
    Progress,
    Spacetime,
    contains,
    disk_drawn_radius,
    disk_flux,
    disk_isco,
    disk_orbit_frequency,
    instruction_set,
    lapse,
    local_from_covector,
)
from .connect import CONNECTION_STATES, connect, connect_sky
from .embree import embree_version, load_embree
from .exr import ExrError, write_exr
from .influence import EVERYONE, Influence
from .kerr_map import KerrMap
from .program import OPERATIONS, Program, ProgramBuilder
from .render import CHANNELS, RenderSettings, RenderStatistics, light_image
from .scene import Scene
from .sphere import LensSphere
from .stars import StarImages
from .table import MAP_VERSION, DeflectionTable, SampledTable
from .trace import FATES, ray_path, trace_rays

__all__ = [
    "CHANNELS",
    "CONNECTION_STATES",
    "EVERYONE",
    "FATES",
    "MAP_VERSION",
    "OPERATIONS",
    "Cancelled",
    "DeflectionTable",
    "ExrError",
    "Influence",
    "KerrMap",
    "LensSphere",
    "Program",
    "ProgramBuilder",
    "Progress",
    "RenderSettings",
    "RenderStatistics",
    "SampledTable",
    "Scene",
    "Spacetime",
    "StarImages",
    "connect",
    "connect_sky",
    "contains",
    "disk_drawn_radius",
    "disk_flux",
    "disk_isco",
    "disk_orbit_frequency",
    "embree_version",
    "instruction_set",
    "lapse",
    "light_image",
    "load_embree",
    "local_from_covector",
    "ray_path",
    "trace_rays",
    "write_exr",
]
