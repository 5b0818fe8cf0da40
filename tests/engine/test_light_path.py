"""What materials can ask about the ray that looks at them, through the whole engine, against Cycles.

Tiles seen from above, one pixel each, below an even sky that shines with an output of the Light Path node. Mirrors,
smooth glass and diffuse tiles pass on what they see unchanged, so that a single sample tells the value.
"""

import bpy
import numpy as np
import pytest

from tests.engine import stage
from tests.engine.cycles_pictures import point_pictures

KINDS = ("Camera", "Shadow", "Diffuse", "Glossy", "Singular", "Reflection", "Transmission")
OUTPUTS = (
    *(f"Is {kind} Ray" for kind in KINDS),
    *("Ray Depth", "Diffuse Depth", "Glossy Depth", "Transparent Depth", "Transmission Depth"),
)
ROW = 1
WHITE = (1, 1, 1, 1)


def material(name: str, build) -> bpy.types.Material:
    """A material whose surface is the output that `build(tree)` returns."""
    made = stage.emission((0, 0, 0), name=name)
    tree = made.node_tree
    tree.nodes.clear()
    tree.links.new(build(tree), tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def shader(kind: str, **inputs):
    """Builds one shader node."""

    def build(tree):
        node = tree.nodes.new(f"ShaderNode{kind}")
        for name, value in inputs.items():
            node.inputs[name.replace("_", " ")].default_value = value
        return node.outputs[0]

    return build


TILES = {
    "nothing": shader("BsdfTransparent", Color=WHITE),
    "mirror": shader("BsdfGlossy", Color=WHITE, Roughness=0.0),
    "rough mirror": shader("BsdfGlossy", Color=WHITE, Roughness=0.4),
    "pane": shader("BsdfRefraction", Color=WHITE, Roughness=0.0, IOR=1.0),
    "rough pane": shader("BsdfRefraction", Color=WHITE, Roughness=0.5, IOR=1.3),
    "diffuse": shader("BsdfDiffuse", Color=WHITE),
    "paper": shader("BsdfTranslucent", Color=WHITE),
}


def set_sky(output: str) -> None:
    """An even sky that is 0.3 + 0.7 times an output."""
    world = stage.set_world((1, 1, 1))
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    path, scaled = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMath")
    scaled.operation = "MULTIPLY_ADD"
    scaled.inputs[1].default_value, scaled.inputs[2].default_value = 0.7, 0.3
    tree.links.new(path.outputs[output], scaled.inputs[0])
    tree.links.new(scaled.outputs[0], background.inputs["Strength"])
    world.cycles.sampling_method = "NONE"


def look_at_tiles() -> None:
    """Pictures of four rows, the fewest that Blender has; the tiles are in ROW."""
    stage.add_camera((len(TILES) / 2, 2 - ROW, 3), type="ORTHO", ortho_scale=len(TILES))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = len(TILES), 4


def add_tiles(height: float = 0.0) -> None:
    for x, (name, build) in enumerate(TILES.items()):
        stage.add_square(1.0, (x + 0.55, 0.5, height), material(name, build), name)


@pytest.mark.parametrize("output", OUTPUTS)
def test_the_sky_knows_the_ray_as_in_cycles(tmp_path, output):
    add_tiles()
    set_sky(output)
    look_at_tiles()
    cycles, ours = (picture[ROW] for picture in point_pictures(tmp_path))
    for x, name in enumerate(TILES):
        if name.startswith("rough"):  # its one sample has a weight of its own, near 1
            assert np.rint((ours[x] - 0.3) / 0.7).tolist() == np.rint((cycles[x] - 0.3) / 0.7).tolist(), name
        else:
            np.testing.assert_allclose(ours[x], cycles[x], rtol=1e-5, err_msg=name)


def pane(output: str | None):
    """Builds glass that lets through 0.2 and a tenth of an output of the Light Path node."""

    def build(tree):
        path, part = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMath")
        part.operation = "MULTIPLY_ADD"
        part.inputs[1].default_value, part.inputs[2].default_value = 0.1, 0.2
        if output:
            tree.links.new(path.outputs[output], part.inputs[0])
        else:
            part.inputs[0].default_value = 0.0
        clear = tree.nodes.new("ShaderNodeBsdfTransparent")
        tree.links.new(part.outputs[0], clear.inputs[0])
        return clear.outputs[0]

    return build


@pytest.mark.parametrize("output", (*OUTPUTS, "Ray Length"))
def test_shadows_know_the_ray_as_in_cycles(tmp_path, output):
    """Two panes between a point lamp and a diffuse floor, beside panes that ask nothing: so the place of the sample, of
    which the distance of the lamp depends, is the same."""
    stage.add_square(20, (0.3, 0, 0), material("floor", shader("BsdfDiffuse", Color=WHITE)))
    panes = [stage.add_square(20, (0.3, 0, height)) for height in (0.9, 1.7)]
    for obj in panes:
        obj.visible_camera = False
    stage.add_light("POINT", (0.7, 2.1, 3), energy=300.0, shadow_soft_size=0.0)
    stage.set_world((0, 0, 0))
    look_at_tiles()
    passed = []
    for kind in (None, output):
        for obj in panes:
            obj.data.materials.clear()
            obj.data.materials.append(material("pane", pane(kind)))
        passed.append(np.stack(point_pictures(tmp_path)))
    cycles, ours = passed[1] / passed[0]
    assert (cycles > 0.99).all()
    place = 1e-3 if output == "Ray Length" else 0  # of a pixel's sample, which lengths depend on
    np.testing.assert_allclose(ours, cycles, rtol=1e-5 + place)
