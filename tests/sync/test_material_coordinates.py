"""Coordinates and normal maps against Cycles, on quads tilted at random in an object with a general transform.

A quad covers one pixel of a thousandth of a unit. Cycles' first sample goes through its center, but for the rounding of
places to float32 and their way through two matrices: where a value changes over that, so much may it differ.
"""

import bentlight_native
import bpy
import mathutils
import numpy as np
import pytest
from cycles_values import render_emission
from value_cases import empty_tree, new

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_material

COLUMNS = 32
PIXEL = 1e-3
ROUNDING = 2e-5  # of a place, in pixels: a few units of float32 of places up to 0.05
SPACES = ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD")
WORLD_FROM_OBJECT = mathutils.Matrix.LocRotScale(
    mathutils.Vector((0.01, -0.02, 0.03)), mathutils.Euler((0.4, -0.7, 1.9)), mathutils.Vector((0.5, 1.5, -0.8))
)


def coordinate(name, target=None):
    return lambda tree: new(tree, "TexCoord", object=target() if target else None).outputs[name]


def other_object():
    empty = bpy.data.objects.new("other", None)
    bpy.context.scene.collection.objects.link(empty)
    empty.matrix_world = mathutils.Matrix.LocRotScale((0.1, 0, -0.2), mathutils.Euler((1, 2, 3)), (2, 1, 0.5))
    bpy.context.view_layer.update()
    return empty


def normal_map(space, strength):
    def build(tree):
        inputs = {"Strength": strength, "Color": (0.7, 0.35, 0.8, 1)}
        return new(tree, "NormalMap", inputs, space=space).outputs[0]

    return build


def geometry(name):
    return lambda tree: new(tree, "NewGeometry").outputs[name]


def fresnel(ior, is_bumped=False):
    def build(tree):
        inputs = {"IOR": ior} | ({"Normal": normal_map("OBJECT", 0.6)(tree)} if is_bumped else {})
        return new(tree, "Fresnel", inputs).outputs[0]

    return build


def layer_weight(name, blend, is_bumped=False):
    def build(tree):
        inputs = {"Blend": blend} | ({"Normal": normal_map("OBJECT", 0.6)(tree)} if is_bumped else {})
        return new(tree, "LayerWeight", inputs).outputs[name]

    return build


def vector_transform(kind, convert_from, convert_to):
    def build(tree):
        inputs = {0: new(tree, "NewGeometry").outputs["True Normal"]}
        settings = {"vector_type": kind, "convert_from": convert_from, "convert_to": convert_to}
        return new(tree, "VectorTransform", inputs, **settings).outputs[0]

    return build


CASES = {name: coordinate(name) for name in ("Generated", "Object", "Normal", "Reflection")}
CASES["other_object"] = coordinate("Object", other_object)
for space in SPACES:
    for strength in (1.0, 0.4, 1.7):
        CASES[f"normal_{space}_{strength}"] = normal_map(space, strength)
for name in ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing"):
    CASES[f"geometry_{name}"] = geometry(name)
for ior in (0.0, 0.7, 1.0, 1.45, 3.0):
    CASES[f"fresnel_{ior}"] = fresnel(ior)
CASES["fresnel_bumped"] = fresnel(1.45, is_bumped=True)
for name in ("Fresnel", "Facing"):
    for blend in (0.0, 0.2, 0.5, 0.8, 1.0):
        CASES[f"layer_weight_{name}_{blend}"] = layer_weight(name, blend)
    CASES[f"layer_weight_{name}_bumped"] = layer_weight(name, 0.3, is_bumped=True)
for kind in ("POINT", "VECTOR", "NORMAL"):
    for way in (("WORLD", "OBJECT"), ("OBJECT", "WORLD"), ("OBJECT", "OBJECT")):
        CASES[f"vector_transform_{kind}_{way}"] = vector_transform(kind, *way)


