"""One lens: a sphere parented to its hole, whose material bends what meets it."""

from __future__ import annotations

import bmesh
import bpy
import mathutils
import numpy as np

from ..sync import spacetime
from ..sync.scene_data import SpacetimeData
from . import disk_material, filtered_sky, shaders, tables

_SUBDIVISIONS = 5
_NAME = "Bentlight Lens"
_CHARTS = {"ISOTROPIC": 0, "OBLATE": 1}
_WORMHOLE = 2
_SOCKETS = disk_material.SOCKETS | filtered_sky.SOCKETS


def find(scene: bpy.types.Scene) -> dict[str, bpy.types.Object]:
    """The lenses of a scene by the names of their holes; "" for one that has lost its hole."""
    return {obj.parent.name if obj.parent else "": obj for obj in all_of(scene)}


def all_of(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The lenses of a scene, those that have lost their holes too."""
    return [obj for obj in scene.objects if obj.bentlight.made_for_cycles == "LENS"]


def build(hole: bpy.types.Object) -> bpy.types.Object:
    """A lens that is still to be updated, beside its hole in all its collections."""
    lens = bpy.data.objects.new(f"{_NAME} {hole.name}", _sphere())
    lens.bentlight.made_for_cycles = "LENS"
    lens.parent = hole
    lens.display_type, lens.display_bounds_type = "BOUNDS", "SPHERE"  # its fine mesh would be a black ball as wires
    lens.hide_select = True
    lens.data.materials.append(shaders.new_material(lens.name, "lens", _SOCKETS))
    for collection in hole.users_collection:
        collection.objects.link(lens)
    return lens


def _sphere() -> bpy.types.Mesh:
    """Just contains the sphere of radius 1: facets touch it from outside."""
    mesh, work = bpy.data.meshes.new(_NAME), bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=_SUBDIVISIONS, radius=1)
    nearest = min(face.calc_center_median().dot(face.normal) for face in work.faces)
    bmesh.ops.scale(work, vec=[1.00001 / nearest] * 3, verts=work.verts)
    work.to_mesh(mesh)
    work.free()
    return mesh


def remove(lens: bpy.types.Object) -> None:
    """With its mesh and its material."""
    for material in filter(None, lens.data.materials):
        disk_material.clear(material)
        filtered_sky.clear(material)
    shaders.remove(lens)


def remove_orphans(scene: bpy.types.Scene) -> None:
    """Lenses whose holes have been deleted."""
    for obj in all_of(scene):
        if not obj.parent:
            remove(obj)


def update(
    lens: bpy.types.Object,
    item: SpacetimeData,
    radius: float,
    far: tuple[SpacetimeData, float] | None,
    light: dict[str, shaders.Socket],
    soft_edge: float,
) -> None:
    """Makes a lens what its hole is now; `radius` and that of the other mouth are in world units."""
    scale = mathutils.Matrix.Scale(radius / item.scale, 4)
    if lens.matrix_parent_inverse != mathutils.Matrix.Identity(4):
        lens.matrix_parent_inverse.identity()
    if lens.matrix_basis != scale:
        lens.matrix_basis = scale
    inputs = _inputs(item, radius, far, _reach(lens.data), light | {"SoftEdge": ("NodeSocketFloat", soft_edge)})
    shaders.fill(lens.data.materials[0], "lens", inputs, _SOCKETS)


def _reach(mesh: bpy.types.Mesh) -> float:
    return max(vertex.co.length for vertex in mesh.vertices[:1])


def _inputs(
    item: SpacetimeData,
    radius: float,
    far: tuple[SpacetimeData, float] | None,
    reach: float,
    light: dict[str, shaders.Socket],
) -> dict[str, shaders.Socket]:
    """The shader's parameters: lengths in masses or throat radii, float32 as sockets are."""
    wormhole = item.kind == "WORMHOLE"
    unit = item.scale * (item.throat_radius if wormhole else item.mass)
    total, outward = tables.ensured("ellis" if wormhole else "schwarzschild")
    inputs = {
        "Chart": ("NodeSocketInt", _WORMHOLE if wormhole else _CHARTS[item.chart]),
        "Radius": ("NodeSocketFloat", radius / unit),
        "Spin": ("NodeSocketFloat", 0.0 if wormhole else item.spin),
        "Shell": ("NodeSocketFloat", reach * (1 + 1e-5)),
        "Total": ("NodeSocketString", str(total)),
        "Outward": ("NodeSocketString", str(outward)),
    }
    inputs |= light
    if far:
        mouth, far_radius = far
        axes = mouth.world_from_spacetime[:3, :3] * (far_radius / mouth.scale)
        inputs["FarRadius"] = ("NodeSocketFloat", far_radius / (mouth.scale * mouth.throat_radius))
        inputs["FarOrigin"] = ("NodeSocketVector", mouth.origin)
        inputs |= {f"Far{axis}": ("NodeSocketVector", axes[:, i]) for i, axis in enumerate("XYZ")}
    return {name: (kind, _rounded(kind, value)) for name, (kind, value) in inputs.items()}


def _rounded(kind: str, value: object) -> object:
    """As Blender will give it back, so that it can be compared."""
    if kind == "NodeSocketVector":
        return tuple(np.float32(value).tolist())
    return float(np.float32(value)) if kind == "NodeSocketFloat" else value


def read(hole: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> SpacetimeData:
    """A hole as it is in this frame."""
    evaluated = hole.evaluated_get(depsgraph)
    return spacetime.read_spacetime(evaluated, np.array(evaluated.matrix_world))
