"""Lamps as what a path tracer without light sampling can see: emissive meshes and disks in the sky.

Radiances are those of Cycles, with E the lamp's color times its power: an area light E/(pi A), a point or spot light of
radius r E/(4 pi^2 r^2), a sun of angular diameter a E/(pi sin^2(a/2)); without "Normalize" an area light and a point
light are E/pi, a sun is E. A point light is a sphere; with "Soft Falloff" Cycles uses a disk that faces the shaded
point, which gives less light near by: by the factor 1/(1 + (r/distance)^2).
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..report import Reporter
from .scene_data import MeshData, SunData, Visibility

_DISK_SIDES = 64
_SPHERE_SUBDIVISIONS = 3
_STAND_IN_ANGLE = np.radians(120)


@dataclass
class LightShape:
    """A lamp as a mesh that emits the same radiance everywhere, from its front (one_sided) or all around."""

    mesh: MeshData
    world_from_mesh: np.ndarray
    radiance: np.ndarray  # (3,)
    one_sided: bool


def needs_light_sampling(light: bpy.types.Light) -> bool:
    """Whether only light sampling could find this lamp: it has no size."""
    if light.type == "SUN":
        return light.angle <= 0
    return light.type in {"POINT", "SPOT"} and light.shadow_soft_size <= 0


def read_sun(light: bpy.types.Light, world_from_light: np.ndarray, reporter: Reporter) -> SunData:
    """A sun that has an angle: the disk that it is in the sky."""
    axis = world_from_light[:3, 2] / np.linalg.norm(world_from_light[:3, 2])
    angle = min(light.angle, np.pi)
    irradiance_factor = np.pi * np.sin(angle / 2) ** 2 if light.normalize else 1.0
    radiance = _strength(light, reporter) / irradiance_factor
    return SunData(direction=tuple(axis), radiance=tuple(radiance), angle=angle)


def read_distant(light: bpy.types.Light, world_from_light: np.ndarray, reporter: Reporter) -> SunData:
    """A stand-in for a small area light: wide and far away, with the same light at the origin if it faces that."""
    place = world_from_light[:3, 3]
    distance = max(np.linalg.norm(place), 1e-3)
    irradiance = _strength(light, reporter) / (np.pi * distance**2)
    radiance = irradiance / (np.pi * np.sin(_STAND_IN_ANGLE / 2) ** 2)
    return SunData(tuple(place / distance), tuple(radiance), _STAND_IN_ANGLE, Visibility.ALL & ~Visibility.CAMERA)


def read_shape(light: bpy.types.Light, world_from_light: np.ndarray, reporter: Reporter) -> LightShape | None:
    """An area, point or spot light that has a size; None for an area light without one."""
    if light.type == "AREA":
        return _area(light, world_from_light, reporter)
    radius = light.shadow_soft_size
    if light.type == "SPOT":
        reporter.warn(f"Light '{light.name}': the cone of a spot light is not supported yet; it shines all around")
    world_from_mesh = np.eye(4)
    world_from_mesh[:3, 3] = world_from_light[:3, 3]
    area = 4 * np.pi * radius**2 if light.normalize else 1.0
    radiance = _strength(light, reporter) / (np.pi * area)
    return LightShape(_sphere(radius), world_from_mesh, radiance, one_sided=False)


def _strength(light: bpy.types.Light, reporter: Reporter) -> np.ndarray:
    """Color times power: watts, or for a sun watts per square meter."""
    strength = np.array(light.color, dtype=np.float64) * light.energy * 2.0**light.exposure
    if light.use_temperature:
        strength *= np.array(light.temperature_color)
    if light.use_nodes and light.node_tree:
        strength *= _node_factor(light, reporter)
    return strength


def _node_factor(light: bpy.types.Light, reporter: Reporter) -> np.ndarray:
    """What an unlinked Emission node at the output multiplies a lamp by; anything else is reported and counts as 1."""
    output = light.node_tree.get_output_node("CYCLES")
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    if node is None:
        return np.zeros(3)
    if node.type == "EMISSION" and not any(socket.is_linked for socket in node.inputs):
        return np.array(node.inputs["Color"].default_value[:3]) * node.inputs["Strength"].default_value
    reporter.warn(f"Light '{light.name}': node '{node.name}' is not supported; the lamp's own color is used")
    return np.ones(3)


def _area(light: bpy.types.Light, world_from_light: np.ndarray, reporter: Reporter) -> LightShape | None:
    if light.spread < np.pi * (1 - 1e-6):
        reporter.warn(
            f"Light '{light.name}': the spread of an area light is not supported yet; it shines at 180 degrees"
        )
    size_y = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    axes = world_from_light[:3, :3]
    width, height = light.size * np.linalg.norm(axes[:, 0]), size_y * np.linalg.norm(axes[:, 1])
    round_shape = light.shape in {"DISK", "ELLIPSE"}
    area = width * height * (np.pi / 4 if round_shape else 1)
    if not area > 0:
        return None
    outline = _disk_outline() if round_shape else np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    vertices = outline @ (axes[:, :2] * [light.size, size_y]).T
    world_from_mesh = np.eye(4)
    world_from_mesh[:3, 3] = world_from_light[:3, 3]
    facing_back = np.cross(axes[:, 0], axes[:, 1]) @ axes[:, 2] > 0  # the lamp shines along -z
    mesh = _fan(vertices if not facing_back else vertices[::-1])
    radiance = _strength(light, reporter) / (np.pi * (area if light.normalize else 1.0))
    return LightShape(mesh, world_from_mesh, radiance, one_sided=True)


def _disk_outline() -> np.ndarray:
    """A regular polygon with the area of a disk of diameter 1."""
    angles = np.arange(_DISK_SIDES) * (2 * np.pi / _DISK_SIDES)
    step = 2 * np.pi / _DISK_SIDES
    radius = 0.5 * np.sqrt(step / np.sin(step))
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _fan(outline: np.ndarray) -> MeshData:
    """A convex polygon; its normal is that of its vertices taken counterclockwise."""
    n = len(outline)
    triangles = np.stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    return MeshData(np.ascontiguousarray(outline, dtype=np.float32), triangles.astype(np.uint32))


def _sphere(radius: float) -> MeshData:
    """An icosphere with the surface area, and so (Cauchy) the mean silhouette, of a sphere."""
    vertices, triangles = _icosahedron()
    for _ in range(_SPHERE_SUBDIVISIONS):
        vertices, triangles = _subdivide(vertices, triangles)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    scaled = vertices * (radius * np.sqrt(4 * np.pi / area))
    return MeshData(scaled.astype(np.float32), triangles.astype(np.uint32))


def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    golden = (1 + np.sqrt(5)) / 2
    square = np.array([[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0]])
    vertices = np.concatenate([square, np.roll(square, 1, axis=1), np.roll(square, 2, axis=1)])
    edge = 2.0
    distance = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    near = distance < edge * 1.01
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    triangles = np.array(faces)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return vertices / np.linalg.norm(vertices[0]), triangles


def _subdivide(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle in four, the new vertices on the unit sphere."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].sum(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    ab, bc, ca = inverse.reshape(3, -1) + len(vertices)
    a, b, c = triangles.T
    split = [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate([vertices, middle]), np.concatenate(split)