def make_points():
    """Center, unit normal, tangents along u, and UV of every quad; corners (n, 4, 3) in the world and their UVs."""
    rng = np.random.default_rng(5)
    rows = len(CASES)
    row, column = np.divmod(np.arange(rows * COLUMNS), COLUMNS)
    slopes = rng.uniform(-1.5, 1.5, (rows * COLUMNS, 2))
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * PIXEL
    center = np.stack([(column + 0.5) * PIXEL, (row + 0.5) * PIXEL, 0 * row], axis=1)
    height = square @ slopes[..., None]
    corners = center[:, None] + np.concatenate([np.broadcast_to(square, (*height.shape[:2], 2)), height], axis=2)
    normal = np.concatenate([-slopes, np.ones((len(slopes), 1))], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    angle = rng.uniform(0, 2 * np.pi, len(center))
    axes = np.stack([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)
    uvs = rng.uniform(0, 1, (len(center), 1, 2)) + np.einsum("nij,kj->nki", axes, square / PIXEL)
    along_u = np.concatenate([axes[:, 0], np.einsum("ni,ni->n", axes[:, 0], slopes)[:, None]], axis=1)
    return center, normal, along_u, corners, uvs


def make_object(materials, corners, uvs):
    """Every other quad faces away from the camera."""
    faces = np.arange(4 * len(corners)).reshape(-1, 4)
    faces[1::2] = faces[1::2, ::-1]
    inverse = np.array(WORLD_FROM_OBJECT.inverted())
    local = corners.reshape(-1, 3) @ inverse[:3, :3].T + inverse[:3, 3]
    mesh = bpy.data.meshes.new("quads")
    mesh.from_pydata(local.tolist(), [], faces.tolist())
    flat_uvs = uvs.reshape(-1, 2)[faces.ravel()]
    mesh.uv_layers.new(name="UV").uv.foreach_set("vector", flat_uvs.astype(np.float32).ravel())
    mesh.polygons.foreach_set("material_index", np.repeat(np.arange(len(CASES), dtype=np.int32), COLUMNS))
    for material in materials:
        mesh.materials.append(material)
    quads = bpy.data.objects.new("quads", mesh)
    quads.matrix_world = WORLD_FROM_OBJECT
    low, high = local.min(axis=0), local.max(axis=0)
    return quads, lambda world: ((world @ inverse[:3, :3].T + inverse[:3, 3]) - low) / (high - low)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """Name -> (Cycles' values, ours, how much ours change within ROUNDING)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = []
    for name, build in CASES.items():
        material = bpy.data.materials.new(name)
        empty_tree(material)
        emission = new(material.node_tree, "Emission", {"Color": build(material.node_tree)})
        new(material.node_tree, "OutputMaterial", {"Surface": emission.outputs[0]})
        materials.append(material)
    center, normal, along_u, corners, uvs = make_points()
    quads, generated = make_object(materials, corners, uvs)
    path = tmp_path_factory.mktemp("cycles") / "coordinates.exr"
    cycles = render_emission(quads, len(CASES), COLUMNS, path, PIXEL)
    scene, ours = bentlight_native.Scene(), {}
    backfacing = np.arange(len(center)) % 2
    # Mirrored by the object's negative scale, a face turns over once more.
    backfacing = 1 - backfacing if WORLD_FROM_OBJECT.determinant() < 0 else backfacing
    tangent = along_u - normal * np.einsum("ni,ni->n", along_u, normal)[:, None]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    sign = np.where(backfacing == 1, -1, 1)  # seen from above, (u, v, up) is right-handed
    across = np.cross([0, 1, 0], normal) / normal[:, 2:]  # from the center of a quad by a unit of x, and of y
    along = np.cross(normal, [1, 0, 0]) / normal[:, 2:]
    for i, (name, material) in enumerate(zip(CASES, materials, strict=True)):
        at = slice(i * COLUMNS, (i + 1) * COLUMNS)
        index = scene.add_material(compile_material(material, ImageTable()).program)

        def values(x, y, at=at, index=index):
            place = center[at] + (x * across[at] + y * along[at]) * ROUNDING * PIXEL
            return scene.shade(
                index,
                world_from_object=np.array(WORLD_FROM_OBJECT),
                position=place,
                generated=generated(place),
                normal=normal[at],
                geometric_normal=normal[at],
                tangent=tangent[at],
                tangent_sign=sign[at],
                uv=uvs[at].mean(axis=1),
                backfacing=backfacing[at],
            )["emission"]

        middle = values(0, 0)
        around = [np.abs(values(x, y) - middle) for x, y in ((-1, -1), (-1, 1), (1, -1), (1, 1))]
        ours[name] = middle, np.max(around, axis=0)
    return {name: (cycles[i], *ours[name]) for i, name in enumerate(CASES)}


@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_cycles(rendered, name):
    cycles, ours, change = rendered[name]
    assert (np.abs(ours - cycles) <= 2e-5 + 2e-5 * np.abs(ours) + change).all()
