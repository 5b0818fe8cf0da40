"""What compiling says: warnings that name material and node, errors that name image and file, and safe results."""

import bentlight_native
import bpy
import numpy as np
import pytest
from value_cases import empty_tree, new

from blender_addon.report import RenderError, Reporter
from blender_addon.sync.images import ImageTable, image_pixels
from blender_addon.sync.material import MaterialTable, compile_material
from blender_addon.sync.native import build_scene
from blender_addon.sync.scene_data import CameraData, SceneData


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def make_material(build, name="Wall"):
    """A material whose surface is the shader or color output that `build(tree)` returns."""
    material = bpy.data.materials.new(name)
    tree = empty_tree(material)
    new(tree, "OutputMaterial", {"Surface": build(tree)})
    return material


def shade(material, **point):
    images, scene = ImageTable(), bentlight_native.Scene()
    compiled = compile_material(material, images)
    for pixels in images.images:
        scene.add_image(*pixels)
    index = scene.add_material(compiled.program)
    return scene.shade(index, **point), compiled.warnings


def emission(tree, color):
    return new(tree, "Emission", {"Color": color}).outputs[0]


def test_unsupported_value_node_warns_once_and_keeps_the_socket_value():
    def build(tree):
        edges = new(tree, "Wireframe")
        edges.name = "Edges"
        both = new(tree, "BsdfDiffuse", {"Color": edges.outputs[0], "Roughness": edges.outputs[0]})
        both.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1)
        return both.outputs[0]

    result, warnings = shade(make_material(build))
    assert len(warnings) == 1 and "'Wall'" in warnings[0] and "'Edges'" in warnings[0]
    np.testing.assert_allclose(result["albedo"], [[0.1, 0.2, 0.3]], rtol=1e-5)


def test_unsupported_shader_becomes_diffuse():
    def build(tree):
        return new(tree, "BsdfToon", {"Color": (0.4, 0.5, 0.6, 1)}).outputs[0]

    result, warnings = shade(make_material(build))
    assert len(warnings) == 1 and "diffuse" in warnings[0]
    np.testing.assert_allclose(result["albedo"], [[0.4, 0.5, 0.6]], rtol=1e-5)


def test_christensen_burley_becomes_a_random_walk():
    def build(tree):
        return new(tree, "BsdfPrincipled", {"Subsurface Weight": 0.5}, subsurface_method="BURLEY").outputs[0]

    _, warnings = shade(make_material(build))
    assert len(warnings) == 1 and "Christensen-Burley" in warnings[0] and "random walk" in warnings[0]


def scattered(material, **point):
    """What a material scatters into some directions; it may give no warning."""
    compiled, scene = compile_material(material, ImageTable()), bentlight_native.Scene()
    assert not compiled.warnings
    turn = np.linspace(0, 6, 20)
    directions = np.stack([0.6 * np.cos(turn), 0.6 * np.sin(turn), np.full(20, 0.8)], axis=1)
    return scene.evaluate_bsdf(scene.add_material(compiled.program), directions, **point)[0]


def linked(tree, kind, inputs):
    """A shader whose inputs come through links."""
    return new(tree, kind, {name: new(tree, "Math", {0: x, 1: 0.0}).outputs[0] for name, x in inputs.items()})


@pytest.mark.parametrize(
    "kind, inputs",
    [
        ("BsdfPrincipled", {"Coat Weight": 0.7, "Coat Roughness": 0.4, "Coat IOR": 1.9, "Coat Tint": 0.5}),
        ("BsdfPrincipled", {"Metallic": 1.0, "Anisotropic": 0.8, "Anisotropic Rotation": 0.1}),
        ("BsdfPrincipled", {"Sheen Weight": 0.8, "Sheen Roughness": 0.9, "Sheen Tint": 0.3}),
        ("BsdfAnisotropic", {"Anisotropy": -0.8, "Rotation": 0.1}),
        ("BsdfMetallic", {"Anisotropy": 0.8, "Rotation": 0.1, "Roughness": 0.8}),
        ("BsdfSheen", {"Roughness": 0.9}),
    ],
)
def test_linked_inputs_count_as_their_own_values(kind, inputs):
    def own(tree):
        values = {name: (x, x, x, 1) if "Tint" in name else x for name, x in inputs.items()}
        return new(tree, kind, values).outputs[0]

    point = {"wo": (0.6, 0.0, 0.8), "generated": (0.9, 0.2, 0.5)}
    by_links = scattered(make_material(lambda tree: linked(tree, kind, inputs).outputs[0], "links"), **point)
    by_values, plain = (
        scattered(make_material(build, "values"), **point) for build in (own, lambda t: new(t, kind).outputs[0])
    )
    np.testing.assert_allclose(by_links, by_values, rtol=1e-6)
    assert (np.abs(by_values / plain - 1) > 0.01).any()


