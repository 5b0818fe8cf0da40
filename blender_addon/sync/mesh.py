"""Evaluated meshes as triangles.

Curves, text, surfaces and metaballs need nothing more: the depsgraph shows each once as itself and once as a mesh that
it instances.
"""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from .attributes import DERIVED_KINDS, AttributeKey, Corners, read_mesh_attribute
from .derived import read_derived
from .scene_data import MeshData

_FARTHEST = 1e18  # Embree is blind to what lies farther out
_THINNEST = 5e-7  # height over length of a triangle: less may be rounding of float32
_CHUNK = 4096  # triangles looked at in one go


def read_mesh(obj: bpy.types.Object, wanted: dict[int, AttributeKey]) -> MeshData:
    """The triangles of an evaluated mesh object, with the wanted attributes that it has."""
    mesh = obj.data
    mesh.calc_loop_triangles()
    loops = _get(mesh.loop_triangles, "loops", 3, np.int32)
    polygons = _get(mesh.loop_triangles, "polygon_index", 1, np.int32)
    vertices = _get(mesh.loops, "vertex_index", 1, np.int32)[loops]
    data = _triangles(mesh, loops, vertices, polygons)
    corners = Corners(loops, vertices, np.repeat(polygons[:, None], 3, axis=1))
    for number, key in wanted.items():
        is_derived = key.kind in DERIVED_KINDS
        values = read_derived(mesh, *key, corners) if is_derived else read_mesh_attribute(obj, key, corners)
        if values is not None:
            data.attributes[number] = values
    return data


def drop_broken_triangles(data: MeshData) -> int:
    """Takes out the triangles with a vertex that is not finite or too far out; returns how many there were."""
    usable = (np.abs(data.vertices) < _FARTHEST).all(axis=1)
    if usable.all():
        return 0
    keep = usable[data.triangles].all(axis=1)
    data.vertices[~usable] = 0
    data.triangles = data.triangles[keep]
    for name in ("corner_normals", "corner_uvs", "material_slots"):
        values = getattr(data, name)
        if values is not None:
            setattr(data, name, np.ascontiguousarray(values[keep]))
    data.attributes = {number: np.ascontiguousarray(values[keep]) for number, values in data.attributes.items()}
    return int((~keep).sum())


def has_area(data: MeshData, world_from_mesh: np.ndarray | None = None) -> bool:
    """Whether any triangle has an area to see, as it is or under a (4, 4) matrix."""
    vertices = data.vertices if world_from_mesh is None else data.vertices @ world_from_mesh[:3, :3].T
    for first in range(0, len(data.triangles), _CHUNK):
        corners = vertices[data.triangles[first : first + _CHUNK]].astype(np.float64)
        one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        if (np.linalg.norm(np.cross(one, other), axis=1) > _THINNEST * lengths).any():
            return True
    return False


def flattened(data: MeshData, world_from_mesh: np.ndarray) -> tuple[MeshData, np.ndarray]:
    """A mesh under a matrix that has no inverse, and one that has: its axes are applied to the vertices.

    Normals have no meaning then, so that faces are shaded flat.
    """
    translation = np.eye(4)
    translation[:3, 3] = world_from_mesh[:3, 3]
    vertices = np.ascontiguousarray(data.vertices @ world_from_mesh[:3, :3].T, dtype=np.float32)
    return replace(data, vertices=vertices, corner_normals=None), translation


def _get(collection: bpy.types.bpy_prop_collection, name: str, width: int, dtype: type) -> np.ndarray:
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def _triangles(mesh: bpy.types.Mesh, loops: np.ndarray, vertices: np.ndarray, polygons: np.ndarray) -> MeshData:
    """loops, vertices (m, 3), polygons (m,): of the triangles' corners, and of the triangles."""
    return MeshData(
        vertices=_get(mesh.vertices, "co", 3, np.float32),
        triangles=vertices.astype(np.uint32),
        corner_normals=_corner_normals(mesh, loops, vertices),
        corner_uvs=_corner_uvs(mesh, loops),
        material_slots=_material_slots(mesh, polygons),
        generated=_generated(mesh),
    )


def _corner_normals(mesh: bpy.types.Mesh, loops: np.ndarray, vertices: np.ndarray) -> np.ndarray | None:
    if mesh.normals_domain == "FACE":
        return None
    if mesh.normals_domain == "POINT":
        return _get(mesh.vertex_normals, "vector", 3, np.float32)[vertices]
    return _get(mesh.corner_normals, "vector", 3, np.float32)[loops]


def _corner_uvs(mesh: bpy.types.Mesh, loops: np.ndarray) -> np.ndarray | None:
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    return None if layer is None else _get(layer.uv, "vector", 2, np.float32)[loops]


def _material_slots(mesh: bpy.types.Mesh, polygons: np.ndarray) -> np.ndarray | None:
    if len(mesh.materials) < 2:
        return None
    slots = _get(mesh.polygons, "material_index", 1, np.int32)[polygons]
    return np.clip(slots, 0, len(mesh.materials) - 1).astype(np.uint32)


def _generated(mesh: bpy.types.Mesh) -> np.ndarray:
    """Undeformed positions in the mesh's texture space, whose box is [0, 1]."""
    size = np.array(mesh.texspace_size, dtype=np.float32)
    size = np.where(size == 0, np.float32(1), size)
    undeformed = _get(mesh.vertices, "undeformed_co", 3, np.float32)
    generated = (undeformed - np.array(mesh.texspace_location, dtype=np.float32)) / (2 * size) + np.float32(0.5)
    return np.ascontiguousarray(np.nan_to_num(generated, posinf=0, neginf=0), dtype=np.float32)
