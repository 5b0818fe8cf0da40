"""The stars of a Blender world, as directions and light."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from ..report import RenderError, told
from .scene_data import StarData
from .star_catalog import Stars, procedural, read_catalog, temperature_k
from .thermal import blackbody_rgb

_MAGNITUDE_0 = 1e-6  # irradiance of a star of magnitude 0 at strength 1, where a sun of strength 1 has 1


def read_stars(world: bpy.types.World | None) -> StarData | None:
    """What a world's settings say; None if there are no stars. Raises RenderError for a catalog that is none."""
    if world is None or world.bentlight.stars == "OFF":
        return None
    settings = world.bentlight
    stars = _read_catalog(world) if settings.stars == "CATALOG" else _make(settings)
    rotation = np.array(settings.star_rotation.to_matrix(), np.float64)
    brightness = settings.star_strength * _MAGNITUDE_0 * 10 ** (-0.4 * stars.magnitudes)
    colors = blackbody_rgb(temperature_k(stars.color_indices), bpy.app.version)
    return StarData(stars.directions @ rotation.T, brightness[:, None] * colors)


def _make(settings: bpy.types.PropertyGroup) -> Stars:
    return procedural(settings.star_count, settings.star_seed, settings.star_brightest, settings.star_slope)


def _read_catalog(world: bpy.types.World) -> Stars:
    title = told("World '{}': the catalog of stars", world.name)
    if not world.bentlight.star_catalog:
        raise RenderError("{}: no file is chosen", title)
    path = Path(bpy.path.abspath(world.bentlight.star_catalog, library=world.library))
    try:
        return read_catalog(path)
    except OSError as error:
        raise RenderError("{} '{}' cannot be read ({})", title, path.name, error.strerror) from error
    except ValueError as error:
        raise RenderError("{} '{}': {}", title, path.name, error) from error
