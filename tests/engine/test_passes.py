"""Every pass: there when asked for, in the multilayer EXR, and true to a scene whose passes are known."""

import bpy
import numpy as np
import pytest

import blender_addon
from blender_addon.passes import PASSES
from examples.compositor import new_tree
from tests.engine import stage

SKY, GLOW = (0.1, 0.8, 0.2), (3.0, 0.5, 0.25)
TOGGLES = tuple(item.toggle for item in PASSES if item.name != "Combined")


def enable_all(layer: bpy.types.ViewLayer) -> None:
    for toggle in TOGGLES:
        owner, name = (layer.bentlight, toggle.split(".")[1]) if "." in toggle else (layer, toggle)
        setattr(owner, name, True)


@pytest.fixture
def passes(tmp_path) -> dict[str, np.ndarray]:
    """A glowing square, tilted about x, 5 away, before a sky. A narrow filter: pixels are points."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 6))
    stage.set_world(SKY)
    square = stage.add_square(2.0, (0, 0, 1), stage.emission(GLOW))
    square.rotation_euler = (0.5, 0, 0)
    scene.bentlight.samples, scene.bentlight.pixel_filter = 1, "GAUSSIAN"
    scene.render.filter_size = 0.01
    enable_all(scene.view_layers[0])
    return stage.render(tmp_path)


def test_every_pass_is_in_the_file(passes):
    assert set(passes) == {item.name for item in PASSES}
    assert {item.name: item.width for item in PASSES} == {name: p.shape[2] for name, p in passes.items()}


def test_no_pass_is_there_unasked(tmp_path):
    stage.add_camera()
    assert set(stage.render(tmp_path)) == {"Combined"}


def test_passes_are_true(passes):
    by_channel = {item.channel: passes[item.name] for item in PASSES}
    hit, sky = (24, 32), (2, 2)
    np.testing.assert_allclose(by_channel["emission"][hit], GLOW, rtol=1e-5)
    np.testing.assert_allclose(by_channel["environment"][sky], SKY, rtol=1e-5)
    assert (by_channel["emission"][sky] == 0).all() and (by_channel["environment"][hit] == 0).all()
    np.testing.assert_allclose(by_channel["normal"][hit], (0, -np.sin(0.5), np.cos(0.5)), atol=1e-5)
    assert by_channel["fate"][hit] == 4 and by_channel["fate"][sky] == 1
    assert by_channel["depth"][sky] == 1e10
    assert by_channel["error"].max() < 1e-9 and by_channel["winding"].max() == 0
    on_square = by_channel["fate"][..., 0] == 4
    position, depth = by_channel["position"][on_square], by_channel["depth"][on_square][:, 0]
    np.testing.assert_allclose(depth, 6 - position[:, 2], rtol=1e-5)
    np.testing.assert_allclose((position - (0, 0, 1)) @ (0, -np.sin(0.5), np.cos(0.5)), 0, atol=1e-5)
    rows, columns = np.nonzero(on_square)
    slope = 36 / 50 / 64
    expected = np.stack([columns + 0.5 - 32, rows + 0.5 - 24], axis=1) * slope * depth[:, None]
    half_width = 3 * 0.01 / 2  # of the filter, pixels
    np.testing.assert_allclose(position[:, :2], expected, atol=1.1 * half_width * slope * 6)


def test_passes_tell_of_curved_light(tmp_path):
    """Rays that graze a hole wind around it; those that never get out of it are captured."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 10))
    stage.set_world(SKY)
    bpy.ops.bentlight.black_hole_add(mass=0.2)
    enable_all(scene.view_layers[0])
    passes = stage.render(tmp_path)
    winding, fate, error = (passes[f"Bentlight {name}"][..., 0] for name in ("Winding", "Fate", "Error"))
    assert set(np.unique(fate)) == {1.0, 2.0}
    assert winding[fate == 1].max() > 1.2
    assert 0 < error[fate == 1].max() <= scene.bentlight.tolerance
    # Far out the ray sweeps pi plus the deflection 4M/b, less what the camera at a finite distance does not see.
    b = 10 * 36 / 50 / 2
    corner = winding[24, 0]
    assert corner == pytest.approx((np.pi - np.arcsin(b / 10) + 4 * 0.2 / b) / np.pi, abs=0.05)


def test_the_compositor_knows_the_passes():
    scene = bpy.context.scene
    stage.add_camera()
    layer = scene.view_layers[0]
    enable_all(layer)
    layer.update_render_passes()
    tree, _ = new_tree(scene, "Passes")
    node = tree.nodes.new("CompositorNodeRLayers")
    names = {socket.name for socket in node.outputs if socket.enabled}
    assert {item.name for item in PASSES} - {"Combined"} <= names


def test_channels_of_the_table_are_the_core_s():
    import bentlight_native

    assert blender_addon.passes.PASSES is PASSES
    for item in PASSES:
        assert bentlight_native.CHANNELS[item.channel].components == item.width
