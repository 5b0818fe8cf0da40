"""IES files: what is understood of them, and what is said of broken ones."""

import bpy
import numpy as np
import pytest
from texture_cases import LUMINAIRES, ies_text
from value_cases import empty_tree, new

from blender_addon.sync.ies import ies_table
from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_material


@pytest.fixture
def texture():
    """An IES Texture node without a file, the light of a material."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    tree = empty_tree(bpy.data.materials.new("Lamp"))
    node = new(tree, "TexIES", mode="EXTERNAL")
    light = new(tree, "Emission", {"Strength": node.outputs[0]})
    new(tree, "OutputMaterial", {"Surface": light.outputs[0]})
    return node


def read(texture, path, text):
    path.write_text(text)
    texture.filepath = str(path)
    return ies_table(texture)


def test_files_are_read_as_texts_are(texture, tmp_path):
    from_file = read(texture, tmp_path / "a.ies", ies_text(LUMINAIRES["half"]))
    texture.mode, texture.ies = "INTERNAL", bpy.data.texts.new("a")
    texture.ies.from_string(ies_text(LUMINAIRES["half"]))
    np.testing.assert_array_equal(from_file, ies_table(texture))
    horizontals, verticals = from_file.ravel()[:2]
    assert (horizontals, verticals) == (7, 6)  # 0, 90, 120, 180 and back


def test_how_much_weaker_tilted_lamps_are_does_not_matter(texture, tmp_path):
    """A luminaire that is measured shines as it was measured."""
    plain = ies_text((0, 90))
    tilted = plain.replace("TILT=NONE", "TILT=INCLUDE\n1\n2\n0 90\n1 0.5")
    np.testing.assert_array_equal(*(read(texture, tmp_path / "a.ies", text) for text in (plain, tilted)))


BROKEN = {
    "empty": "",
    "words": "IESNA\nTILT=NONE\nno numbers",
    "short": ies_text((0, 90))[:-60],
    "type": ies_text((0, 90)).replace(" 1 2 0 0 0 ", " 2 2 0 0 0 "),
    "part": ies_text((0, 50)),
    "order": ies_text((0, 90, 45, 360)),
    "infinite": ies_text((0, 90)).replace("0.9", "inf"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_named_and_shine_evenly(texture, tmp_path, name):
    with pytest.raises(ValueError, match="it"):
        read(texture, tmp_path / "broken.ies", BROKEN[name])
    warnings = compile_material(bpy.data.materials[0], ImageTable()).warnings
    assert len(warnings) == 1 and "evenly" in warnings[0] and texture.name in warnings[0]


def test_a_missing_file_is_named(texture):
    texture.filepath = "/nowhere/a.ies"
    with pytest.raises(ValueError, match="cannot be read"):
        ies_table(texture)
    texture.mode = "INTERNAL"
    with pytest.raises(ValueError, match="no text"):
        ies_table(texture)
