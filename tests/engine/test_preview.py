"""Material icons: Blender's own preview scene, rendered by Bentlight at 32 x 32 and 128 x 128 pixels."""

import bpy
import numpy as np
import pytest

from tests.engine import stage


@pytest.fixture
def icon() -> np.ndarray:
    """The large icon of a rough red material, (128, 128, 4), bottom row first."""
    material = bpy.data.materials.new("Red")
    material.use_fake_user = True  # or it is not worth an icon
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.8, 0.05, 0.03, 1.0)
    shader.inputs["Roughness"].default_value = 1.0
    with stage.counted_renders() as count:
        bpy.ops.wm.previews_ensure()
    assert len(count) == 2
    width, height = material.preview.image_size
    return np.array(material.preview.image_pixels_float, np.float32).reshape(height, width, 4)


def test_an_icon_shows_its_material(icon):
    red, green, _, alpha = icon[54:74, 54:74].mean(axis=(0, 1))
    assert red > 2 * green
    assert red > 0.4
    assert alpha == 1


def test_an_icon_is_free_of_fireflies(icon):
    """Blender's preview lamps are so small that 16 paths met them in one pixel of ten: white specks on black."""
    middle = icon[40:88, 40:88, 0]
    neighbors = np.stack([middle[1 + dy : 47 + dy, 1 + dx : 47 + dx] for dy in (-1, 0, 1) for dx in (-1, 0, 1)])
    off = np.abs(middle[1:47, 1:47] - np.median(neighbors, axis=0))
    assert np.percentile(off, 99) < 0.2


def test_icons_warn_of_nothing(capfd, icon):
    """Their scene is Blender's: nobody can mend it."""
    assert "not supported" not in "".join(capfd.readouterr())
