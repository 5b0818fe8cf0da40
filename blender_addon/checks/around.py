"""Whether an opaque mesh all around a black hole or wormhole hides it from the camera, as a cube does into which one
has been added at the 3D cursor."""

from __future__ import annotations

import itertools

import bpy
import mathutils

# To the middles of a cube's faces, edges and corners: a mesh that all of them meet has no window to speak of.
_DIRECTIONS = [mathutils.Vector(signs) for signs in itertools.product((-1, 0, 1), repeat=3) if any(signs)]
_SEE_THROUGH = {"BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION", "HOLDOUT", "GROUP"}


def hides(obj: bpy.types.Object, place: mathutils.Vector, eye: mathutils.Vector) -> bool:
    """Whether an evaluated mesh object is around `place`, and not around the camera's place `eye`, in the world."""
    if not obj.visible_camera or abs(obj.matrix_world.determinant()) < 1e-12:
        return False
    inverse = obj.matrix_world.inverted()
    center = inverse @ place
    if not _is_in_box(obj, center) or _is_in_box(obj, inverse @ eye):
        return False
    if any(_may_be_seen_through(slot.material) for slot in obj.material_slots):
        return False
    return all(obj.ray_cast(center, direction)[0] for direction in _DIRECTIONS)


def _is_in_box(obj: bpy.types.Object, point: mathutils.Vector) -> bool:
    """Whether a point in the object's own coordinates lies within its bounding box."""
    low, high = obj.bound_box[0], obj.bound_box[6]
    return all(low[axis] < point[axis] < high[axis] for axis in range(3))


def _may_be_seen_through(material: bpy.types.Material | None) -> bool:
    """Whether any node could let a camera ray pass."""
    if material is None or material.node_tree is None:
        return False
    return any(
        node.type in _SEE_THROUGH
        or (
            node.type == "BSDF_PRINCIPLED"
            and (_is_used(node, "Alpha", 1.0) or _is_used(node, "Transmission Weight", 0.0))
        )
        for node in material.node_tree.nodes
    )


def _is_used(node: bpy.types.Node, name: str, unused: float) -> bool:
    socket = node.inputs[name]
    return socket.is_linked or socket.default_value != unused
