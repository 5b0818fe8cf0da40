"""Accretion disks by Cycles' lenses and by the engine: the same pixels, every crossing of a ray among them."""

import math

import bpy
import disk_schwarzschild
import numpy as np
import pytest
import rendering

CASES = {
    "thin gas": (0.0, 30.0, {"emission": "POWER_LAW", "opacity": 0.6}),
    "spinning": (0.9, 30.0, {"emission": "PAGE_THORNE"}),
    "turning back": (-0.6, 30.0, {"emission": "RAMP", "opacity": 0.8}),
    "camera within the sphere": (0.9, 80.0, {"emission": "RAMP", "softness": 0.0}),
    "image": (-0.5, 30.0, {"emission": "IMAGE", "opacity": 0.9}),
    "material": (0.9, 30.0, {"emission": "MATERIAL"}),
    "film": (0.0, 30.0, {"emission": "POWER_LAW", "doppler": 0.0, "gravitational": 0.3, "temperature": 2500.0}),
}


def smooth_image() -> bpy.types.Image:
    """Bytes on the sRGB curve, with alpha; once around the hole and once outwards, so that no edge is met."""
    image = bpy.data.images.new("rings", 64, 16, alpha=True)
    around, out = np.meshgrid(np.arange(64) / 64, np.arange(16) / 16)
    turn = np.cos(2 * np.pi * around)
    values = np.stack([0.6 + 0.3 * turn, 0.5 + 0.4 * out, 0.5 - 0.3 * turn * out, 0.4 + 0.6 * out], axis=-1)
    image.pixels.foreach_set(np.ascontiguousarray(values, np.float32).ravel())
    return image


def layered_material() -> bpy.types.Material:
    """Colored by all that crossings are told, and transparent, so that every order is seen in its color."""
    material = bpy.data.materials.new("layers")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()

    def node(kind, **inputs):
        made = tree.nodes.new(kind)
        for name, value in inputs.items():
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, made.inputs[int(name[1:])])
            else:
                made.inputs[int(name[1:])].default_value = value
        return made

    def math(operation, *values):
        made = node("ShaderNodeMath", **{f"_{i}": value for i, value in enumerate(values)})
        made.operation = operation
        return made.outputs[0]

    def attribute(name):
        made = node("ShaderNodeAttribute")
        made.attribute_name = f"bentlight_{name}"
        return made.outputs["Fac"]

    red = math("POWER", attribute("frequency_ratio"), 4.0)
    green = math("MULTIPLY_ADD", math("COSINE", attribute("azimuth")), 0.3, 0.5)
    blue = math("MULTIPLY", attribute("image_order"), math("DIVIDE", 6.0, attribute("radius")))
    color = node("ShaderNodeCombineColor", _0=red, _1=green, _2=blue).outputs[0]
    shine = node("ShaderNodeEmission", _0=color, _1=2.0).outputs[0]
    shift = math("MULTIPLY", attribute("doppler"), attribute("gravitational"))
    behind = node("ShaderNodeBsdfTransparent", _0=(1.0, 0.7, 0.4, 1.0)).outputs[0]
    mix = node("ShaderNodeMixShader", _0=math("MULTIPLY", shift, 0.5), _1=behind, _2=shine).outputs[0]
    node("ShaderNodeOutputMaterial", _0=mix)
    return material


def pictures(spin, sphere, settings):
    """By the engine and by Cycles: 1 sample in the middle of each pixel."""
    scene = disk_schwarzschild.hole_with_disk(spin, math.radians(78), outer=15.0)
    hole = next(obj for obj in scene.objects if obj.bentlight.kind == "BLACK_HOLE")
    hole.bentlight.sphere_radius = sphere
    hole.bentlight.disk.pattern = 0.0
    hole.bentlight.disk.image, hole.bentlight.disk.material = smooth_image(), layered_material()
    for name, value in settings.items():
        setattr(hole.bentlight.disk, name, value)
    rendering.set_size(scene, 160, 90)
    scene.bentlight.photon_ring_samples = 1
    scene.bentlight.pixel_filter, scene.render.filter_size = "GAUSSIAN", 0.01
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    return [rendering.render(scene, engine, samples=1) for engine in ("BENTLIGHT", "CYCLES")]


@pytest.mark.parametrize("case", CASES)
def test_the_same_colors(case):
    """To 1 % in nine of ten pixels, the rest lying on edges, and to 0.2 % in their middle."""
    engine, cycles = pictures(*CASES[case])
    seen = engine.max(axis=-1) > 0.01 * np.percentile(engine.max(axis=-1), 99)
    assert seen.sum() > 500
    brightness = engine[seen].sum(axis=-1, keepdims=True)
    error = (cycles[seen] - engine[seen]) / brightness
    assert np.quantile(np.abs(error).max(axis=-1), 0.9) < 0.01
    assert np.abs(np.median(error, axis=0)).max() < 2e-3


def test_the_same_pattern():
    """Streaks are finer than the jitter within a pixel lets be compared one by one: their mean is the same."""
    engine, cycles = pictures(0.9, 30.0, {"emission": "RAMP", "pattern": 0.5})
    assert cycles.mean() == pytest.approx(engine.mean(), rel=0.01)
    seen = engine.max(axis=-1) > 0.05 * engine.max()
    assert np.corrcoef(engine[seen].sum(axis=-1), cycles[seen].sum(axis=-1))[0, 1] > 0.99


def test_what_cycles_cannot_show_is_said():
    """A warning for what is missing or scatters; and automatic spheres contain the disk."""
    scene = disk_schwarzschild.hole_with_disk(0.0, 1.0, outer=40.0)
    hole = next(obj for obj in scene.objects if obj.bentlight.kind == "BLACK_HOLE")
    from blender_addon.cycles import disk, setup

    _done, warnings = setup.setup(scene, bpy.context.evaluated_depsgraph_get())
    assert not [text for text in warnings if "disk" in text]
    assert hole.bentlight.lens_radius > 39
    hole.bentlight.disk.emission = "MATERIAL"
    assert "not seen" in disk.warnings(hole)[0]
    hole.bentlight.disk.material = material = layered_material()
    assert disk.warnings(hole) == []
    material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    assert "Diffuse BSDF" in disk.warnings(hole)[0]


def test_a_disks_own_material_comes_and_goes():
    """Its copy follows what is changed in it, and nothing is left behind."""
    scene = disk_schwarzschild.hole_with_disk(0.0, 1.0, outer=10.0)
    hole = next(obj for obj in scene.objects if obj.bentlight.kind == "BLACK_HOLE")
    hole.bentlight.disk.emission, hole.bentlight.disk.material = "MATERIAL", layered_material()
    before = len(bpy.data.node_groups)
    bpy.ops.bentlight.cycles_setup()
    (group,) = [tree for tree in bpy.data.node_groups if tree.name.startswith("Bentlight Lens")]
    emission = next(n for n in hole.bentlight.disk.material.node_tree.nodes if n.bl_idname == "ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 7.0
    bpy.context.view_layer.update()
    (group,) = [tree for tree in bpy.data.node_groups if tree.name.startswith("Bentlight Lens")]
    assert next(n for n in group.nodes if n.bl_idname == "ShaderNodeEmission").inputs["Strength"].default_value == 7.0
    hole.bentlight.disk.emission = "PAGE_THORNE"
    bpy.context.view_layer.update()
    assert len(bpy.data.node_groups) == before
    hole.bentlight.disk.emission = "MATERIAL"
    bpy.context.view_layer.update()
    bpy.ops.bentlight.cycles_clear()
    assert len(bpy.data.node_groups) == before
