"""Motion blur by the relay camera: as Cycles' own in flat space, as the mean of Bentlight's stills near a hole."""

import bpy
import numpy as np
import pytest

from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.osl.test_relay_camera import cycles, picture, shining_room

SEEDS = 4


def blurred(samples: int) -> bpy.types.Scene:
    """Boxes full of samples in pixels, the shutter open for a whole frame around frame 1."""
    scene = cycles(samples)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)
    return scene


def move(obj: bpy.types.Object, way: tuple[float, float, float], turn: float = 0.0) -> None:
    """So far in each frame, evenly."""
    place, angle = np.array(obj.location), obj.rotation_euler.z
    for frame in (0, 2):
        obj.location, obj.rotation_euler.z = place + (frame - 1) * np.array(way), angle + (frame - 1) * turn
        obj.keyframe_insert("location", frame=frame)
        obj.keyframe_insert("rotation_euler", frame=frame)
    stage.make_even(obj)
    bpy.context.scene.frame_set(1)


def pictures(tmp_path, engine: str = "CYCLES", seeds: int = SEEDS) -> np.ndarray:
    """RGB by seed, (seeds, height, width, 3)."""
    scene, found = bpy.context.scene, []
    for seed in range(seeds):
        scene.cycles.seed = scene.bentlight.seed = seed
        found.append(picture(tmp_path, engine))
    return np.stack(found)


def blocks(values: np.ndarray) -> np.ndarray:
    """Means of 8 x 8 pixels."""
    return values.reshape(len(values), 6, 8, 8, 8, -1).mean(axis=(2, 4))


def mean_square_z(one: np.ndarray, other: np.ndarray) -> float:
    """Of blocks. The parts of pixels are fixed: an error of half a thousandth does not average out."""
    variance = one.var(axis=0, ddof=1) / len(one) + other.var(axis=0, ddof=1) / len(other) + 5e-4**2
    return float(np.mean((one.mean(axis=0) - other.mean(axis=0)) ** 2 / variance))


def test_in_flat_space_it_is_cycles_own(tmp_path):
    """A camera that moves and turns, objects that do, and one whose blur is switched off."""
    shining_room()
    scene = blurred(24)
    move(scene.camera, (0.4, 0.1, 0.2), 0.1)
    move(bpy.data.objects["red"], (0.6, 0.0, 0.5), 0.4)
    move(bpy.data.objects["green"], (-0.3, 0.2, 0.0))
    move(bpy.data.objects["blue"], (0.5, 0.0, 0.4))
    bpy.data.objects["blue"].cycles.use_motion_blur = False
    scene.bentlight.relay_parts = 12
    own = pictures(tmp_path)
    bpy.ops.bentlight.relay_setup()
    relayed = pictures(tmp_path)
    scene.render.use_motion_blur = False
    assert np.abs(picture(tmp_path) - own.mean(axis=0)).max() > 0.1, "it is blurred"
    assert abs((own - relayed).mean()) < 3e-4
    assert mean_square_z(blocks(own), blocks(relayed)) < 1.6  # 1.5 is expected of the few seeds


def stills(tmp_path, count: int, apart: float) -> np.ndarray:
    """Means of Bentlight's pictures in `count` moments of the shutter's time, by seed: the middles of equal parts, or
    each seed's own moments, `apart` of a part from one seed to the next."""
    scene, found = bpy.context.scene, []
    scene.render.use_motion_blur = False
    for seed in range(SEEDS):
        scene.bentlight.seed = seed
        seen = []
        for i in range(count):
            time = 0.5 + (i + 0.5 + apart * (seed - (SEEDS - 1) / 2)) / count
            scene.frame_set(int(time), subframe=time % 1)
            seen.append(picture(tmp_path, "BENTLIGHT"))
        found.append(np.mean(seen, axis=0))
    scene.render.use_motion_blur = True
    scene.frame_set(1)
    return np.stack(found)


@pytest.mark.parametrize(("moving", "apart"), [("red", 1 / SEEDS), ("Black hole", 0)])
def test_near_a_hole_it_is_the_mean_of_stills(moving, apart, tmp_path):
    """What moves between slices moves within them too; the hole itself jumps from slice to slice."""
    shining_room()
    bpy.ops.bentlight.black_hole_add(mass=0.1, spin=0.6, location=(0, 0, 0))
    bpy.context.object.name = "Black hole"
    scene = blurred(16)
    scene.bentlight.samples = 4
    move(bpy.data.objects[moving], (0.7, 0.0, -0.3))
    scene.bentlight.relay_parts = 4
    still = stills(tmp_path, scene.bentlight.relay_slices, apart)
    bpy.ops.bentlight.relay_setup()
    relayed = pictures(tmp_path)
    assert mean_square_z(blocks(still), blocks(relayed)) < 1.6


def test_it_comes_and_goes_with_motion_blur(tmp_path):
    """Without it there is no screen; in the end nothing is left, and the language that the screen needs is off."""
    shining_room()
    scene = cycles()
    scene.bentlight.relay_parts = 2
    own = picture(tmp_path)
    bpy.ops.bentlight.relay_setup()
    sharp = picture(tmp_path)
    scene.render.use_motion_blur = True
    frame = scene.frame_current, scene.frame_subframe
    picture(tmp_path)
    assert len(scene.camera.children) == 1 and scene.cycles.shading_system
    assert (scene.frame_current, scene.frame_subframe) == frame
    scene.render.use_motion_blur = False
    np.testing.assert_array_equal(picture(tmp_path), sharp)
    assert not scene.camera.children
    scene.render.use_motion_blur = True
    picture(tmp_path)
    bpy.ops.bentlight.relay_clear()
    assert not scene.cycles.shading_system and len(bpy.data.meshes) == len(bpy.data.materials) == 3
    scene.render.use_motion_blur = False
    np.testing.assert_array_equal(picture(tmp_path), own)
