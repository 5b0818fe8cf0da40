"""Blender's camera as the core wants it: the window on the image plane, as Cycles lays it."""

from __future__ import annotations

import bpy
import numpy as np

from ..report import RenderError
from .scene_data import CameraData

# The lens of each panorama: Blender's properties by name.
_PANORAMA_PROPERTIES = {
    "EQUIRECTANGULAR": ("latitude_min", "latitude_max", "longitude_min", "longitude_max"),
    "EQUIANGULAR_CUBEMAP_FACE": (),
    "MIRRORBALL": (),
    "FISHEYE_EQUIDISTANT": ("fisheye_fov",),
    "FISHEYE_EQUISOLID": ("fisheye_fov", "fisheye_lens"),
    "FISHEYE_LENS_POLYNOMIAL": ("fisheye_fov", *(f"fisheye_polynomial_k{i}" for i in range(5))),
    "CENTRAL_CYLINDRICAL": (
        "central_cylindrical_range_u_min", "central_cylindrical_range_u_max",
        "central_cylindrical_range_v_min", "central_cylindrical_range_v_max", "central_cylindrical_radius",
    ),
}  # fmt: skip


def image_size(render: bpy.types.RenderSettings) -> tuple[int, int]:
    """Width and height of the whole image in pixels, border or not, as Blender rounds them."""
    return (
        max(1, render.resolution_x * render.resolution_percentage // 100),
        max(1, render.resolution_y * render.resolution_percentage // 100),
    )


def read_camera(
    camera: bpy.types.Object,
    render: bpy.types.RenderSettings,
    world_from_camera: np.ndarray,
    shift_x: float,
) -> CameraData:
    """The camera of an evaluated camera object.

    `world_from_camera` and `shift_x` are what the render engine gives for the current (stereo) view.
    """
    lens = camera.data
    width, height = image_size(render)
    kind = {"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC", "PANO": getattr(lens, "panorama_type", "")}.get(lens.type)
    if kind is None or (lens.type == "PANO" and kind not in _PANORAMA_PROPERTIES):
        raise RenderError(f"Camera '{camera.name}': lens type {lens.type} is not supported")
    plane = _image_plane(lens, width * render.pixel_aspect_x, height * render.pixel_aspect_y)
    return CameraData(
        kind=kind,
        world_from_camera=_without_scale(camera.name, world_from_camera),
        width=width,
        height=height,
        window=_window(lens, plane, shift_x),
        clip_start=lens.clip_start,
        clip_end=lens.clip_end,
        panorama=_panorama(lens, plane) if lens.type == "PANO" else {},
    )


def _without_scale(name: str, matrix: np.ndarray) -> np.ndarray:
    """Cycles ignores a camera's scale; shear stays."""
    matrix = np.array(matrix, dtype=np.float64, order="C")
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.isfinite(matrix).all() or not (lengths > 0).all():
        raise RenderError(f"Camera '{name}' has a transform that is not finite or has no size")
    matrix[:3, :3] /= lengths
    return matrix


def _image_plane(lens: bpy.types.Camera, width: float, height: float) -> tuple[float, float, float]:
    """The sensor's size along the side that is fitted, and the image's sides in units of that side.

    `width` and `height` are the image's, in units of the shape of a pixel.
    """
    horizontal = lens.sensor_fit == "HORIZONTAL" or (lens.sensor_fit == "AUTO" and width > height)
    sensor = lens.sensor_height if lens.sensor_fit == "VERTICAL" else lens.sensor_width
    fitted = width if horizontal else height
    return sensor, width / fitted, height / fitted


def _window(lens: bpy.types.Camera, plane: tuple[float, float, float], shift_x: float) -> tuple[float, ...]:
    """left, right, bottom, top; see CameraData. Shift counts in fitted sides, in a panorama in whole images."""
    shift = np.array([shift_x, shift_x, lens.shift_y, lens.shift_y])
    if lens.type == "PANO":
        return tuple(np.array([0.0, 1.0, 0.0, 1.0]) + shift)
    sensor, x, y = plane
    size = lens.ortho_scale if lens.type == "ORTHO" else sensor / lens.lens
    return tuple(size * (np.array([-x, x, -y, y]) / 2 + shift))


def _panorama(lens: bpy.types.Camera, plane: tuple[float, float, float]) -> dict[str, float]:
    sensor, x, y = plane
    values = {name: float(getattr(lens, name)) for name in _PANORAMA_PROPERTIES[lens.panorama_type]}
    if lens.panorama_type in {"FISHEYE_EQUISOLID", "FISHEYE_LENS_POLYNOMIAL"}:
        values |= {"sensor_width": sensor * x, "sensor_height": sensor * y}
    return values
