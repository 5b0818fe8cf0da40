"""The relay camera: Cycles sees along Bentlight's curved rays, and along its own where space is flat."""

import bentlight_native
import bpy
import numpy as np
import pytest

from blender_addon.cycles import relay, relay_operators
from tests.engine import stage
from tests.engine.cycles_pictures import NARROW
from tests.engine.stage import blender  # noqa: F401 (a fixture)

COLORS = {"red": (0.9, 0.2, 0.1), "green": (0.1, 0.8, 0.3), "blue": (0.2, 0.3, 0.9)}


def show_directions() -> None:
    """A sky whose color is half its direction, plus one half."""
    world = stage.set_world((0, 0, 0))
    nodes, links = world.node_tree.nodes, world.node_tree.links
    place, half = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeVectorMath")
    half.operation = "MULTIPLY_ADD"
    half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
    links.new(place.outputs["Generated"], half.inputs[0])
    links.new(half.outputs[0], next(node for node in nodes if node.type == "BACKGROUND").inputs["Color"])


def cycles(samples: int = 1) -> bpy.types.Scene:
    """The scene, to be rendered by Cycles, one sample in the middle of each pixel or a box full of them."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = scene.bentlight.samples = samples
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = scene.bentlight.use_adaptive_sampling = False
    point = samples == 1
    scene.cycles.pixel_filter_type, scene.bentlight.pixel_filter = "BOX", "GAUSSIAN" if point else "BOX"
    scene.cycles.filter_width = scene.render.filter_size = NARROW if point else 1.0
    scene.bentlight.photon_ring_samples = 1
    return scene


def shining_room() -> None:
    """Three shining squares around the origin, a camera that looks at it along +y, and a sky of directions."""
    show_directions()
    stage.add_camera((0.1, -6, 0.3), (np.pi / 2, 0, 0))
    for (name, color), place in zip(COLORS.items(), ((-1.2, 1, 0.2), (1, -2, 1), (0.6, 3, -1)), strict=True):
        square = stage.add_square(1.5, place, stage.emission(color, name=name), name)
        square.rotation_euler = (np.pi / 2, 0.2, 0.3)


def picture(tmp_path, engine: str = "CYCLES") -> np.ndarray:
    """RGB, (height, width, 3)."""
    bpy.context.scene.render.engine = engine
    return stage.render(tmp_path)["Combined"][..., :3]


def test_an_unbent_camera_is_cycles_own(tmp_path):
    """But for edges, each of which maps know to a part of a pixel: a Z-test of blocks.

    Of 4 x 4 parts a row tells where an edge crosses it to 1/4 pixel: what the pixel shows has a variance of
    contrast^2 (1/4)^2 / 12 / 4, the same for all seeds. Two steps from pixel to pixel lead over an edge, whose squares
    have 2/3 of the contrast's on average."""
    shining_room()
    scene = cycles(64)

    def pictures() -> np.ndarray:
        found = []
        for seed in range(6):
            scene.cycles.seed = seed
            found.append(picture(tmp_path))
        return np.stack(found)

    own = pictures()
    bpy.ops.bentlight.relay_setup()
    difference = own - pictures()
    assert np.ptp(difference) > 0.01, "the edges differ"
    contrast = np.zeros((48, 64, 3))
    for axis in (0, 1):
        step = np.diff(own.mean(axis=0), axis=axis) ** 2
        contrast[: step.shape[0], : step.shape[1]] += 1.5 * step
    of_edges = contrast.reshape(6, 8, 8, 8, 3).mean(axis=(1, 3)) * (1 / 4) ** 2 / 12 / 4 / 64
    blocks = difference.reshape(6, 6, 8, 8, 8, 3).mean(axis=(2, 4))  # of 8 x 8 pixels
    z = blocks.mean(axis=0) / np.sqrt(blocks.var(axis=0, ddof=1) / 6 + of_edges + 1e-14)
    # With five degrees of freedom z^2 would be 5/3 on average; fixed errors of edges, and blocks without, make it less.
    assert np.mean(z**2) < 1.0


