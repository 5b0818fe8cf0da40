"""The pass Vector: in flat space as Cycles has it, on the sky by a closed form, and what Blender makes of it."""

import math

import bpy
import numpy as np
import OpenEXR
import pytest
from bentlight_native import Spacetime, trace_rays

from blender_addon import final
from tests.engine import stage
from tests.engine.cycles_pictures import NARROW
from tests.engine.stage import blender  # noqa: F401 (a fixture)

FRAME = 5
TOLERANCE = 2e-4  # pixels: float32 in Cycles
APART = 0.05  # pixels between samples of one pixel, at most: the filter is not infinitely narrow


@pytest.fixture(autouse=True)
def scene(blender) -> bpy.types.Scene:  # noqa: F811
    """A camera that looks along +y at a ball; one point a pixel, with the pass on."""
    scene = bpy.context.scene
    scene.frame_set(FRAME)
    scene.render.resolution_x, scene.render.resolution_y = 40, 28
    stage.add_camera((0, -6, 0), (math.pi / 2, 0, 0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=1.5)
    bpy.context.object.name = "Ball"
    scene.cycles.samples = scene.bentlight.samples = 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.bentlight.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type, scene.bentlight.pixel_filter = "BOX", "GAUSSIAN"
    scene.cycles.filter_width = scene.render.filter_size = NARROW
    scene.view_layers[0].use_pass_vector = scene.view_layers[0].use_pass_position = True
    return scene


def ball() -> bpy.types.Object:
    return bpy.data.objects["Ball"]


def animate(owner: bpy.types.bpy_struct, path: str, *values) -> None:
    """`values` in the frames before, of and after the picture."""
    for frame, value in zip((FRAME - 1, FRAME, FRAME + 1), values, strict=True):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    bpy.context.scene.frame_set(FRAME)


def moving_object() -> None:
    animate(ball(), "location", (-0.3, 0.2, 0), (0, 0, 0), (0.5, 0, 0.4))
    animate(ball(), "rotation_euler", (0, 0, 0), (0.2, 0.1, 0), (0.2, 0.3, 0.3))
    animate(ball(), "scale", (1, 1, 1), (1, 1.2, 1), (0.8, 1.2, 1))


def moving_camera() -> None:
    camera = bpy.context.scene.camera
    animate(camera, "location", (-0.2, -6, 0.1), (0, -6, 0), (0.1, -5.5, 0))
    animate(camera, "rotation_euler", (1.5, 0, 0.05), (math.pi / 2, 0, 0), (1.6, 0.1, -0.02))
    animate(camera.data, "lens", 48.0, 50.0, 55.0)


def changing_shape() -> None:
    """By a shape key, and by a modifier."""
    ball().shape_key_add(name="Basis")
    key = ball().shape_key_add(name="Bent")
    for point in key.data:
        point.co.x += 0.3 * point.co.z**2
    animate(key, "value", 0.0, 0.3, 1.0)
    cast = ball().modifiers.new("Cast", "CAST")
    cast.cast_type = "CUBOID"
    animate(cast, "factor", 0.1, 0.3, 0.2)


def instances() -> None:
    """Of a collection, whose empty moves; the ball itself moves too."""
    collection = bpy.data.collections.new("Flock")
    bpy.context.scene.collection.children.link(collection)
    bpy.context.scene.collection.objects.unlink(ball())
    collection.objects.link(ball())
    ball().scale = (0.4, 0.4, 0.4)
    bpy.context.view_layer.layer_collection.children["Flock"].exclude = True
    for side in (-1, 1):
        empty = bpy.data.objects.new("Empty", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        bpy.context.scene.collection.objects.link(empty)
        animate(empty, "location", (side, 0, 0.1), (1.2 * side, 0, 0), (1.2 * side, 0.5, 0.3 * side))


def parallel_rays() -> None:
    bpy.context.scene.camera.data.type = "ORTHO"
    moving_object()


def panorama() -> None:
    lens = bpy.context.scene.camera.data
    lens.type, lens.panorama_type = "PANO", "FISHEYE_EQUIDISTANT"
    lens.fisheye_fov = 1.2
    moving_object()


def both(scene, tmp_path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vectors by Cycles and by Bentlight, and where a surface is seen."""
    found = []
    for scene.render.engine in ("CYCLES", "BENTLIGHT"):
        passes = stage.render(tmp_path)
        found.append(passes["Vector"])
        assert scene.frame_current == FRAME
    return *found, (passes["Position"] != 0).any(axis=-1)


@pytest.mark.parametrize(
    "motion",
    [moving_object, moving_camera, changing_shape, instances, parallel_rays, panorama],
    ids=lambda motion: motion.__name__,
)
def test_surfaces_move_as_in_cycles(motion, scene, tmp_path):
    motion()
    cycles, ours, seen = both(scene, tmp_path)
    seen &= cycles.any(axis=-1)
    assert seen.mean() > 0.1 and np.abs(cycles[seen]).mean(axis=0).min() > 0.1
    wrong = (np.abs(cycles - ours) > TOLERANCE + APART * slope(cycles)).any(axis=-1)
    assert wrong[seen].mean() < 0.01


def slope(values: np.ndarray) -> np.ndarray:
    """How much values change from a pixel to one of its neighbors, at most."""
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)), mode="edge")
    beside = (padded[1:-1, 2:], padded[1:-1, :-2], padded[2:, 1:-1], padded[:-2, 1:-1])
    return np.max([np.abs(other - values) for other in beside], axis=0)


def test_edges_are_those_of_cycles(scene, tmp_path):
    """Where surfaces and the sky meet in a pixel, only the surface counts."""
    moving_object()
    scene.cycles.filter_width, scene.render.filter_size = 1.5, 1.5
    scene.cycles.pixel_filter_type = scene.bentlight.pixel_filter = "BOX"
    scene.cycles.samples = scene.bentlight.samples = 16
    scene.render.film_transparent = True
    cycles, ours, _ = both(scene, tmp_path)
    alpha = stage.render(tmp_path)["Combined"][..., 3]
    edge = (alpha > 0.2) & (alpha < 0.8)
    assert edge.sum() > 20
    assert np.median(np.linalg.norm(cycles - ours, axis=-1)[edge]) < 0.05 * np.median(
        np.linalg.norm(cycles, axis=-1)[edge]
    )


def test_the_sky_turns_with_the_camera(scene, tmp_path):
    """Cycles leaves it 0. Directions of the sky are seen elsewhere, by the camera's own rotation alone."""
    moving_camera()
    scene.render.engine = "BENTLIGHT"
    passes = stage.render(tmp_path)
    sky = ~(passes["Position"] != 0).any(axis=-1)
    places = pixel_centers(scene)[sky]
    found = []
    for frame in (FRAME, FRAME - 1, FRAME + 1):
        scene.frame_set(frame)
        slope = 36 / scene.camera.data.lens
        turned = np.array(scene.camera.matrix_world)[:3, :3]
        if frame == FRAME:
            x, y = ((places - 0.5) * (slope, slope * 28 / 40)).T
            directions = np.stack([x, y, -np.ones_like(x)], axis=1) @ turned.T
        x, y, z = (directions @ turned).T
        found.append((np.stack([x / -z / slope, y / -z / slope * 40 / 28], axis=1) + 0.5) * (40, 28))
    now, before, after = found
    np.testing.assert_allclose(passes["Vector"][sky], np.hstack([before - now, now - after]), atol=2e-3)


def pixel_centers(scene) -> np.ndarray:
    """(height, width, 2), in [0, 1]."""
    width, height = scene.render.resolution_x, scene.render.resolution_y
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return np.stack([x, y], axis=-1)


def test_a_hole_that_moves_drags_the_images_of_the_sky(scene, tmp_path):
    """A ray through the place that a vector leads to, around the next frame's hole, leaves in the same direction."""
    bpy.data.objects.remove(ball())
    bpy.ops.bentlight.black_hole_add(mass=0.2)
    hole = bpy.context.object
    animate(hole, "location", (-0.2, 0, 0.1), (0, 0, 0), (0.3, 0.1, 0))
    scene.bentlight.photon_ring_samples = 1
    scene.view_layers[0].bentlight.use_pass_fate = True
    passes = stage.render(tmp_path)
    vectors, fate = passes["Vector"].reshape(-1, 4), passes["Bentlight Fate"].ravel()
    places = pixel_centers(scene).reshape(-1, 2)
    known = vectors.any(axis=-1)
    assert known[fate == 1].mean() > 0.98 and not known[fate == 2].any() and (fate == 2).mean() > 0.1
    ends = []
    moments = (((0, 0, 0), 0 * vectors[:, 2:]), ((0.3, 0.1, 0), -vectors[:, 2:]), ((-0.2, 0, 0.1), vectors[:, :2]))
    for place, shift in moments:
        slope = (places + shift / (40, 28) - 0.5)[known] * (36 / 50, 36 / 50 * 28 / 40)
        rays = np.stack([slope[:, 0], np.ones(len(slope)), slope[:, 1]], axis=1)
        origins = np.tile(np.array([0, -6, 0.0]) - place, (len(rays), 1))
        traced = trace_rays(Spacetime.schwarzschild(0.2, "isotropic"), origins, rays, tolerance=1e-9)
        ends.append(traced["direction"])
    for other in ends[1:]:
        off = np.linalg.norm(other - ends[0], axis=1)
        assert np.median(off) < 1e-4 and np.percentile(off, 90) < 2e-2 * (36 / 50 / 40)


def test_motion_blur_leaves_no_vectors(scene, tmp_path):
    """As in Cycles: neither where Blender blurs the scene, but where it does not blur this layer."""
    moving_object()
    scene.render.use_motion_blur = True
    for scene.render.engine in ("CYCLES", "BENTLIGHT"):
        scene.view_layers[0].use_motion_blur = True
        assert not stage.render(tmp_path)["Vector"].any()
        scene.view_layers[0].use_motion_blur = False
        assert stage.render(tmp_path)["Vector"].any()


def test_frames_around_are_read_only_for_the_pass(scene, tmp_path):
    """And another frame, with persistent data, has its own."""
    moving_object()
    scene.render.engine, scene.render.use_persistent_data = "BENTLIGHT", True
    visited = []

    def note(at: bpy.types.Scene, *_unused: object) -> None:
        visited.append(at.frame_current)

    scene.view_layers[0].use_pass_vector = False
    bpy.app.handlers.frame_change_post.append(note)
    try:
        stage.render(tmp_path)
        assert set(visited) == {FRAME}
        scene.view_layers[0].use_pass_vector = True
        first = stage.render(tmp_path)["Vector"]
        assert [frame for frame in visited if frame != FRAME] == [FRAME - 1, FRAME + 1]
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    scene.frame_set(FRAME + 1)
    second = stage.render(tmp_path)["Vector"]
    scene.render.use_persistent_data = False
    assert np.array_equal(second, stage.render(tmp_path)["Vector"])
    scene.frame_set(FRAME)
    assert np.array_equal(first, stage.render(tmp_path)["Vector"])


def vanishing_ball() -> None:
    animate(ball(), "scale", (1, 1, 1), (1, 1, 1), (0, 0, 0))


def spheres_that_meet() -> None:
    for x in (-4, 4):
        bpy.ops.bentlight.black_hole_add(mass=0.1, location=(x, 9, 0))
        bpy.context.object.bentlight.influence = "SPHERE"
        bpy.context.object.bentlight.sphere_radius = 3
    animate(bpy.context.object, "location", (-1, 9, 0), (4, 9, 0), (4, 9, 0))


def mouth_that_opens() -> None:
    bpy.ops.bentlight.wormhole_add(throat_radius=0.2, location=(9, 9, 0), exit_location=(-9, 9, 0))
    animate(bpy.context.object, "hide_render", True, False, False)


def camera_that_leaves_a_horizon() -> None:
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, -20, 0))
    animate(bpy.context.scene.camera, "location", (0, -20, 0), (0, -6, 0), (0, -6, 0))


@pytest.mark.parametrize(
    ("motion", "reason"),
    [
        (vanishing_ball, "'Ball'"),
        (spheres_that_meet, "spheres of influence"),
        (mouth_that_opens, "its exit"),
        (camera_that_leaves_a_horizon, "inside the horizon"),
    ],
)
def test_a_frame_around_that_cannot_be_read_fails_no_picture(motion, reason, scene, tmp_path, capfd):
    scene.view_layers[0].use_pass_vector = False
    motion()
    without = stage.render(tmp_path)
    capfd.readouterr()
    scene.view_layers[0].use_pass_vector = True
    passes = stage.render(tmp_path)
    said = "".join(capfd.readouterr())
    assert "The Vector pass is 0: the frame before or after cannot be read: " in said and reason in said
    assert not passes.pop("Vector").any() and scene.frame_current == FRAME
    for name, expected in without.items():
        assert np.array_equal(passes[name], expected), name


@pytest.mark.parametrize("motion", [moving_object, vanishing_ball], ids=lambda motion: motion.__name__)
def test_the_scene_is_in_its_frame_while_tiles_are_rendered(motion, scene, tmp_path, monkeypatch):
    """Scripts that look at it meanwhile, and the user, see the picture's frame."""
    motion()
    frames, session = [], final.Session

    def begin(*arguments, **options):
        frames.append(scene.frame_current)
        return session(*arguments, **options)

    monkeypatch.setattr(final, "Session", begin)
    stage.render(tmp_path)
    assert frames == [FRAME]


def test_files_name_its_channels_as_cycles_does(scene, tmp_path):
    names = []
    for scene.render.engine in ("CYCLES", "BENTLIGHT"):
        stage.render(tmp_path)
        with OpenEXR.File(str(tmp_path / "render.exr"), separate_channels=True) as file:
            names.append({name for part in file.parts for name in part.channels if "Vector" in name})
    assert names[0] == names[1] == {f"ViewLayer.Vector.{letter}" for letter in "XYZW"}
