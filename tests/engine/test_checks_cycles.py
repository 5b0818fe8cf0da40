"""What Cycles does not show through lenses is told in the panel of warnings, for as long as it lasts."""

import bpy
import pytest

from blender_addon import checks
from blender_addon.cycles import failures, handlers, relay, setup, tables
from blender_addon.report import RenderError, Reporter
from tests.engine import stage
from tests.engine.warned import add_hole, texts


@pytest.fixture
def hole():
    """With a lens of the radius 8, before a camera, in Cycles."""
    made = add_hole()
    made.bentlight.lens_radius = 8.0
    stage.add_camera(location=(0, -30, 0))
    bpy.context.scene.render.engine = "CYCLES"
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    assert texts() == []
    return made


def test_a_hole_that_lenses_cannot_show_any_more(hole):
    """Its own warning is enough, and it ends with the reason."""
    hole.scale = (1, 1, 2)
    assert texts() == ["Black hole 'Hole': its scale must be uniform and positive"]
    assert len(failures.of_scene(bpy.context.scene)) == 1
    hole.scale = (1, 1, 1)
    assert texts() == [] and failures.of_scene(bpy.context.scene) == ()


def test_tables_that_cannot_be_written_after_setting_up(hole, monkeypatch):
    """No finding of the scene itself tells this; the log does once."""

    def fail(_kind):
        raise RenderError("Deflection tables cannot be written: {}", "disk full")

    with monkeypatch.context() as patch:
        patch.setattr(tables, "ensured", fail)
        for mass in (2.1, 2.2):
            hole.bentlight.mass = mass
            (found,) = (texts(), checks.of_scene(bpy.context))[1]
            assert found.text == "Lenses for Cycles: Deflection tables cannot be written: disk full"
            assert (found.kind, found.owner) == ("SCENE", "Scene")
        bpy.context.scene.render.engine = "BENTLIGHT"
        assert texts() == []  # which needs no lens
        bpy.context.scene.render.engine = "CYCLES"
        assert len(texts()) == 1
    hole.bentlight.mass = 2.3
    assert texts() == []


@pytest.mark.parametrize("undo", [bpy.ops.bentlight.cycles_clear, lambda: handlers._on_load("")])
def test_failures_end_with_what_failed(hole, undo):
    failures.remember(bpy.context.scene, "lenses", "as it was")
    hole.location.x = 1
    assert texts() == []  # lenses were made anew, and nothing failed
    failures.remember(bpy.context.scene, "lenses", "as it was")
    assert [found.text for found in checks.of_scene(bpy.context)] == ["as it was"]
    undo()
    assert checks.of_scene(bpy.context) == []


def test_a_relay_camera_without_maps(hole, monkeypatch, tmp_path):
    scene = bpy.context.scene
    assert bpy.ops.bentlight.relay_setup(bake=False) == {"FINISHED"}

    def fail(*_):
        raise OSError("disk full")

    scene.cycles.samples = 1
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.filepath = str(tmp_path / "black.png")
    with monkeypatch.context() as patch:
        patch.setattr(relay, "update", fail)
        bpy.ops.render.render(write_still=True)
    said = "The relay camera has no maps, the picture stays black: disk full"
    assert said in texts()
    bpy.ops.bentlight.relay_clear()
    assert texts() == []


def test_a_graphics_card_without_optix_and_no_shading_language(hole, monkeypatch):
    """Chosen after setting up. (Tests have no graphics card: Blender renders on the CPU then.)"""
    cycles = bpy.context.scene.cycles
    cycles.device = "GPU"
    (text,) = texts()
    assert "without OptiX" in text
    monkeypatch.setattr(setup, "gpu_kind", lambda: "OPTIX")
    assert texts() == []
    cycles.shading_system = False
    (text,) = texts()
    assert text.startswith("Open Shading Language is off")
    bpy.ops.bentlight.cycles_clear()
    assert texts() == []


def test_meshes_and_disks_that_a_lens_leaves_out_later(hole):
    """As setting up says it, but for as long as it lasts: meshes move, disks grow."""
    cube = stage.add_square(1.0, (0, 0, 7), name="Tile")
    (text,) = texts()
    assert text.startswith("Inside the lens of 'Hole' (radius 8), and not seen bent: Tile.")
    for height, number in ((8.01, 0), (7.99, 1)):
        cube.location.z = height
        assert len(texts()) == number
    cube.rotation_euler.x = 0.5  # the near edge is at 7.75, the far one outside
    assert len(texts()) == 1
    cube.location.z = 9
    hole.bentlight.disk.enable = True
    hole.bentlight.disk.outer = 40
    (text,) = texts()
    assert text.startswith("The disk of 'Hole' reaches out of its lens")
    hole.bentlight.disk.emission = "IMAGE"
    (text,) = texts()
    assert "has no color ramp" in text


@pytest.fixture
def sky(hole, tmp_path):
    """The world's image, which lenses filter."""
    image = bpy.data.images.new("Milky Way", 8, 4, float_buffer=True)
    image.filepath_raw, image.file_format = str(tmp_path / "sky_0001.exr"), "OPEN_EXR"
    image.save()
    world = bpy.context.scene.world or bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = bpy.data.images.load(image.filepath_raw)
    node.image.name = "Sky"
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    assert texts() == []
    return node