@pytest.mark.parametrize(
    ("hole", "gravitational"),
    [({"mass": 0.1}, 0), ({"mass": 0.1, "spin": 0.9}, 0), ({"mass": 0.1, "spin": 0.9}, 1), (None, 0)],
    ids=["schwarzschild", "kerr", "kerr-gravitational", "wormhole"],
)
def test_it_sees_what_the_engine_sees(hole, gravitational, tmp_path):
    """The same curved ray in the middle of each pixel: sky and surfaces, to the error that the panel asks for."""
    shining_room()
    bpy.context.scene.bentlight.gravitational = gravitational
    if hole:
        bpy.ops.bentlight.black_hole_add(location=(0, 0, 0), **hole)
    else:
        bpy.ops.bentlight.wormhole_add(throat_radius=0.3, location=(0, 0, 0), exit_location=(50, 0, 0))
    scene = cycles()
    scene.bentlight.relay_parts = 3  # one is in the middle
    ours = picture(tmp_path, "BENTLIGHT")
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.relay_setup()
    theirs = picture(tmp_path)
    distance = np.abs(ours - theirs).max(axis=-1)
    assert np.median(distance) < 1e-5
    # Filters of a hundredth of a pixel still blur edges and the rings around the shadow.
    assert np.mean(distance > 2e-3) < 0.02
    assert (theirs.max(axis=-1) == 0).any() == (hole is not None)  # the shadow


def test_memory_is_taken_by_what_is_seen(monkeypatch):
    """Places are in the maps before surfaces only; however many rays a band has, a thread traces some at a time."""
    shining_room()
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0))
    scene = cycles()
    scene.bentlight.relay_parts = 6
    counts, trace = [], bentlight_native.Scene.intersect

    def counted(self, origins, *args, **kwargs):
        counts.append(len(origins))
        return trace(self, origins, *args, **kwargs)

    monkeypatch.setattr(bentlight_native.Scene, "intersect", counted)
    bpy.ops.bentlight.relay_setup()

    def size(name: str) -> int:
        return max(file.stat().st_size for file in relay._baked[scene.camera.name][1].files if name in file.name)

    assert max(counts) == 1 << 15
    assert size("_place") == size("_direction") > 1 << 19
    for name in COLORS:
        bpy.data.objects.remove(bpy.data.objects[name])
    relay.update(scene, bpy.context.evaluated_depsgraph_get())
    assert size("_place") < 2000 and size("_direction") > 1 << 19


def test_depth_of_field_is_that_of_cycles(tmp_path):
    """A small bright square out of focus: blocks of the blurred picture, by a Z-test over seeds."""
    scene = cycles(64)
    stage.set_world((0, 0, 0))
    camera = stage.add_camera((0, -4, 0), (np.pi / 2, 0, 0))
    square = stage.add_square(0.6, (0.1, 0, 0.1), stage.emission((1, 1, 1)))
    square.rotation_euler = (np.pi / 2, 0, 0)
    dof = camera.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 1.5, 0.08
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.3, 1.4
    scene.bentlight.relay_parts = 16
    own = []
    for seed in range(6):
        scene.cycles.seed = seed
        own.append(picture(tmp_path))
    bpy.ops.bentlight.relay_setup()
    relayed = []
    for seed in range(6):
        scene.cycles.seed = seed
        relayed.append(picture(tmp_path))
    one, other = (np.stack(x)[..., 0].reshape(6, 6, 8, 8, 8).mean(axis=(2, 4)) for x in (own, relayed))
    # 16 x 16 rays a pixel, 16384 a block, are fixed: their places on the lens have an error of their own.
    mean = one.mean(axis=0)
    error = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / 6 + mean * (1 - mean) / 16384)
    z = (mean - other.mean(axis=0))[(mean > 0.01) & (mean < 0.99)] / error[(mean > 0.01) & (mean < 0.99)]
    # With ten degrees of freedom z^2 is 1.25 on average, and of 15 blocks this to 0.55.
    assert z.size == 15 and np.mean(z**2) < 1.8


