"""Light in curved spacetime: the numpy-facing side of Bentlight's native core.

Arrays go in and come out as numpy arrays; shapes, units and errors are in each docstring. Units G = c = 1, lengths in
scene units, angles in radians.
"""

from ._core import Cancelled, Progress, Spacetime, instruction_set
from .program import OPERATIONS, Program, ProgramBuilder
from .render import CHANNELS, RenderSettings, RenderStatistics
from .scene import Scene

__all__ = [
    "CHANNELS",
    "OPERATIONS",
    "Cancelled",
    "Program",
    "ProgramBuilder",
    "Progress",
    "RenderSettings",
    "RenderStatistics",
    "Scene",
    "Spacetime",
    "instruction_set",
]