def test_skies_that_are_not_filtered_have_a_reason(sky):
    """Each thing in the way alone, as long as it is there; in the operator's report too."""
    scene, layer = bpy.context.scene, bpy.context.scene.view_layers[0]
    for owner, name, value, reason in (
        (scene.cycles, "device", "GPU", "it works on the CPU alone"),
        (layer, "world_override", bpy.data.worlds.new("Own"), "view layer 'ViewLayer' has a world of its own"),
    ):
        before = getattr(owner, name)
        setattr(owner, name, value)
        said = f"Sky Filter does nothing in Cycles: {reason}"
        assert said in texts(), name
        assert said in setup.setup(scene, bpy.context.evaluated_depsgraph_get())[1] or name == "device"
        setattr(owner, name, before)
        assert texts() == [], name


def test_disks_in_another_light_group_than_the_sky(hole, sky):
    """What a lens shows is in one."""
    scene = bpy.context.scene
    scene.world.lightgroup = "Sky"
    assert texts() == []
    hole.bentlight.disk.enable = True
    said = "Sky Filter does nothing in Cycles: the disk of 'Hole' and world 'World' are not in one light group"
    assert said in texts()
    hole.lightgroup = "Sky"
    assert said not in texts()
    bpy.ops.bentlight.relay_setup(bake=False)
    other = hole.copy()
    scene.collection.objects.link(other)
    other.location.x = 100
    several = "By the relay camera accretion disks in several light groups are in none"
    assert several not in texts()
    other.lightgroup = "Other"
    assert several in texts()
    bpy.ops.bentlight.relay_clear()
    assert several not in texts()


def test_a_view_layer_that_overrides_the_materials_of_lenses(hole):
    layer = bpy.context.scene.view_layers.new("Clay")
    layer.material_override = bpy.data.materials.new("Clay")
    said = "View layer 'Clay' overrides materials, those of lenses too: Cycles bends no light there"
    assert said in texts()
    layer.material_override = None
    bpy.context.scene.camera = None
    bpy.ops.bentlight.cycles_clear()
    assert texts() == []


def test_skies_of_a_relay_camera_have_a_reason_too(sky):
    """With no lens left, in the panel and in what a render says."""
    bpy.ops.bentlight.cycles_clear()
    bpy.context.scene.cycles.shading_system = True
    sky.projection = "MIRROR_BALL"
    assert texts() == []
    assert bpy.ops.bentlight.relay_setup(bake=False) == {"FINISHED"}
    said = "Sky Filter does nothing for an image in Cycles: image 'Sky' is a mirror ball"
    assert texts() == [said]
    heard = []
    depsgraph = bpy.context.evaluated_depsgraph_get()
    relay.update(bpy.context.scene, depsgraph, Reporter(lambda level, text: heard.append(text)))
    assert said in heard
    bpy.ops.bentlight.relay_clear()


def test_worlds_that_lenses_cannot_show_have_a_reason(sky):
    tree = bpy.context.scene.world.node_tree
    volume = tree.nodes.new("ShaderNodeVolumeScatter")
    link = tree.links.new(volume.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    assert texts() == ["Sky Filter does nothing in Cycles: world 'World' has a volume"]
    tree.links.remove(link)
    group = bpy.data.node_groups.new("HDRI", "ShaderNodeTree")
    group.interface.new_socket("At", in_out="OUTPUT", socket_type="NodeSocketVector")
    told, result = group.nodes.new("ShaderNodeTexCoord"), group.nodes.new("NodeGroupOutput")
    group.links.new(told.outputs["Window"], result.inputs["At"])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.name = group, "Studio"
    link = tree.links.new(node.outputs["At"], sky.inputs["Vector"])
    (text,) = texts()
    name = "Texture Coordinate" if bpy.app.version >= (5, 0, 0) else "Studio/Texture Coordinate"
    assert text == f"Sky Filter does nothing in Cycles: lenses cannot show node '{name}' of world 'World'"
    tree.links.remove(link)
    assert texts() == []


def test_images_that_are_not_filtered_have_a_reason(sky):
    prefix = "Sky Filter does nothing for an image in Cycles: "
    sky.projection = "MIRROR_BALL"
    assert texts() == [f"{prefix}image 'Sky' is a mirror ball"]
    sky.projection = "EQUIRECTANGULAR"
    sky.texture_mapping.rotation.z = 1
    assert texts() == [f"{prefix}node 'Environment Texture' has a Texture Mapping"]
    sky.texture_mapping.rotation.z = 0
    for source, reason in (("MOVIE", "image 'Sky' is a movie"), ("TILED", "image 'Sky' is tiled (UDIM)")):
        sky.image.source = source
        assert texts() == [prefix + reason]
    sky.image.source = "SEQUENCE"
    assert texts() == []
    sky.image_user.frame_offset = 3
    assert texts() == [f"{prefix}Image 'Sky': its file 'sky_0004.exr' is missing or cannot be read"]


def test_skies_that_nobody_asks_to_filter_or_sees(sky):
    scene = bpy.context.scene
    sky.projection = "MIRROR_BALL"
    assert len(texts()) == 1
    for owner, name, value in (
        (scene.bentlight, "sky_filter", 0.0),
        (scene.render, "film_transparent", True),
        (scene.world.cycles_visibility, "camera", False),
        (sky, "mute", True),
        (sky, "image", None),
        (scene.render, "engine", "BENTLIGHT"),
    ):
        before = getattr(owner, name)
        setattr(owner, name, value)
        assert texts() == [], name
        setattr(owner, name, before)
        assert len(texts()) == 1, name
    bpy.ops.bentlight.cycles_clear()
    assert texts() == []
