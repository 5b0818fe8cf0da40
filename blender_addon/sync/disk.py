"""The accretion disk of a black hole: its numbers, and a mesh that holds it, cut by its material (disk_program.py)."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from bentlight_native import disk_drawn_radius, disk_flux, disk_isco, disk_orbit_frequency

from ..report import RenderError
from .scene_data import MeshData, SpacetimeData

_SEGMENTS, _RINGS = 128, 12  # fine enough for lights to be drawn by how much they shine
_ABOVE_HORIZON = 1e-3  # of its radius: nearer nothing is seen
_CONTRAST = 4.0  # of the full pattern
_RADII = 4000  # at which the hottest place is looked for


@dataclass(frozen=True)
class DiskExtent:
    """From where to where a disk reaches, in masses; the mass is in the hole's own units."""

    mass: float
    spin: float
    is_isotropic: bool
    inner: float
    outer: float


def read_extent(settings: Any, hole: SpacetimeData) -> DiskExtent:
    """The radii of a hole's disk. Raises RenderError if it has no inside."""
    horizon = 1 + math.sqrt(1 - hole.spin**2)
    inner = disk_isco(hole.spin) if settings.inner_edge == "ISCO" else settings.inner_radius
    inner = max(inner, horizon * (1 + _ABOVE_HORIZON))
    if not settings.outer_radius > inner:
        raise RenderError(
            "Black hole '{}': the outer radius of its disk, {:g} masses, must be larger than the inner one, {:.4g}",
            hole.name,
            settings.outer_radius,
            inner,
        )
    return DiskExtent(hole.mass, hole.spin, hole.chart == "ISOTROPIC", inner, settings.outer_radius)


@functools.lru_cache(maxsize=64)
def hottest_flux(extent: DiskExtent) -> float:
    """The largest of the disk, or a little outside of it if it is small."""
    radii = np.geomspace(extent.inner, max(extent.outer, 10 * extent.inner), _RADII)
    return max(disk_flux(radius, extent.spin) for radius in radii)


@dataclass(frozen=True)
class Pattern:
    """Operands of the core's pattern: fraction of the loop that has passed, its period in masses, streaks, contrast."""

    phase: float
    period: float
    scale: float
    contrast: float


def read_pattern(settings: Any, extent: DiskExtent, frame: float) -> Pattern:
    """The pattern in a frame."""
    innermost = max(extent.inner, disk_isco(extent.spin))  # of all orbits
    period = 2 * math.pi * settings.loop_orbits / disk_orbit_frequency(innermost, extent.spin)
    phase = frame / settings.loop_frames % 1.0
    return Pattern(phase, period, settings.pattern_scale, _CONTRAST * settings.pattern)


def disk_mesh(extent: DiskExtent) -> MeshData:
    """Rings in the hole's own units that cover the disk, a little wider than it is."""
    bulge = 1.001 / math.cos(math.pi / _SEGMENTS)  # sides of a polygon lie within the circle through its corners
    drawn = [disk_drawn_radius(r, extent.spin, extent.is_isotropic) * extent.mass for r in (extent.inner, extent.outer)]
    radii = np.geomspace(drawn[0] * 0.999, drawn[1] * bulge, _RINGS + 1)
    angles = np.arange(_SEGMENTS) * (2 * math.pi / _SEGMENTS)
    corners = np.stack([np.cos(angles), np.sin(angles), np.zeros(_SEGMENTS)], axis=1)
    vertices = (radii[:, None, None] * corners).reshape(-1, 3)
    here = np.arange(_RINGS * _SEGMENTS).reshape(_RINGS, _SEGMENTS)
    beside = np.roll(here, -1, axis=1)
    quads = np.stack([here, here + _SEGMENTS, beside + _SEGMENTS, beside], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return MeshData(vertices.astype(np.float32), np.ascontiguousarray(triangles, np.uint32))