def test_a_tangent_that_is_not_linked_goes_around_the_object():
    def build(tree, *links):
        return new(tree, "BsdfAnisotropic", {"Anisotropy": 0.8} | dict(links)).outputs[0]

    def around(tree):
        return build(tree, ("Tangent", new(tree, "NewGeometry").outputs["Tangent"]))

    for place in ((0.9, 0.2, 0.5), (0.3, 0.1, 0.5)):
        alone, geometry = (scattered(make_material(b), generated=place) for b in (build, around))
        np.testing.assert_array_equal(alone, geometry)


def test_a_plain_material_gives_no_warning():
    material = bpy.data.materials.new("Plain")
    if material.node_tree is None:
        material.use_nodes = True
    _, warnings = shade(material)
    assert warnings == []


def test_nothing_at_the_output_is_black():
    material = make_material(lambda tree: emission(tree, (1, 1, 1, 1)))
    material.node_tree.nodes.clear()
    result, warnings = shade(material)
    assert (result["emission"] == 0).all() and (result["albedo"] == 0).all() and warnings == []


def test_a_color_at_the_output_emits():
    def build(tree):
        rgb = new(tree, "RGB")
        rgb.outputs[0].default_value = (0.2, 0.4, 3.0, 1)
        return rgb.outputs[0]

    result, _ = shade(make_material(build))
    np.testing.assert_allclose(result["emission"], [[0.2, 0.4, 3.0]], rtol=1e-6)


def test_missing_image_file_is_named(tmp_path):
    image = bpy.data.images.new("Brick", 4, 4)
    image.source = "FILE"
    image.filepath = str(tmp_path / "nowhere.png")
    image.reload()
    material = make_material(lambda tree: emission(tree, new(tree, "TexImage", image=image).outputs[0]))
    with pytest.raises(RenderError, match=r"Brick.*nowhere\.png"):
        compile_material(material, ImageTable())


def test_missing_tile_is_named(tmp_path):
    image = bpy.data.images.new("Skin", 4, 4, tiled=True)
    image.filepath = str(tmp_path / "skin.<UDIM>.png")
    image.tiles.new(1012)
    material = make_material(lambda tree: emission(tree, new(tree, "TexImage", image=image).outputs[0]))
    with pytest.raises(RenderError, match=r"Skin.*skin\.1001\.png"):
        compile_material(material, ImageTable())
    assert len(bpy.data.images) == 1


@pytest.mark.parametrize("suffix", ["png", "exr"])
def test_external_image_equals_the_packed_one(tmp_path, suffix):
    source = bpy.data.images.new("source", 5, 3, float_buffer=suffix == "exr", alpha=True)
    source.pixels.foreach_set(np.random.default_rng(0).random(60).astype(np.float32))
    source.file_format = "PNG" if suffix == "png" else "OPEN_EXR"
    source.filepath_raw = str(tmp_path / f"image.{suffix}")
    source.save()
    external = bpy.data.images.load(source.filepath_raw)
    packed = bpy.data.images.load(source.filepath_raw)
    packed.pack()
    a, b = image_pixels(external, print), image_pixels(packed, print)
    assert a.srgb == b.srgb == (suffix == "png")
    np.testing.assert_array_equal(a.values, b.values)


def test_pixels_that_are_not_finite_become_black_with_a_warning():
    image = bpy.data.images.new("Broken", 2, 1, float_buffer=True)
    image.pixels.foreach_set(np.array([np.nan, 1, 2, 1, np.inf, -np.inf, 3, 1], np.float32))
    said = []
    pixels = image_pixels(image, said.append)
    np.testing.assert_array_equal(pixels.values[0], [[0, 1, 2, 1], [0, 0, 3, 1]])
    assert len(said) == 1 and "Broken" in said[0]


def test_one_image_in_several_materials_is_converted_once():
    image = bpy.data.images.new("shared", 2, 2)
    table = MaterialTable(Reporter(lambda level, text: None))
    build = lambda tree: emission(tree, new(tree, "TexImage", image=image).outputs[0])  # noqa: E731
    materials = [make_material(build, name) for name in ("A", "B")]
    assert [table.index_of(m) for m in (*materials, *materials, None)] == [0, 1, 0, 1, -1]
    assert len(table.images) == 1 and len(table.materials) == 2