@pytest.mark.parametrize("blurred", [False, True], ids=["still", "blurred"])
def test_bumps_are_those_of_cycles(blurred, tmp_path):
    """Heights are compared a pixel apart: rays know how far their neighbors are."""
    scene = cycles(16)
    stage.set_world((0, 0, 0))
    bumpy = bpy.data.materials.new("Bumpy")
    if bpy.app.version < (5, 0, 0):
        bumpy.use_nodes = True
    nodes, links = bumpy.node_tree.nodes, bumpy.node_tree.links
    place, noise, bump = (nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexNoise", "Bump"))
    noise.inputs["Scale"].default_value, bump.inputs["Distance"].default_value = 2.0, 0.3
    links.new(place.outputs["Object"], noise.inputs["Vector"])
    links.new(noise.outputs[0], bump.inputs["Height"])
    links.new(bump.outputs[0], nodes["Principled BSDF"].inputs["Normal"])
    stage.add_square(5, (0, 0, -5), bumpy)
    stage.add_light("SUN", (0, 0, 0), (0.9, 0.3, 0), energy=3)
    stage.add_camera()
    own = picture(tmp_path)
    assert own.std() > 0.1, "it is bumpy"
    scene.render.use_motion_blur = blurred
    bpy.ops.bentlight.relay_setup()
    difference = picture(tmp_path) - own
    # Each of 16 samples gets the nearest part: in both directions it looks beside by 1 / sqrt(12) of a part. Twice
    # that: within pixels there are steeper bumps than steps between them tell. The mean is that of 64 x 48 pixels.
    steps = np.sqrt(sum(np.mean(np.diff(own, axis=axis) ** 2) for axis in (0, 1)))
    part = 1 / relay._baked[scene.camera.name][1].parameters["Parts"]
    expected = steps * part / np.sqrt(12 * 16)
    assert difference.std() < 2 * expected and abs(difference.mean()) < 4 * expected / 55


def test_only_what_changes_rays_is_baked_anew(tmp_path):
    """Materials do not; holes, cameras and meshes do; each frame of an animation gets its own."""
    shining_room()
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0))
    hole, scene = bpy.context.object, cycles()
    scene.bentlight.relay_parts = 1
    bpy.ops.bentlight.relay_setup()

    def path() -> str:
        relay_operators._before_render(scene)
        return scene.camera.data.cycles_custom["Maps"]

    first = path()
    bpy.data.materials["red"].node_tree.nodes["Emission"].inputs["Strength"].default_value = 2.0
    assert path() == first
    hole.bentlight.mass = 0.2
    second = path()
    assert second != first
    bpy.data.objects["red"].location.x += 1
    third = path()
    assert third not in (first, second)
    hole.keyframe_insert("location", frame=1)
    hole.location.x = 0.5
    hole.keyframe_insert("location", frame=2)
    pictures = []
    for frame in (1, 2):
        scene.frame_set(frame)
        pictures.append(picture(tmp_path))
    assert np.abs(pictures[0] - pictures[1]).max() > 0.1
    scene.frame_set(1)
    np.testing.assert_array_equal(picture(tmp_path), pictures[0])


def test_nothing_is_bent_twice(tmp_path):
    """With a lens around the hole too, what the camera sees of shining things stays; clearing shows lenses again."""
    shining_room()
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0))
    scene = cycles()
    scene.bentlight.relay_parts = 2
    bpy.ops.bentlight.relay_setup()
    alone = picture(tmp_path)
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.cycles_setup()
    np.testing.assert_array_equal(picture(tmp_path), alone)
    (lens,) = [obj for obj in scene.objects if obj.bentlight.made_for_cycles == "LENS"]
    assert not lens.visible_camera
    bpy.ops.bentlight.relay_clear()
    assert lens.visible_camera


