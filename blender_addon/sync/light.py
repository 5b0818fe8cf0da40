"""Blender's lamps as Cycles means them: which become bodies of light that rays pass, which points, which suns.

A point or spot light with a radius is a sphere; with "Soft Falloff" Cycles uses a disk that faces the shaded point,
which the sphere's program imitates. Area lights shine on one side. Without a size a point or spot light is a point, a
sun a point of the sky. What they send where is in lamp_program.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..report import Reporter
from .lamp_mesh import polygon, sphere
from .lamp_program import compile_lamp, compile_sun, sun_radiance
from .material import MaterialTable, node_tree
from .scene_data import MeshData, SunData

_SINGULAR = 1e-6  # of the volume of the box that a matrix's columns could span
_OUTLINES = {
    "SQUARE": np.array([[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]]),  # clockwise from +z: the normal is -z
    "DISK": polygon(64),
}
_OUTLINES |= {"RECTANGLE": _OUTLINES["SQUARE"], "ELLIPSE": _OUTLINES["DISK"]}


@dataclass
class LampShape:
    """A lamp's surface in its own axes."""

    mesh: MeshData
    one_sided: bool


def is_point(light: bpy.types.Light) -> bool:
    """Whether a lamp has no size."""
    return light.type in {"POINT", "SPOT"} and light.shadow_soft_size <= 0


def lamp_axes(light: bpy.types.Light, world_from_light: np.ndarray) -> np.ndarray | None:
    """The matrix of a lamp (4, 4), invertible: however small an object is scaled, its lamp shines, and along its z axis
    while it has one. None for an area light without an area, which is dark."""
    axes = world_from_light[:3, :3]
    if abs(np.linalg.det(axes)) > _SINGULAR * np.prod(np.linalg.norm(axes, axis=0)):
        return world_from_light
    if light.type == "AREA":
        return None
    matrix = np.eye(4)
    matrix[:3, 3] = world_from_light[:3, 3]
    if np.linalg.norm(axes[:, 2]) > 0:
        matrix[:3, :3] = _basis(axes[:, 2])
    return matrix


def read_shape(light: bpy.types.Light, axes: np.ndarray) -> LampShape | None:
    """A lamp that has a size; None for an area light whose size is 0."""
    if light.type != "AREA":
        return LampShape(sphere(light.shadow_soft_size, axes[:3, :3]), one_sided=False)
    size = _area_size(light)
    if not min(size) > 0:
        return None
    outline = _OUTLINES[light.shape]
    n = len(outline)
    triangles = np.stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)], axis=1).astype(np.uint32)
    vertices = np.column_stack([outline * size, np.zeros(n)]).astype(np.float32)
    uvs = (outline + 0.5)[triangles].astype(np.float32)
    return LampShape(MeshData(vertices, triangles, corner_uvs=uvs), one_sided=True)


def read_material(light: bpy.types.Light, axes: np.ndarray, materials: MaterialTable, reporter: Reporter) -> int:
    """The index of the material of a lamp that is not a sun."""
    area = 1.0
    if light.type == "AREA":
        area = np.prod(_area_size(light)) * np.prod(np.linalg.norm(axes[:3, :2], axis=0))
        area *= np.pi / 4 if light.shape in {"DISK", "ELLIPSE"} else 1.0
    elif light.shadow_soft_size > 0:
        area = 4 * np.pi * light.shadow_soft_size**2
    else:
        area = 4.0  # Cycles: what makes the intensity of a point its power / (4 pi)
    return materials.add(compile_lamp(light, area if light.normalize else 1.0, materials.image_table, reporter))


def read_sun(light: bpy.types.Light, world_from_light: np.ndarray, materials: MaterialTable) -> SunData:
    """A sun: radiance if it has an angle, else irradiance of what faces it."""
    matrix = lamp_axes(light, world_from_light)
    axis = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    angle = min(max(light.angle, 0.0), np.pi)
    solid = np.pi * np.sin(angle / 2) ** 2 if light.normalize and angle > 0 else 1.0
    sun = SunData(tuple(axis), tuple(sun_radiance(light, 1 / solid)), angle, world_from_sun=matrix)
    if node_tree(light) is not None:
        sun.material = materials.add(compile_sun(light, 1 / solid, materials.image_table))
    return sun


def _area_size(light: bpy.types.AreaLight) -> np.ndarray:
    return np.array([light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size])


def _basis(z: np.ndarray) -> np.ndarray:
    """Orthonormal columns of which the last is along z."""
    z = z / np.linalg.norm(z)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)
