"""What materials ask for by name: attributes of meshes, and properties of objects and view layers.

No bpy here: evaluated Blender data comes in as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

_FIELDS = {"FLOAT_VECTOR": "vector", "FLOAT2": "vector", "FLOAT_COLOR": "color", "BYTE_COLOR": "color"}
_WIDTHS = {"FLOAT_VECTOR": 3, "FLOAT2": 2, "FLOAT_COLOR": 4, "BYTE_COLOR": 4, "INT32_2D": 2, "INT16_2D": 2}
_WIDTHS |= {"FLOAT": 1, "INT": 1, "INT8": 1, "BOOLEAN": 1, "QUATERNION": 4}
_RAW = {"BOOLEAN": bool, "INT": np.int32, "INT8": np.int32, "INT32_2D": np.int32, "INT16_2D": np.int32}

_ZERO = (0.0, 0.0, 0.0, 0.0)

DERIVED_KINDS = ("TANGENT", "POINTINESS", "ISLAND")
OBJECT_KINDS = ("OBJECT", "INSTANCER", "VIEW_LAYER")


class AttributeKey(NamedTuple):
    """What is asked for. `kind`: 'GEOMETRY', 'COLOR' (a color attribute; no name: the one that renders), or one of
    OBJECT_KINDS, or one of DERIVED_KINDS, which derived.py makes."""

    kind: str
    name: str = ""


class AttributeTable:
    """The attributes that a scene's materials ask for; the numbers are those of the core."""

    def __init__(self) -> None:
        self._index: dict[AttributeKey, int] = {}

    def index_of(self, key: AttributeKey) -> int:
        """The number of an attribute."""
        return self._index.setdefault(key, len(self._index))


class Corners(NamedTuple):
    """Where the corners (m, 3) of a mesh's triangles are in its loops, vertices and polygons."""

    loops: np.ndarray
    vertices: np.ndarray
    polygons: np.ndarray


def read_mesh_attribute(obj: Any, key: AttributeKey, corners: Corners) -> np.ndarray | None:
    """The values (m, 3, components) float32 of an attribute of an evaluated mesh object; None if it has none that
    Cycles would find. What is not finite is 0."""
    mesh = obj.data
    if key.kind == "COLOR" and not key.name:
        index = mesh.color_attributes.render_color_index
        attribute = mesh.color_attributes[index] if 0 <= index < len(mesh.color_attributes) else None
    else:
        attribute = mesh.attributes.get(key.name)
    if attribute is None:
        return _vertex_group(obj, key.name, corners) if key.kind == "GEOMETRY" else None
    if attribute.data_type not in _WIDTHS:
        return None
    values, domain = _values(attribute), attribute.domain
    if domain == "EDGE":
        values, domain = _points_from_edges(mesh, values, attribute.data_type), "POINT"
    places = {"POINT": corners.vertices, "CORNER": corners.loops, "FACE": corners.polygons}[domain]
    return np.ascontiguousarray(values[places])


def _values(attribute: Any) -> np.ndarray:
    """(n, components) float32, one row for each element of its domain."""
    width = _WIDTHS[attribute.data_type]
    raw = np.empty(len(attribute.data) * width, _RAW.get(attribute.data_type, np.float32))
    attribute.data.foreach_get(_FIELDS.get(attribute.data_type, "value"), raw)
    return np.nan_to_num(raw.astype(np.float32), posinf=0, neginf=0).reshape(-1, width)


def _points_from_edges(mesh: Any, values: np.ndarray, data_type: str) -> np.ndarray:
    """The mean over each vertex' edges, as Blender takes it: whole numbers stay whole, of switches any is enough."""
    ends = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", ends)
    sums, counts = np.zeros((len(mesh.vertices), values.shape[1])), np.zeros((len(mesh.vertices), 1))
    np.add.at(sums, ends, np.repeat(values, 2, axis=0))
    np.add.at(counts, ends, 1)
    means = sums / np.maximum(counts, 1)
    if data_type == "BOOLEAN":
        means = means > 0
    elif data_type in _RAW:
        means = np.sign(means) * np.floor(np.abs(means) + 0.5)
    return means.astype(np.float32)


def _vertex_group(obj: Any, name: str, corners: Corners) -> np.ndarray | None:
    """The weights of a vertex group, which Blender has as an attribute too."""
    group = obj.vertex_groups.get(name)
    if group is None:
        return None
    weights = np.zeros(len(obj.data.vertices), np.float32)
    for i, vertex in enumerate(obj.data.vertices):
        weights[i] = next((place.weight for place in vertex.groups if place.group == group.index), 0.0)
    return np.ascontiguousarray(weights[corners.vertices][..., None])


def read_object_attribute(instance: Any, scene: Any, view_layer: Any, key: AttributeKey) -> tuple[float, ...]:
    """Four numbers: the property of that name, custom or Blender's own, of the first that has one: for 'OBJECT' the
    object and its data, for 'INSTANCER' before those what instances it, for 'VIEW_LAYER' the view layer and the scene.
    Zero if none has; so a color attribute is too where the mesh has none."""
    if key.kind == "COLOR":
        return _ZERO
    if key.kind == "VIEW_LAYER":
        owners = [view_layer, scene]
    else:
        owners = [instance.object, instance.object.data]
        if key.kind == "INSTANCER" and instance.is_instance and instance.parent:
            owners[:0] = [instance.parent, instance.parent.data]
    for owner in owners:
        value = None if owner is None else _property(owner, key.name)
        if value is not None:
            return value
    return _ZERO


def _property(owner: Any, name: str) -> tuple[float, ...] | None:
    readers: tuple[Callable[[], Any], ...] = (lambda: owner[name], lambda: owner.path_resolve(name))
    for read in readers:
        try:
            value = np.atleast_1d(np.asarray(read(), np.float64))
        except (KeyError, ValueError, TypeError, AttributeError):
            continue
        if value.ndim == 1 and 1 <= len(value) <= 4 and np.isfinite(value).all():
            padded = [*value, 0.0, 0.0][:3] if len(value) > 1 else [value[0]] * 3
            return (*padded, value[3] if len(value) == 4 else 1.0)
    return None