def test_gravity_takes_back_what_it_gives(tmp_path):
    """Light of the sky that falls to a surface, and is scattered from there to a camera outside, has its frequency
    again: the lens brightens it as much as the relay camera dims it."""
    stage.set_world((0.5, 0.6, 0.7))
    stage.add_camera((0.1, -6, 0.3), (np.pi / 2, 0, 0))
    gray = bpy.data.materials.new("Gray")
    if bpy.app.version < (5, 0, 0):
        gray.use_nodes = True
    square = stage.add_square(1.5, (0.5, 0.6, 0.2), gray)
    square.rotation_euler = (np.pi / 2, 0.2, 0.3)
    bpy.ops.bentlight.black_hole_add(mass=0.2, location=(0, 0, 0))
    bpy.context.object.bentlight.lens_radius = bpy.context.object.bentlight.sphere_radius = 3.0
    scene = cycles(4)
    scene.bentlight.relay_parts = 2
    bpy.ops.bentlight.cycles_setup()
    bpy.ops.bentlight.relay_setup()
    before = picture(tmp_path)
    scene.bentlight.gravitational = 1.0
    np.testing.assert_allclose(picture(tmp_path), before, rtol=1e-4)
    bpy.ops.bentlight.cycles_clear()
    dim = picture(tmp_path)
    scene.bentlight.gravitational = 0.0
    plain = picture(tmp_path)
    assert ((dim < 0.7 * plain) & (plain > 0)).any() and (dim <= plain * (1 + 1e-5)).all()


def test_meshes_are_those_of_renders(tmp_path):
    """Subdivided for renders only, hidden in the viewport only: the maps fit what Cycles renders."""
    shining_room()
    scene = cycles()
    red, green = bpy.data.objects["red"], bpy.data.objects["green"]
    modifier = red.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 3
    green.hide_viewport = True
    bpy.data.objects["blue"].hide_set(True)
    own = picture(tmp_path)
    scene.bentlight.relay_parts = 3
    bpy.ops.bentlight.relay_setup()
    assert np.mean(np.abs(picture(tmp_path) - own).max(axis=-1) > 1e-3) < 0.01
    assert (modifier.levels, green.hide_viewport, bpy.data.objects["blue"].hide_get()) == (0, True, True)


def test_lamps_are_seen(tmp_path):
    """An area and a round lamp beside a hole, as by the engine but for a thin rim."""
    stage.set_world((0.1, 0.1, 0.1))
    stage.add_camera((0, -6, 0), (np.pi / 2, 0, 0))
    stage.add_light("AREA", (0.8, 0, 0), (-np.pi / 2, 0.2, 0), energy=20, size=1)
    stage.add_light("POINT", (-0.8, 0, 0), energy=20, shadow_soft_size=0.5)
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0.1, -2, 0))
    scene = cycles()
    scene.bentlight.relay_parts = 3
    ours = picture(tmp_path, "BENTLIGHT")
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.relay_setup()
    theirs = picture(tmp_path)
    assert (ours > 1).mean() > 0.1
    assert np.mean(np.abs(ours - theirs).max(axis=-1) > 0.02) < 0.01


def test_missing_maps_are_made_again(tmp_path):
    shining_room()
    cycles()
    bpy.ops.bentlight.relay_setup()
    before = picture(tmp_path)
    _, maps = relay._baked[bpy.context.scene.camera.name]
    for file in maps.files:
        file.unlink()
    np.testing.assert_array_equal(picture(tmp_path), before)


def test_clear_leaves_nothing(tmp_path):
    shining_room()
    scene = cycles()
    camera = scene.camera
    before = picture(tmp_path)
    bpy.ops.bentlight.relay_setup()
    _, maps = relay._baked[scene.camera.name]
    assert scene.camera != camera and all(file.exists() for file in maps.files)
    bpy.ops.bentlight.relay_clear()
    assert scene.camera == camera and not any(file.exists() for file in maps.files)
    assert len(bpy.data.cameras) == 1 and "Camera Relay" not in bpy.data.objects
    np.testing.assert_array_equal(picture(tmp_path), before)


def test_a_camera_in_the_horizon_is_an_error_and_black(tmp_path, caplog):
    shining_room()
    scene = cycles()
    bpy.ops.bentlight.relay_setup()
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0.1, -6, 0.3))
    assert not picture(tmp_path).any()
    assert "horizon" in caplog.text
    bpy.ops.bentlight.relay_clear()
    with pytest.raises(RuntimeError, match="horizon"):
        bpy.ops.bentlight.relay_setup()
    assert relay.source_of(scene.camera) is None
