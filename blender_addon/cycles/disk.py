"""What the lens shader is told of a hole's accretion disk; its colors are images in the folder of the tables."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import bpy
import numpy as np
from bentlight_native import disk_drawn_radius, write_exr

from ..sync import disk, thermal
from ..sync.disk_program import ramp_table
from ..sync.scene_data import SpacetimeData
from . import files, shaders

_KINDS = {"PAGE_THORNE": 1, "POWER_LAW": 2, "RAMP": 3}


def is_shown(hole: bpy.types.Object) -> bool:
    """Whether the shader can show a hole's disk: images and materials it cannot."""
    settings = hole.bentlight.disk
    has_colors = settings.emission != "RAMP" or (settings.ramp is not None and settings.ramp.use_color_ramp)
    return settings.enable and settings.emission in _KINDS and has_colors


def warnings(hole: bpy.types.Object) -> list[str]:
    """Why Cycles does not show a hole's disk."""
    if not hole.bentlight.disk.enable or hole.bentlight.kind != "BLACK_HOLE" or is_shown(hole):
        return []
    return [f"The disk of '{hole.name}' is not seen: lenses show blackbodies and color ramps only"]


def reach(hole: bpy.types.Object, item: SpacetimeData) -> float:
    """How far from its hole a disk reaches, in world units; 0 without one."""
    if item.kind != "BLACK_HOLE" or not is_shown(hole):
        return 0.0
    extent = disk.read_extent(hole.bentlight.disk, item)
    return item.scale * item.mass * disk_drawn_radius(extent.outer, extent.spin, extent.is_isotropic)


def sockets(hole: bpy.types.Object, item: SpacetimeData, frame: float) -> dict[str, shaders.Socket]:
    """The shader's parameters that begin with Disk. Raises RenderError for radii that leave no disk."""
    if item.kind != "BLACK_HOLE" or not is_shown(hole):
        return {"DiskEmission": ("NodeSocketInt", 0)}
    settings = hole.bentlight.disk
    extent = disk.read_extent(settings, item)
    pattern = disk.read_pattern(settings, extent, frame)
    table = ramp_table(settings.ramp.color_ramp) if settings.emission == "RAMP" else None
    if table is None:
        table = thermal.blackbody_table(bpy.app.version)
    numbers = {
        "Inner": extent.inner,
        "Outer": extent.outer,
        "Soft": settings.softness * (extent.outer - extent.inner),
        "Temperature": settings.temperature,
        "Exponent": settings.exponent,
        "Hottest": disk.hottest_flux(extent),
        "Coldest": thermal.LOWEST_K,
        "Hot": thermal.HIGHEST_K,
        "Size": len(table),
        "Reference": math.log(thermal.luminance(settings.temperature)),
        "Strength": settings.strength,
        "Opacity": settings.opacity,
        "Doppler": settings.doppler,
        "Gravitational": settings.gravitational,
        "Contrast": pattern.contrast,
        "Scale": pattern.scale,
        "Phase": pattern.phase,
        "Period": pattern.period,
    }
    found = {f"Disk{name}": ("NodeSocketFloat", float(value)) for name, value in numbers.items()}
    found["DiskEmission"] = ("NodeSocketInt", _KINDS[settings.emission])
    found["DiskColors"] = ("NodeSocketString", str(_image(table)))
    return found


def _image(table: np.ndarray) -> Path:
    """A row of colors as an image that is named after what is in it; made if it is missing."""
    path = files.folder("tables") / f"colors_{hashlib.sha256(table.tobytes()).hexdigest()[:16]}.exr"
    if not path.is_file():
        write_exr(path, {f"{i:02}": table[None, :, i] for i in range(4)}, {})
    return path
