"""Blender's camera as the core wants it: the window on the image plane, as Cycles lays it."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import bpy
import numpy as np
from bentlight_native import Aperture

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
_MILLIMETER = 1e-3  # scene units, whatever the scene's scale is: as in Cycles
_LEAST_FSTOP, _LEAST_DISTANCE = 1e-5, 1e-6


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
        raise RenderError("Camera '{}': lens type {} is not supported", camera.name, lens.type)
    plane = _image_plane(lens, width * render.pixel_aspect_x, height * render.pixel_aspect_y)
    world_from_camera = _without_scale(camera.name, world_from_camera)
    return CameraData(
        kind=kind,
        world_from_camera=world_from_camera,
        width=width,
        height=height,
        window=_window(lens, plane, shift_x),
        clip_start=lens.clip_start,
        clip_end=lens.clip_end,
        panorama=_panorama(lens, plane) if lens.type == "PANO" else {},
        aperture=_aperture(lens, world_from_camera) if lens.dof.use_dof else None,
    )


class View(NamedTuple):
    """How Blender draws a viewport: its size in pixels, matrices, and the distances at which it clips."""

    size: tuple[int, int]
    view_matrix: np.ndarray  # (4, 4), camera from world
    window_matrix: np.ndarray  # (4, 4) of OpenGL; has lens, shift, and zoom and offset of the camera's view
    clip: tuple[float, float]


def read_free_view(view: View) -> CameraData:
    """The camera of a viewport that looks through none."""
    (width, height), matrix = view.size, view.window_matrix
    is_perspective = matrix[3, 3] == 0
    scale = np.array([matrix[0, 0], matrix[1, 1]])
    middle = np.array([matrix[0, 2], matrix[1, 2]] if is_perspective else -matrix[:2, 3]) / scale
    (left, bottom), (right, top) = middle - 1 / scale, middle + 1 / scale
    return CameraData(
        kind="PERSPECTIVE" if is_perspective else "ORTHOGRAPHIC",
        world_from_camera=_without_scale("of the viewport", np.linalg.inv(view.view_matrix)),
        width=width,
        height=height,
        window=(float(left), float(right), float(bottom), float(top)),
        clip_start=view.clip[0],
        clip_end=view.clip[1],
    )


def camera_frame(camera: bpy.types.Object, scene: bpy.types.Scene, view: View) -> tuple[float, float, float, float]:
    """Where in a viewport that looks through a camera its picture is: left, right, bottom, top in [0, 1] of the
    viewport, or outside."""
    corners = np.array([[*corner, 1.0] for corner in camera.data.view_frame(scene=scene)]) @ view.window_matrix.T
    places = 0.5 + 0.5 * corners[:, :2] / corners[:, 3:]
    (left, bottom), (right, top) = places.min(axis=0), places.max(axis=0)
    return float(left), float(right), float(bottom), float(top)


def framed(camera: CameraData, size: tuple[int, int], part: tuple[float, float, float, float]) -> CameraData:
    """A camera that takes another picture of that size, in the same direction: left, right, bottom and top are where
    its edges are, the old picture's being 0 and 1."""
    left, right, bottom, top = camera.window
    x, y = right - left, top - bottom
    window = (left + part[0] * x, left + part[1] * x, bottom + part[2] * y, bottom + part[3] * y)
    return dataclasses.replace(camera, width=size[0], height=size[1], window=window)


def _without_scale(name: str, matrix: np.ndarray) -> np.ndarray:
    """Cycles ignores a camera's scale; shear stays."""
    matrix = np.array(matrix, dtype=np.float64, order="C")
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.isfinite(matrix).all() or not (lengths > 0).all():
        raise RenderError("Camera '{}' has a transform that is not finite or has no size", name)
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


def _aperture(lens: bpy.types.Camera, world_from_camera: np.ndarray) -> Aperture:
    """The opening for depth of field, as Cycles has it."""
    dof = lens.dof
    length = 1.0 if lens.type == "ORTHO" else lens.lens * _MILLIMETER
    radius = length / (2 * max(dof.aperture_fstop, _LEAST_FSTOP))
    distance = dof.focus_distance
    if dof.focus_object is not None:
        way = _focus(dof) - world_from_camera[:3, 3]
        distance = abs(float(way @ world_from_camera[:3, 2]))
    distance = max(distance, _LEAST_DISTANCE)
    return Aperture(radius, distance, dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio)


def _focus(dof: bpy.types.CameraDOFSettings) -> np.ndarray:
    """World position of the object to focus on, or of its bone."""
    matrix, target = dof.focus_object.matrix_world, dof.focus_object.pose
    bone = target.bones.get(dof.focus_subtarget) if target and dof.focus_subtarget else None
    return np.array((matrix @ bone.matrix if bone else matrix).translation, np.float64)
