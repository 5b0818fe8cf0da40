"""The denoising passes of every kind of surface against Cycles, in flat space: what they scatter, and what is seen in
and through what is sharp."""

import bpy
import numpy as np
import pytest

from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)

COLOR = (0.8, 0.5, 0.2, 1)
SIZE = 6  # pixels of each surface
ROUGH = {
    "diffuse": ("BsdfDiffuse", {}),
    "emission": ("Emission", {"Strength": 1.7}),
    "translucent": ("BsdfTranslucent", {}),
    "rough metal": ("BsdfAnisotropic", {"Roughness": 0.4}),
    "rough glass": ("BsdfGlass", {"Roughness": 0.5, "IOR": 1.5}),
    "principled": ("BsdfPrincipled", {}),
    "polished": ("BsdfPrincipled", {"Roughness": 0.1}),
    "metallic": ("BsdfPrincipled", {"Metallic": 1.0, "Roughness": 0.4}),
    "coated": ("BsdfPrincipled", {"Coat Weight": 1.0, "Coat Roughness": 0.03}),
    "coated metal": ("BsdfPrincipled", {"Coat Weight": 1.0, "Metallic": 1.0, "Roughness": 0.4}),
    "fuzzy": ("BsdfPrincipled", {"Sheen Weight": 1.0}),
    "half transparent": ("BsdfPrincipled", {"Alpha": 0.5}),
}
SHARP = {
    "mirror": ("BsdfAnisotropic", {"Roughness": 0.0}),
    "nearly": ("BsdfAnisotropic", {"Roughness": 0.1}),
    "sharp metal": ("BsdfPrincipled", {"Metallic": 1.0, "Roughness": 0.05}),
    "glass": ("BsdfGlass", {"Roughness": 0.0, "IOR": 1.5}),
    "transparent": ("BsdfTransparent", {}),
}


def material(name, kind, inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    color = "Base Color" if kind == "BsdfPrincipled" else "Color"
    for socket, value in (inputs | {color: COLOR}).items():
        node.inputs[socket].default_value = value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def features(tmp_path, surfaces, sky=(0.0, 0.0, 0.0), samples=16):
    """Denoising albedo and normal, {engine: (surfaces, 3) each}, of squares side by side that lean to one side."""
    scene, count = bpy.context.scene, len(surfaces)
    scene.render.resolution_x, scene.render.resolution_y = SIZE * count, SIZE
    camera = stage.add_camera((0, 0, 4))
    camera.data.type, camera.data.ortho_scale = "ORTHO", float(count)
    stage.set_world(sky)
    for i, (name, (kind, inputs)) in enumerate(surfaces.items()):
        square = stage.add_square(0.7, (i + 0.5 - count / 2, 0, 0), material(name, kind, inputs), name)
        square.rotation_euler = (0.3, 0.2, 0)
    layer = bpy.context.view_layer
    layer.cycles.denoising_store_passes = layer.bentlight.use_pass_denoising = True
    scene.cycles.samples = scene.bentlight.samples = samples
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = scene.bentlight.use_adaptive_sampling = False
    scene.cycles.max_bounces = scene.bentlight.max_bounces = 4
    found = {}
    for engine in ("CYCLES", "BENTLIGHT"):
        scene.render.engine = engine
        passes = stage.render(tmp_path)
        found[engine] = [
            passes[name][2:4].reshape(2, count, SIZE, 3)[:, :, 2:4].mean(axis=(0, 2))
            for name in ("Denoising Albedo", "Denoising Normal")
        ]
    return found


def test_what_surfaces_scatter(blender, tmp_path):  # noqa: F811
    """Sharp coats and transparency have no part in it. (Of light alone Cycles has no normal.)"""
    found = features(tmp_path, ROUGH)
    for name, theirs, ours in zip(ROUGH, found["CYCLES"][0], found["BENTLIGHT"][0], strict=True):
        np.testing.assert_allclose(ours, theirs, atol=0.004, err_msg=name)
    keep = [name != "emission" for name in ROUGH]
    np.testing.assert_allclose(found["BENTLIGHT"][1][keep], found["CYCLES"][1][keep], atol=2e-3)


@pytest.mark.parametrize("sky", [0.0, 0.5])
def test_what_is_seen_in_and_through_what_is_sharp(sky, blender, tmp_path):  # noqa: F811
    """Rough walls before and behind: as in Cycles. A sky there has the color of what shows it once, as in the picture;
    Cycles' passes have it twice."""
    if not sky:
        stage.add_square(40.0, (0, 0, -3), material("wall", "BsdfDiffuse", {}), "Wall")
        stage.add_square(40.0, (0, 0, 9), material("roof", "BsdfDiffuse", {}), "Roof")
    found = features(tmp_path, SHARP, (sky, sky, sky), samples=256)
    color = np.array(COLOR[:3])
    for name, theirs, ours in zip(SHARP, found["CYCLES"][0], found["BENTLIGHT"][0], strict=True):
        if sky:
            np.testing.assert_allclose(ours, sky * color, atol=0.02, err_msg=name)
            np.testing.assert_allclose(theirs, sky * color**2, atol=0.02, err_msg=name)
        else:
            np.testing.assert_allclose(ours, theirs, atol=0.02, err_msg=name)
