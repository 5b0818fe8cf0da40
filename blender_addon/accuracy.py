"""How exact rays are: one choice for users that stands for scene.bentlight.tolerance, and what it means in pixels."""

from __future__ import annotations

import functools
import math

import bentlight_native
import bpy
import numpy as np

from .report import RenderError
from .sync.camera import read_camera
from .sync.scene_data import CameraData

TOLERANCES = {"PREVIEW": 1e-3, "PRODUCTION": 1e-4, "REFERENCE": 1e-6}  # radians
CHOICES = (*TOLERANCES, "CUSTOM")
_PART_OF_PIXEL = 0.1  # the core traces camera rays at least as exactly: bentlight/render.h, "Tolerance"


def choice_of(tolerance: float) -> str:
    """The choice that has this tolerance, or CUSTOM. Properties are float32."""
    found = (name for name, value in TOLERANCES.items() if math.isclose(tolerance, value, rel_tol=1e-6))
    return next(found, "CUSTOM")


def error_in_pixels(tolerance: float, camera: CameraData) -> float | None:
    """Largest error of a camera ray's direction, in pixels of the picture's middle; None if pixels have no angle."""
    angle = _pixel_angle(camera.kind, camera.width, camera.window, tuple(camera.panorama.items()))
    return min(tolerance / angle, _PART_OF_PIXEL) if angle > 0 else None


def scene_error_in_pixels(scene: bpy.types.Scene) -> float | None:
    """The same for the scene's camera. Raises RenderError for a lens that is not supported."""
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        return None
    return error_in_pixels(scene.bentlight.tolerance, read_camera(camera, scene.render, np.eye(4), camera.data.shift_x))


@functools.lru_cache(maxsize=16)
def _pixel_angle(
    kind: str, width: int, window: tuple[float, float, float, float], lens: tuple[tuple[str, float], ...]
) -> float:
    """Between rays through the middle of the picture and one pixel beside it, radians, as the core has them."""
    scene = bentlight_native.Scene()
    try:
        scene.set_camera(kind, np.eye(4), window, 0.1, 1.0, **dict(lens))
    except ValueError as error:
        raise RenderError(str(error)) from error
    scene.commit()
    a, b = scene.camera_rays([[0.5, 0.5], [0.5 + 1 / width, 0.5]]).directions
    return float(np.linalg.norm(a - b))
