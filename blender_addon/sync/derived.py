"""What Cycles makes of a mesh for materials that ask: tangents, pointiness, random numbers of islands."""

from __future__ import annotations

from typing import Any

import numpy as np

from .attributes import Corners
from .hashing import WORD, hash_words


def read_derived(mesh: Any, kind: str, name: str, corners: Corners) -> np.ndarray | None:
    """(m, 3, components) float32 for 'TANGENT' of the UV map `name` (none: the active one), 'POINTINESS' or 'ISLAND';
    None if there is nothing to make it of."""
    if kind == "TANGENT":
        return _tangents(mesh, name, corners)
    values = _pointiness(mesh) if kind == "POINTINESS" else _island_numbers(mesh)
    places = corners.vertices if kind == "POINTINESS" else np.repeat(corners.vertices[:, :1], 3, axis=1)
    return np.ascontiguousarray(values[places][..., None], dtype=np.float32)


def _get(collection: Any, name: str, width: int, dtype: type = np.float32) -> np.ndarray:
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)


def _normalized(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def _same(values: np.ndarray) -> np.ndarray:
    """Numbers rows such that equal ones have the same number."""
    return np.unique(values + 0.0, axis=0, return_inverse=True)[1].reshape(-1)  # -0 is 0


def _tangents(mesh: Any, name: str, corners: Corners) -> np.ndarray | None:
    """Unit tangents and their signs, (m, 3, 4): Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008).

    Where place, normal and UV of corners are the same, so are their tangents, if the UV maps of the triangles are not
    mirrored: the mean of the triangles' own, put at right angles to the normal and weighed by the angle at the corner.
    Unlike there, triangles that only meet in a point count too.
    """
    layer = mesh.uv_layers.get(name) if name else next((x for x in mesh.uv_layers if x.active_render), None)
    if layer is None:
        return None
    place = _get(mesh.vertices, "co", 3)[corners.vertices].astype(np.float64)
    normal = _get(mesh.corner_normals, "vector", 3)[corners.loops].astype(np.float64)
    uv = _get(layer.uv, "vector", 2)[corners.loops].astype(np.float64)
    edges, steps = place[:, 1:] - place[:, :1], uv[:, 1:] - uv[:, :1]
    area = steps[:, 0, 0] * steps[:, 1, 1] - steps[:, 0, 1] * steps[:, 1, 0]
    sign = np.where(area > 0, 1.0, -1.0)
    along = (edges[:, 0] * steps[:, 1, 1:] - edges[:, 1] * steps[:, 0, 1:]) * sign[:, None]
    flat = normal * np.einsum("mck,mk->mc", normal, along)[..., None]
    own = _normalized(along[:, None] - flat)
    own *= _corner_angles(place, normal)[..., None]
    own[area == 0] = 0
    keys = np.concatenate([place, normal, uv, np.repeat(sign[:, None, None], 3, axis=1)], axis=2)
    same = _same(keys.reshape(-1, 9).astype(np.float32))
    sums = np.stack([np.bincount(same, own[..., k].ravel()) for k in range(3)], axis=1)
    tangents = _normalized(sums)[same].reshape(-1, 3, 3)
    return np.concatenate([tangents, np.repeat(sign[:, None, None], 3, axis=1)], axis=2).astype(np.float32)


def _corner_angles(place: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Angles (m, 3) of triangles at their corners, seen along the normals there."""
    sides = []
    for other in (1, 2):
        side = np.roll(place, -other, axis=1) - place
        sides.append(_normalized(side - normal * np.einsum("mck,mck->mc", normal, side)[..., None]))
    return np.arccos(np.clip(np.einsum("mck,mck->mc", *sides), -1, 1))


def _pointiness(mesh: Any) -> np.ndarray:
    """For each vertex (n,) the angle, over pi, between its normal and the mean direction of its edges, blurred once
    over its neighbors. Vertices in the same place count as one."""
    place = _get(mesh.vertices, "co", 3)
    same = _same(place)
    count = int(same.max(initial=-1)) + 1
    center = np.zeros((count, 3))
    center[same] = place
    normal = np.zeros((count, 3))
    np.add.at(normal, same, _get(mesh.vertex_normals, "vector", 3))
    ends = np.unique(np.sort(same[_get(mesh.edges, "vertices", 2, np.int32)], axis=1), axis=0).reshape(-1, 2)
    both = np.concatenate([ends, ends[:, ::-1]])
    towards, neighbors = np.zeros((count, 3)), np.bincount(both[:, 0], minlength=count)
    np.add.at(towards, both[:, 0], _normalized(center[both[:, 1]] - center[both[:, 0]]))
    cosine = np.einsum("nk,nk->n", _normalized(normal), towards) / np.maximum(neighbors, 1)
    raw = np.where(neighbors > 0, np.arccos(np.clip(cosine, -1, 1)) / np.pi, 0)
    blurred = raw + np.bincount(both[:, 0], raw[both[:, 1]], minlength=count)
    return (blurred / (neighbors + 1))[same]


def _island_numbers(mesh: Any) -> np.ndarray:
    """For each vertex (n,) the random number of those that edges join it with: of the one that stands for them in
    Cycles, which joins by rank."""
    parent, rank = list(range(len(mesh.vertices))), [0] * len(mesh.vertices)

    def find(x: int) -> int:
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x

    for first, second in _get(mesh.edges, "vertices", 2, np.int32).tolist():
        a, b = find(first), find(second)
        if a == b:
            continue
        if rank[a] < rank[b]:
            a, b = b, a
        parent[b] = a
        rank[a] += rank[a] == rank[b]
    roots = np.array([find(x) for x in range(len(parent))], np.int64)
    unique, which = np.unique(roots, return_inverse=True)
    return np.array([hash_words(int(root)) / WORD for root in unique], np.float32)[which.reshape(-1)]
