"""Denoise in Compositor: one node behind each picture, and all that was there before it kept."""

import bpy
import numpy as np
import pytest

from blender_addon.operators import denoise
from examples.compositor import new_tree
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)


@pytest.fixture
def scene(blender) -> bpy.types.Scene:  # noqa: F811
    """A gray wall in the light of a lamp."""
    stage.add_camera((0, 0, 5))
    stage.add_square(20.0)
    stage.add_light("AREA", (0, 0, 4), energy=500, size=3)
    return bpy.context.scene


def tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    return getattr(scene, "compositing_node_group", None) or scene.node_tree


def ways(scene: bpy.types.Scene) -> set[tuple[str, str, str, str]]:
    """All links: from a node of a type and its socket to another."""
    return {
        (link.from_node.type, link.from_socket.name, link.to_node.type, link.to_socket.name)
        for link in tree(scene).links
    }


GUIDED = {
    ("R_LAYERS", "Image", "DENOISE", "Image"),
    ("R_LAYERS", "Denoising Albedo", "DENOISE", "Albedo"),
    ("R_LAYERS", "Denoising Normal", "DENOISE", "Normal"),
}


def test_one_click_takes_the_noise_away_and_another_changes_nothing(scene, tmp_path):
    noisy = stage.render(tmp_path)["Combined"]
    assert denoise.find_nodes(scene) == []
    bpy.ops.bentlight.denoise_setup()
    assert ways(scene) >= GUIDED
    clean = composited(tmp_path)
    bpy.ops.bentlight.denoise_setup()
    (node,) = denoise.find_nodes(scene)
    node.mute = True  # what the switch in the panel does
    assert np.array_equal(composited(tmp_path), noisy)
    assert grain(clean) < grain(noisy) / 2


def composited(tmp_path) -> np.ndarray:
    """The picture as the compositor leaves it."""
    pictures = stage.render_layers(tmp_path)
    (combined,) = [passes["Combined"] for layer, passes in pictures.items() if layer != "ViewLayer"]
    return combined


def grain(picture: np.ndarray) -> float:
    """How much neighbors differ, of what they have."""
    return float(np.abs(np.diff(picture[..., 0], axis=1)).mean() / picture[..., 0].mean())


def test_effects_that_are_there_come_after_it(scene):
    made, output = new_tree(scene, "Effects")
    layers, effect = made.nodes.new("CompositorNodeRLayers"), made.nodes.new("CompositorNodeExposure")
    made.links.new(layers.outputs["Image"], effect.inputs["Image"])
    made.links.new(effect.outputs["Image"], output.inputs[0])
    kept = {way for way in ways(scene) if way[0] == "EXPOSURE"}
    bpy.ops.bentlight.denoise_setup()
    assert ways(scene) == kept | GUIDED | {("DENOISE", "Image", "EXPOSURE", "Image")}


def test_each_view_layer_has_its_own(scene):
    second = scene.view_layers.new("Second")
    made, output = new_tree(scene, "Layers")
    for layer in scene.view_layers:
        made.nodes.new("CompositorNodeRLayers").layer = layer.name
    mix = made.nodes.new("CompositorNodeAlphaOver")
    for node, socket in zip(made.nodes[1:3], [s for s in mix.inputs if s.type == "RGBA"], strict=True):
        made.links.new(node.outputs["Image"], socket)
    made.links.new(mix.outputs["Image"], output.inputs[0])
    second.bentlight.use_pass_denoising = False
    bpy.ops.bentlight.denoise_setup()
    assert len(denoise.find_nodes(scene)) == 2
    assert second.bentlight.use_pass_denoising and scene.view_layers[0].bentlight.use_pass_denoising


def test_it_is_ours_alone(scene):
    """Cycles has a switch of its own."""
    scene.render.engine = "CYCLES"
    assert not bpy.ops.bentlight.denoise_setup.poll()
