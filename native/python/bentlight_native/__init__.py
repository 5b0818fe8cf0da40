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
from .command import run_command
from .connect import CONNECTION_STATES, connect, connect_sky
from .embree import embree_version, load_embree
from .exr import ExrError, write_exr
from .finish import light_image, pass_values, with_light, with_stars
from .influence import EVERYONE, Influence
from .kerr_map import KerrMap
from .motion import Moment
from .parts import Part, PartError, PassPlan, Picture, Piece, write_part
from .program import OPERATIONS, Program, ProgramBuilder
from .render import CHANNELS, Aperture, RenderSettings, RenderStatistics
from .scene import Scene
from .sphere import LensSphere
from .stars import StarImages, star_mean, star_sum
from .state import develop_state, empty_state, merge_states, state_width
from .table import MAP_VERSION, DeflectionTable, SampledTable
from .trace import FATES, ray_path, trace_rays

__all__ = [
    "CHANNELS",
    "CONNECTION_STATES",
    "EVERYONE",
    "FATES",
    "MAP_VERSION",
    "OPERATIONS",
    "Aperture",
    "Cancelled",
    "DeflectionTable",
    "ExrError",
    "Influence",
    "KerrMap",
    "LensSphere",
    "Moment",
    "Part",
    "PartError",
    "PassPlan",
    "Picture",
    "Piece",
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
    "develop_state",
    "disk_drawn_radius",
    "disk_flux",
    "disk_isco",
    "disk_orbit_frequency",
    "embree_version",
    "empty_state",
    "instruction_set",
    "lapse",
    "light_image",
    "load_embree",
    "local_from_covector",
    "merge_states",
    "pass_values",
    "ray_path",
    "run_command",
    "star_mean",
    "star_sum",
    "state_width",
    "trace_rays",
    "with_light",
    "with_stars",
    "write_exr",
    "write_part",
]
