"""What the lens shader is told of a hole's accretion disk; its colors are images in the folder of the tables."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bentlight_native import disk_drawn_radius

from ..report import told
from ..sync import disk, thermal
from ..sync.disk_program import ramp_table
from ..sync.images import has_associated_alpha, image_pixels
from ..sync.material import node_tree
from ..sync.scene_data import SpacetimeData
from . import disk_material, files, shaders

log = logging.getLogger(__name__)

_KINDS = {"PAGE_THORNE": 1, "POWER_LAW": 2, "RAMP": 3, "IMAGE": 4, "MATERIAL": 5}


def is_shown(hole: bpy.types.Object) -> bool:
    """Whether a hole has a disk that has all it needs."""
    settings = hole.bentlight.disk
    has_ramp = settings.ramp is not None and settings.ramp.use_color_ramp
    needs = {"RAMP": has_ramp, "IMAGE": settings.image is not None, "MATERIAL": material(hole) is not None}
    return settings.enable and needs.get(settings.emission, True)


def material(hole: bpy.types.Object) -> bpy.types.Material | None:
    """Its disk's own, if that is what it is made of."""
    settings = hole.bentlight.disk
    is_used = settings.enable and settings.emission == "MATERIAL" and hole.bentlight.kind == "BLACK_HOLE"
    return settings.material if is_used and settings.material and node_tree(settings.material) else None


def warnings(hole: bpy.types.Object) -> list[str]:
    """What Cycles does not show of a hole's disk."""
    if not hole.bentlight.disk.enable or hole.bentlight.kind != "BLACK_HOLE":
        return []
    if not is_shown(hole):
        return [told("The disk of '{}' is not seen: it has no color ramp, image or material", hole.name)]
    lost = disk_material.scattering_nodes(material(hole)) if material(hole) else []
    if lost:
        text = "The disk of '{}' only shines in Cycles; what scatters there is left out: {}"
        return [told(text, hole.name, ", ".join(lost))]
    return []


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
    colors = _colors(settings)
    numbers = {
        "Inner": extent.inner,
        "Outer": extent.outer,
        "Soft": settings.softness * (extent.outer - extent.inner),
        "Temperature": settings.temperature,
        "Exponent": settings.exponent,
        "Hottest": disk.hottest_flux(extent),
        "Coldest": thermal.LOWEST_K,
        "Hot": thermal.HIGHEST_K,
        "Size": colors.size,
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
    found["DiskColors"] = ("NodeSocketString", str(colors.path))
    found["DiskEncoded"] = ("NodeSocketInt", int(colors.is_srgb))
    found["DiskAssociated"] = ("NodeSocketInt", int(colors.is_associated))
    return found


@dataclass(frozen=True)
class _Colors:
    """A file of colors; `size`: entries of a row, lines of an image."""

    path: Path
    size: int
    is_srgb: bool = False
    is_associated: bool = False


def _colors(settings: bpy.types.PropertyGroup) -> _Colors:
    if settings.emission == "IMAGE":
        return _of_image(settings.image)
    is_ramp = settings.emission == "RAMP"
    table = ramp_table(settings.ramp.color_ramp) if is_ramp else thermal.blackbody_table(bpy.app.version)
    return _Colors(files.named_by_content("colors", table[None]), len(table))


_images: dict[tuple, _Colors] = {}  # reading pixels takes longer than a change of the scene may


def forget_images() -> None:
    """What is in images is read afresh: their pixels may have changed."""
    _images.clear()


def _of_image(image: bpy.types.Image) -> _Colors:
    key = (image.name_full, tuple(image.size), image.filepath, image.colorspace_settings.name, image.alpha_mode)
    if key not in _images or not _images[key].path.is_file():
        pixels = image_pixels(image, log.warning)
        values = pixels.values / np.float32(255) if pixels.values.dtype == np.uint8 else pixels.values
        path = files.named_by_content("colors", values[::-1])
        _images[key] = _Colors(path, len(values), pixels.srgb, has_associated_alpha(image))
    return _images[key]
