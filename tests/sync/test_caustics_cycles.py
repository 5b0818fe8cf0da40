"""Filter Glossy and the switches of caustics against Cycles: Z-tests of a diffuse floor that a lamp lights by way of a
ball of metal, of glass, or of a coated mixture of both.

Where Cycles joins a rough refraction with a lamp it also counts pairs of directions that no facet refracts into each
other, those whose cosine is above -1 / index: for them the half vector of Walter et al. 2007 has both on one side. Its
scattered rays find no such light, 3 % of what is seen in a ball of roughness 0.3 under Filter Glossy; there both agree.
"""

import bpy
import numpy as np
import pytest

from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare
from tests.sync.test_lamp_materials import shader

SEEDS, SAMPLES = 6, 128
BALLS = {
    "metal": ("Anisotropic", {"Color": (0.9, 0.7, 0.4, 1), "Roughness": 0.2}),
    "mirror": ("Metallic", {"Base Color": (0.9, 0.7, 0.4, 1), "Roughness": 0.0}),
    "glass": ("Glass", {"Color": (1, 0.9, 0.8, 1), "Roughness": 0.0, "IOR": 1.5}),
    "refraction": ("Refraction", {"Color": (1, 0.9, 0.8, 1), "Roughness": 0.3, "IOR": 1.3}),
    "mixture": (
        "Principled",
        {"Base Color": (0.9, 0.5, 0.4, 1), "Roughness": 0.2, "Metallic": 0.3, "Transmission Weight": 0.6}
        | {"Coat Weight": 0.8, "Coat Roughness": 0.1, "Coat Tint": (0.6, 0.8, 1, 1)},
    ),
}


def build(ball: str) -> None:
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 18, 12
    scene.cycles.light_sampling_threshold = scene.bentlight.light_threshold = 0.0
    scene.cycles.blur_glossy = 0.0
    scene.bentlight.max_bounces = 4
    stage.set_world((0.1, 0.1, 0.1))
    stage.add_camera((0, 0, 8), type="ORTHO", ortho_scale=6)
    stage.add_square(20, (0, 0, -1.2), shader("Diffuse", Color=(0.8, 0.8, 0.8, 1)), "floor")
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=1.0)
    kind, inputs = BALLS[ball]
    material = shader(kind, **inputs)
    for node in material.node_tree.nodes:
        if hasattr(node, "distribution"):
            node.distribution = "GGX"
    bpy.context.object.data.materials.append(material)
    lamp = stage.add_light("AREA", (2.5, 0, 3), (0, 0.7, 0), energy=300.0, size=2.0)
    lamp.visible_camera = False


def change(**settings) -> None:
    """Settings of the same name in both engines."""
    for name, value in settings.items():
        setattr(bpy.context.scene.cycles, name, value)
        setattr(bpy.context.scene.bentlight, name, value)


def means_agree(tmp_path) -> np.ndarray:
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, SEEDS, SAMPLES)
    comparison = compare(theirs, ours, block=3)
    assert not comparison.differs(), str(comparison)
    assert comparison.precision < 0.01
    assert comparison.mean_b == pytest.approx(comparison.mean_a, rel=0.01), str(comparison)
    return comparison.mean_b


@pytest.mark.parametrize("ball", ["mirror", "glass", "mixture"])
def test_filter_glossy(ball, tmp_path):
    build(ball)
    change(blur_glossy=1.0)
    means_agree(tmp_path)


def test_filter_glossy_of_a_weak_blur(tmp_path):
    """A threshold between the pdfs of the floor's directions."""
    build("metal")
    change(blur_glossy=0.2)
    means_agree(tmp_path)


LEFT_OUT = [(ball, switch) for ball in BALLS for switch in ("refractive", "both")]
LEFT_OUT += [(ball, "reflective") for ball in ("metal", "mirror", "mixture")]


@pytest.mark.parametrize(("ball", "switch"), LEFT_OUT)
def test_caustics_left_out(ball, switch, tmp_path):
    build(ball)
    off = ("reflective", "refractive") if switch == "both" else (switch,)
    change(blur_glossy=1.0, **{f"caustics_{name}": False for name in off})
    means_agree(tmp_path)


def glowing_square(size, location, rotation, strength: float, sampling: str) -> bpy.types.Object:
    """A lamp that Cycles' scattered rays find; with the emission sampling NONE they alone."""
    material = shader("Diffuse")
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Strength"].default_value = strength
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    material.cycles.emission_sampling = sampling
    square = stage.add_square(size, location, material, "lamp")
    square.rotation_euler, square.visible_camera = rotation, False
    return square


@pytest.mark.parametrize("blur", [0.0, 1.0])
def test_rough_refraction_of_light_found_by_chance(blur, tmp_path):
    build("refraction")
    bpy.data.objects.remove(bpy.data.objects["Area"])
    glowing_square(5.0, (3, 0, 3), (0, 0.7, 0), 8.0, "NONE")
    change(blur_glossy=blur)
    means_agree(tmp_path)


def test_light_that_no_facet_refracts(tmp_path):
    """Seen from above through a ball of index 1.3, which turns rays by no more than 2 acos(1 / 1.3) = 79 degrees, a
    lamp that stands higher than the ball is dark; and Cycles agrees unless it joins the ball with the lamp."""
    build("refraction")
    bpy.data.objects.remove(bpy.data.objects["Area"])
    bpy.data.objects.remove(bpy.data.objects["floor"])
    stage.set_world((0, 0, 0))
    bpy.context.scene.camera.data.ortho_scale = 1.2
    seen = {}
    for sampling in ("NONE", "AUTO"):
        lamp = glowing_square(1.0, (4, 0, 1.6), (0, 1.2, 0), 1e4, sampling)
        theirs, ours = cycles_pictures.noisy_pictures(tmp_path, 1, 64)
        seen[sampling] = theirs.mean()
        assert np.all(ours == 0)
        bpy.data.objects.remove(lamp)
    assert seen["NONE"] == 0 < seen["AUTO"]
