"""The relay camera's maps: how fine they are, how much of them is there, and what becomes of them."""

import bpy
import numpy as np
import pytest

from blender_addon.cycles import files, relay, relay_maps, relay_operators
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.osl.test_relay_camera import cycles, picture, shining_room

PARTS = 4
LOST, SEEN = relay_maps._LOST, relay_maps._SEEN


def rays(steps: np.ndarray) -> relay_maps._Traced:
    """A row of pixels whose rays start alike; from column to column they end `steps` apart, in radians."""
    angle = np.cumsum(steps) * np.ones((PARTS, 1))
    end = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1).reshape(-1, 3)
    start, count = np.tile((0.0, 0.0, 1.0), (len(end), 1)), len(end)
    return relay_maps._Traced(None, start, end, np.full(count, SEEN, np.uint8), np.zeros(count, np.uint32))


def test_parts_are_as_fine_as_the_image_is_compressed():
    """No finer than it takes for each to spread no more than those of an image that just is not compressed."""
    spread = [0.0, 0.09, 0.15, 0.29, 0.32, 1.5]
    pairs = np.repeat(spread, 2)  # the last rays of a pixel are as far from its neighbor's as this one's are
    steps = np.repeat(pairs / PARTS, PARTS)
    times = relay_maps._times_as_fine(rays(steps), (PARTS, len(steps)), PARTS)
    assert times[0, ::2].tolist() == [0, 0, 3, 3, 5, 5]


def test_edges_of_things_do_not_take_the_finest_parts():
    """Bending goes on behind them: rays beside an edge end apart without any compression."""
    steps = np.zeros(PARTS * 4)
    steps[6] = 0.8
    assert relay_maps._times_as_fine(rays(steps), (PARTS, len(steps)), PARTS).tolist() == [[0, 3, 0, 0]]


def test_edges_of_shadows_and_disks_take_the_finest_parts():
    shape = PARTS, PARTS * 6
    traced = rays(np.full(PARTS * 6, 0.01 / PARTS))
    fate, layers = traced.fate.reshape(shape), traced.layers.reshape(shape)
    fate[2:, 5:7] = LOST
    layers[:, 17:] = 1
    assert relay_maps._times_as_fine(traced, shape, PARTS).tolist() == [[0, 5, 0, 0, 5, 0]]


@pytest.mark.parametrize("blurred", [False, True], ids=["still", "blurred"])
def test_a_border_has_the_pixels_of_the_whole(blurred, tmp_path):
    """Rendered in the whole's frame, and cropped."""
    shining_room()
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0))
    scene = cycles()
    scene.bentlight.relay_parts = 2
    scene.render.use_motion_blur = blurred
    bpy.ops.bentlight.relay_setup()
    whole = picture(tmp_path)
    height, width, _ = whole.shape
    inside = slice(height * 3 // 8, height * 7 // 8), slice(width // 4, width * 3 // 4)
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.375, 0.875
    np.testing.assert_array_equal(picture(tmp_path)[inside], whole[inside])
    scene.render.use_crop_to_border = True
    np.testing.assert_array_equal(picture(tmp_path), whole[inside])


def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path, monkeypatch, caplog):
    """The picture is black, and the maps that were written are no longer there: they may be what has filled it."""
    shining_room()
    cycles().bentlight.relay_parts = 4
    bpy.ops.bentlight.relay_setup(bake=False)
    write, written = relay_maps.write_exr, []

    def fill(path, *args):
        if len(written) >= 2:
            raise OSError("No space left on device")
        write(path, *args)
        written.append(path)

    monkeypatch.setattr(relay_maps, "write_exr", fill)
    assert not picture(tmp_path).any()
    assert "No space left" in caplog.text
    assert len(written) >= 2 and not list(files.folder("relay").glob(f"{relay._SESSION}_*"))
    monkeypatch.undo()
    assert picture(tmp_path).any()


def test_another_blender_has_maps_of_its_own(tmp_path, monkeypatch):
    """Two that render the same scene, as on a farm: what one deletes, the other still has."""
    shining_room()
    scene = cycles()
    scene.bentlight.relay_parts = 1
    bpy.ops.bentlight.relay_setup()
    ours = relay._baked[scene.camera.name][1].files
    monkeypatch.setattr(relay, "_baked", {})
    monkeypatch.setattr(relay, "_SESSION", "other")
    relay_operators._before_render(scene)
    relay.forget_all()
    assert all(file.exists() for file in ours)
    relay_maps.remove(ours)


def test_footprints_have_the_moments_of_changes():
    """Axes of an ellipse, square to each other and to the direction, whose squares add up as the changes' do."""
    random = np.random.default_rng(5)
    toward, right, up = random.normal(size=(3, 1000, 3))
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    right[:10] = up[10:20] = 0
    right[20:30] = 2 * up[20:30]
    told = relay_maps.ellipse(toward, right, up)
    across = np.eye(3) - toward[:, :, None] * toward[:, None]
    right, up = (np.einsum("nij,nj->ni", across, change) for change in (right, up))
    narrow = (told * toward).sum(axis=1, keepdims=True)
    major = told - narrow * toward
    minor = narrow * np.cross(toward, major / np.linalg.norm(major, axis=1, keepdims=True))
    assert (narrow[:, 0] <= np.linalg.norm(major, axis=1) + 1e-12).all() and (narrow > -1e-12).all()
    one, other = (x[:, :, None] * x[:, None] + y[:, :, None] * y[:, None] for x, y in ((major, minor), (right, up)))
    np.testing.assert_allclose(one, other, atol=1e-12)
