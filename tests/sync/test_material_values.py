"""Every node's values against Cycles, and what the compiler says about what it cannot do."""

import bentlight_native
import bpy
import color_cases  # noqa: F401  (it adds to the cases)
import numpy as np
import pytest
import texture_cases  # noqa: F401  (so does this)
from cycles_values import render_rows
from value_cases import CASES, empty_tree

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_material

# Generic values: no edge of a checker or pixel is within rounding of them, which float32 and float64 could see apart.
UVS = np.random.default_rng(7).uniform(-1.6, 2.6, (48, 2)).astype(np.float32)

# Colors of 16 bits multiplied by alpha are rounded to 16 bits: one step, times the steepest slope of the sRGB curve.
ROUNDING = {"file_png_16_alpha": 2.28 / 65535}


def emission_material(name, build):
    material = bpy.data.materials.new(name)
    tree = empty_tree(material)
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(build(tree), emission.inputs["Color"])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """Name -> (Cycles' values, ours), each (values, 3)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = [emission_material(name, build) for name, build in CASES.items()]
    cycles = render_rows(materials, UVS, tmp_path_factory.mktemp("cycles") / "values.exr")
    images, scene = ImageTable(), bentlight_native.Scene()
    programs = [compile_material(material, images).program for material in materials]
    for pixels in images.images:
        scene.add_image(*pixels)
    ours = [scene.shade(scene.add_material(program), uv=UVS)["emission"] for program in programs]
    return {name: (cycles[i], ours[i]) for i, name in enumerate(CASES)}


@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_cycles(rendered, name):
    cycles, ours = rendered[name]
    np.testing.assert_allclose(ours, cycles, rtol=1e-5, atol=1e-5 + ROUNDING.get(name, 0))
