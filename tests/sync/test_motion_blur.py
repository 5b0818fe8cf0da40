"""Motion blur: Z-tests against Cycles in flat space, of what moves, turns and changes its shape, and of such cameras;
and of a hole against the mean of pictures in which it stands."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from blender_addon.sync.slices import slices
from blender_addon.ui.motion_blur import BENTLIGHT_PT_object_motion_blur
from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare

SEEDS, SAMPLES = 8, 64
SLICES = 32  # each is evaluated by Blender, which takes longer than its samples


@pytest.fixture(autouse=True)
def scene(blender) -> bpy.types.Scene:  # noqa: F811
    """A glowing square before a darker wall, the shutter open for half a frame."""
    scene = bpy.context.scene
    scene.frame_set(5)
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    scene.bentlight.motion_slices = SLICES
    stage.add_camera((0, 0, 4))
    stage.set_world((1 / 128, 1 / 128, 1 / 128))
    stage.add_square(0.7, (0, 0, 0), stage.emission((1.0, 0.5, 0.2)), "Square")
    return scene


def animate(owner: bpy.types.bpy_struct, path: str, *values) -> None:
    """`values` in frames 0 and 10: a change that is nearly even in the middle, where the shutter is open."""
    for frame, value in zip((0, 10), values, strict=True):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)


def square() -> bpy.types.Object:
    return bpy.data.objects["Square"]


def assert_same_as_cycles(tmp_path, samples: int = SAMPLES) -> None:
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, SEEDS, samples)
    comparison = compare(theirs, ours, block=2)
    assert not comparison.differs(), str(comparison)
    assert comparison.precision < 0.01


@pytest.mark.parametrize("position", ["START", "CENTER", "END"])
def test_moving_object(position, scene, tmp_path):
    scene.render.motion_blur_position = position
    animate(square(), "location", (-10.0, 0, 0), (10.0, 0, 0))
    assert_same_as_cycles(tmp_path)


def test_turning_object(tmp_path):
    animate(square(), "rotation_euler", (0, 0, -8.0), (0, 0, 8.0))
    square().cycles.motion_steps = 5
    assert_same_as_cycles(tmp_path)


def add_wide_key(obj: bpy.types.Object) -> None:
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 3.0
    key.slider_max, key.slider_min = 10.0, -10.0
    animate(key, "value", -4.0, 6.0)


def test_object_that_changes_its_shape(tmp_path):
    add_wide_key(square())
    assert_same_as_cycles(tmp_path)


def test_shape_or_object_that_is_switched_off(tmp_path):
    """The one moves without changing, the other stands."""
    obj = square()
    add_wide_key(obj)
    obj.cycles.use_deform_motion = False
    animate(obj, "location", (-4.0, 0, 0), (4.0, 0, 0))
    other = stage.add_square(0.4, (-0.6, 0.7, 0.1), stage.emission((0.2, 0.5, 1.0)), "Other")
    animate(other, "location", (-10.0, 0.7, 0.1), (10.0, 0.7, 0.1))
    other.cycles.use_motion_blur = False
    assert_same_as_cycles(tmp_path)


@pytest.mark.parametrize("stands", ["nothing", "carrier", "shape of carrier", "carried"])
def test_instances_that_are_switched_off(stands, scene, tmp_path):
    """By the object that instances others, or by those, which are in no collection of the scene. (Cycles gives all
    instances of a mesh the motion of its shape if one of them has it.)"""
    obj = square()
    if stands == "shape of carrier":
        add_wide_key(obj)
    scene.collection.objects.unlink(obj)
    carried = bpy.data.collections.new("Carried")
    carried.objects.link(obj)
    carriers = []
    for name, height in (("Low", -0.6), ("High", 0.6)):
        carrier = bpy.data.objects.new(name, None)
        carrier.instance_type, carrier.instance_collection = "COLLECTION", carried
        scene.collection.objects.link(carrier)
        animate(carrier, "location", (-4.0, height, 0), (4.0, height, 0))
        carriers.append(carrier)
    if stands == "carrier":
        carriers[0].cycles.use_motion_blur = False
    elif stands == "shape of carrier":
        carriers[0].cycles.use_deform_motion = carriers[1].cycles.use_deform_motion = False
    elif stands == "carried":
        obj.cycles.use_motion_blur = False
    assert_same_as_cycles(tmp_path)


def test_moving_camera(tmp_path):
    camera = bpy.context.scene.camera
    animate(camera, "location", (-5, 0, 2), (5, 0, 6))
    animate(camera, "rotation_euler", (0, -1.0, 1.0), (0, 1.0, -1.0))
    camera.cycles.motion_steps = 4
    assert_same_as_cycles(tmp_path)


def test_camera_that_is_switched_off(tmp_path):
    camera = bpy.context.scene.camera
    animate(camera, "location", (-10, 0, 4), (10, 0, 4))
    camera.cycles.use_motion_blur = False
    assert_same_as_cycles(tmp_path)


@pytest.mark.parametrize("position, marker", [("START", 6), ("CENTER", 5)])
def test_markers_do_not_change_the_camera_within_a_frame(position, marker, scene, tmp_path):
    """Another camera comes before or after the frame, while its shutter is open."""
    scene.render.engine, scene.bentlight.samples = "BENTLIGHT", 16
    scene.render.motion_blur_position, scene.render.motion_blur_shutter = position, 1.5
    animate(square(), "location", (-2.0, 0, 0), (2.0, 0, 0))
    before, after = scene.camera, stage.add_camera((0.5, 0.3, 2.5), (0.0, 0.2, 0.4))
    camera = scene.camera = before if marker > 5 else after
    expected = stage.render(tmp_path)["Combined"]
    for frame, bound in ((0, before), (marker, after)):
        scene.timeline_markers.new(bound.name, frame=frame).camera = bound
    scene.frame_set(5)
    assert scene.camera == camera
    np.testing.assert_array_equal(stage.render(tmp_path)["Combined"], expected)
    assert scene.camera == camera
    scene.frame_set(6 if marker > 5 else 4)
    assert scene.camera != camera


def test_without_the_add_on_of_cycles(scene, tmp_path):
    """Its switches are gone, and everything moves; lamps are as by default."""
    scene.render.engine = "BENTLIGHT"
    animate(square(), "location", (-10.0, 0, 0), (10.0, 0, 0))
    stage.add_light("AREA", (0, 0, 3), energy=10.0)
    context, panel = SimpleNamespace(engine="BENTLIGHT", object=square()), BENTLIGHT_PT_object_motion_blur
    expected = stage.render(tmp_path)["Combined"]
    assert panel.poll(context)
    bpy.ops.preferences.addon_disable(module="cycles")
    try:
        assert not hasattr(square(), "cycles") and not panel.poll(context)
        np.testing.assert_array_equal(stage.render(tmp_path)["Combined"], expected)
    finally:
        bpy.ops.preferences.addon_enable(module="cycles")


def test_shutter_curve(scene, tmp_path):
    """Mostly closed in the second half."""
    animate(square(), "location", (-20.0, 0, 0), (20.0, 0, 0))
    curve = scene.render.motion_blur_shutter_curve.curves[0]
    while len(curve.points) > 2:
        curve.points.remove(curve.points[1])
    curve.points[0].location, curve.points[1].location = (0.0, 1.0), (1.0, 0.1)
    middle = curve.points.new(0.5, 0.3)
    for point in (*curve.points, middle):
        point.handle_type = "VECTOR"
    scene.render.motion_blur_shutter_curve.update()
    assert_same_as_cycles(tmp_path)


def test_layer_that_is_switched_off(scene, tmp_path):
    animate(square(), "location", (-20.0, 0, 0), (20.0, 0, 0))
    bpy.context.view_layer.use_motion_blur = False
    assert_same_as_cycles(tmp_path)


MOMENTS = 8


def white() -> bpy.types.Material:
    material = bpy.data.materials.new("White")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    return material


def standing_picture(tmp_path, engine: str, seed: int, samples: int) -> np.ndarray:
    """The mean of pictures without motion blur in the moments that Bentlight draws for a seed."""
    scene = bpy.context.scene
    scene.render.engine, scene.render.use_motion_blur = engine, False
    still = []
    for number, moment in enumerate(slices(MOMENTS, MOMENTS, seed)):
        scene.cycles.seed = scene.bentlight.seed = 1000 + MOMENTS * seed + number
        scene.cycles.samples = scene.bentlight.samples = samples
        time = 4.75 + 0.5 * moment.light
        scene.frame_set(int(time), subframe=time % 1)
        still.append(stage.render(tmp_path)["Combined"][..., :3])
    scene.frame_set(5)
    scene.render.use_motion_blur = True
    return np.mean(still, axis=0)


def assert_mean_of_standing(tmp_path, engine: str, precision: float) -> None:
    """Bentlight's blurred pictures are the means of standing ones by an engine: the differences of pairs, in which it
    moves in the same moments, are 0 but for the noise.
    """
    seeds = 6
    bpy.context.scene.bentlight.motion_slices = MOMENTS
    (blurred,) = cycles_pictures.noisy_pictures(tmp_path, seeds, 32, engines=("BENTLIGHT",))
    standing = np.stack([standing_picture(tmp_path, engine, seed, 16) for seed in range(seeds)])
    mean = np.broadcast_to(blurred.mean(axis=0), blurred.shape)
    comparison = compare(mean + standing - blurred, mean, block=4)
    assert not comparison.differs(), str(comparison)
    assert comparison.precision < precision


@pytest.mark.parametrize("kind", ["square", "point"])
def test_light_of_what_moves(kind, scene, tmp_path):
    """A wall, lit by what the camera does not see. (Cycles' lamps do not move while the shutter is open, and its moving
    meshes give light that is 0.3 % off the mean of standing ones.)"""
    scene.cycles.light_sampling_threshold = scene.bentlight.light_threshold = 0.0
    stage.add_square(5, (0, 0, -0.5), white(), "Wall")
    lamp = square()
    if kind == "point":
        bpy.data.objects.remove(lamp)
        lamp = stage.add_light("POINT", energy=20.0, shadow_soft_size=0.2)
    lamp.visible_camera = False
    animate(lamp, "location", (-3.0, 0, 1.0), (3.0, 0, 1.0))
    assert_mean_of_standing(tmp_path, "CYCLES", 0.005)


MOVES = {
    "place": ("location", (-0.5, 0.2, 1.0), (0.5, 0.2, 1.0)),
    "mass": ("mass", 0.05, 0.3),
    "spin": ("spin", 0.0, 0.9),
}


@pytest.mark.parametrize("name", MOVES)
def test_moving_hole_is_the_mean_of_standing_ones(name, tmp_path):
    bpy.ops.bentlight.black_hole_add(mass=0.1, spin=0.0, location=(0, 0.2, 1))
    hole = bpy.context.object
    path, *values = MOVES[name]
    for frame, value in zip((4.75, 5.25), values, strict=True):
        setattr(hole if name == "place" else hole.bentlight, path, value)
        (hole if name == "place" else hole.bentlight).keyframe_insert(path, frame=frame)
    assert_mean_of_standing(tmp_path, "BENTLIGHT", 0.005)


def test_frame_is_as_before(scene, tmp_path):
    animate(square(), "location", (-10.0, 0, 0), (10.0, 0, 0))
    scene.render.engine = "BENTLIGHT"
    scene.frame_set(5, subframe=0.25)
    place = square().matrix_world.translation.x
    stage.render(tmp_path)
    assert (scene.frame_current, scene.frame_subframe) == (5, 0.25)
    assert square().matrix_world.translation.x == place
