"""The shapes of lamps: spheres, and polygons that stand for disks. No bpy here."""

from __future__ import annotations

import functools

import numpy as np

from .scene_data import MeshData

_SUBDIVISIONS = 3


def polygon(sides: int) -> np.ndarray:
    """A regular polygon (sides, 2), clockwise, with the area of a disk of diameter 1."""
    angles = -np.arange(sides) * (2 * np.pi / sides)
    step = 2 * np.pi / sides
    radius = 0.5 * np.sqrt(step / np.sin(step))
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def sphere(radius: float, axes: np.ndarray) -> MeshData:
    """An icosphere that is round in the world when its own axes are drawn as the columns of `axes` (3, 3)."""
    vertices, triangles, grown = _icosphere()
    inverse = np.linalg.inv(axes)
    normals = vertices @ axes  # covectors: by the transpose
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    if np.linalg.det(axes) < 0:
        triangles = triangles[:, ::-1]
    return MeshData(
        np.ascontiguousarray(vertices * (grown * radius) @ inverse.T, dtype=np.float32),
        np.ascontiguousarray(triangles, dtype=np.uint32),
        corner_normals=np.ascontiguousarray(normals[triangles], dtype=np.float32),
    )


@functools.cache
def _icosphere() -> tuple[np.ndarray, np.ndarray, float]:
    """Unit vertices, triangles, and what makes its area, and so (Cauchy) its mean outline, that of the unit sphere."""
    vertices, triangles = _icosahedron()
    for _ in range(_SUBDIVISIONS):
        vertices, triangles = _subdivide(vertices, triangles)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    return vertices, triangles, np.sqrt(4 * np.pi / area)


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