def test_links_in_a_circle_end():
    def build(tree):
        first, second = new(tree, "Math"), new(tree, "Math")
        tree.links.new(first.outputs[0], second.inputs[0])
        tree.links.new(second.outputs[0], first.inputs[0])
        return emission(tree, first.outputs[0])

    result, _ = shade(make_material(build))
    assert np.isfinite(result["emission"]).all()


def test_shaders_in_a_circle_end():
    """The lamp still shines through the two nodes that also lead to each other."""

    def build(tree):
        lamp = emission(tree, (1, 2, 3, 1))
        first, second = new(tree, "AddShader", {0: lamp}), new(tree, "AddShader", {0: lamp})
        tree.links.new(first.outputs[0], second.inputs[1])
        tree.links.new(second.outputs[0], first.inputs[1])
        return second.outputs[0]

    result, _ = shade(make_material(build))
    np.testing.assert_allclose(result["emission"] / [1, 2, 3], np.full((1, 3), 2.0), rtol=1e-6)


def test_shaders_inside_groups_and_mixes():
    """Mix by a linked factor, add, groups with a shader output, and a muted shader node."""

    def build(tree):
        group = bpy.data.node_groups.new("lamp", "ShaderNodeTree")
        group.interface.new_socket("Power", in_out="INPUT", socket_type="NodeSocketFloat")
        group.interface.new_socket("Light", in_out="OUTPUT", socket_type="NodeSocketShader")
        start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        inner = new(group, "Emission", {"Color": (1, 2, 3, 1), "Strength": start.outputs[0]})
        group.links.new(inner.outputs[0], end.inputs[0])
        lamp = new(tree, "Group", node_tree=group)
        lamp.inputs[0].default_value = 2.0
        factor = new(tree, "Math", {0: 0.25, 1: 0.5}, operation="ADD")
        other = new(tree, "Emission", {"Color": (1, 1, 1, 1)})
        mixed = new(tree, "MixShader", {0: factor.outputs[0], 1: other.outputs[0], 2: lamp.outputs[0]})
        return new(tree, "AddShader", {0: mixed.outputs[0], 1: other.outputs[0]}).outputs[0]

    result, warnings = shade(make_material(build))
    np.testing.assert_allclose(result["emission"], [[1.25 + 1.5, 1.25 + 3.0, 1.25 + 4.5]], rtol=1e-6)
    assert warnings == []


def mixed_in_a_row(tree, shaders):
    """All shaders in equal parts, by a chain of Mix Shader nodes; its end."""
    mixed = shaders[0]
    for count, shader in enumerate(shaders[1:], start=2):
        mixed = new(tree, "MixShader", {0: 1 / count, 1: mixed.outputs[0], 2: shader.outputs[0]})
    return mixed.outputs[0]


def test_any_number_of_lobes_counts():
    """Two hundred diffuse nodes of all colors show their mean color."""
    colors = np.random.default_rng(0).random((200, 3))
    result, warnings = shade(
        make_material(lambda tree: mixed_in_a_row(tree, [new(tree, "BsdfDiffuse", {"Color": (*c, 1)}) for c in colors]))
    )
    assert warnings == []
    np.testing.assert_allclose(result["albedo"], [colors.mean(axis=0)], rtol=1e-5)


def test_a_shader_that_many_ways_lead_to_is_compiled_once():
    """Each of 60 nodes adds the one before to itself: 2^60 ways lead to the lamp."""

    def build(tree):
        shader = new(tree, "Emission", {"Color": (1, 2, 3, 1), "Strength": 2.0**-60})
        for _ in range(60):
            shader = new(tree, "AddShader", {0: shader.outputs[0], 1: shader.outputs[0]})
        return shader.outputs[0]

    result, _ = shade(make_material(build))
    np.testing.assert_allclose(result["emission"], [[1, 2, 3]], rtol=1e-6)


def test_more_nodes_than_the_core_can_run_are_refused_by_name():
    material = make_material(lambda tree: mixed_in_a_row(tree, [new(tree, "Emission") for _ in range(400)]))
    table = MaterialTable(Reporter(lambda level, text: None))
    table.index_of(material)
    camera = CameraData("ORTHOGRAPHIC", np.eye(4), 4, 4, (-1, 1, -1, 1), 0.1, 10)
    with pytest.raises(RenderError, match=r"Material 'Wall': .*too many nodes"):
        build_scene(SceneData(camera, materials=table.materials))
