"""The relay camera's maps: how fine they are, how much of them is there, and what becomes of them."""

import bpy
import numpy as np
import pytest

from blender_addon.cycles import files, relay, relay_maps, relay_operators, relay_parts
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.osl.test_relay_camera import cycles, picture, shining_room

PARTS = 4


def spread(steps, lost=(), layers=()):
    """Of a row of pixels whose rays start alike; from column to column they end `steps` apart, in radians. In some
    columns they are lost, in some they meet a disk."""
    angle = np.cumsum(steps) * np.ones((PARTS, 1))
    end = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
    fate, met = np.full(angle.shape, relay_parts.LOST + 1, np.uint8), np.zeros(angle.shape, np.uint32)
    fate[2:, lost], met[:, layers] = relay_parts.LOST, 1
    return relay_parts.spreads(np.zeros_like(end), end, fate, met, PARTS)


def compressed(*radians):
    """Pixels by twos over which rays spread so far: the last rays of one are as far from its neighbor's as from each
    other."""
    return spread(np.repeat(np.repeat(radians, 2) / PARTS, PARTS))


def test_parts_are_as_fine_as_the_image_is_compressed():
    """No finer than it takes for each to spread no more than those of an image that just is not compressed."""
    found = compressed(0.0, 0.09, 0.15, 0.29, 0.32, 1.5)
    assert relay_parts.times_as_fine(found)[0, ::2].tolist() == [0, 0, 3, 3, 5, 5]
    assert relay_parts.times_as_fine(found, 2.0)[0, ::2].tolist() == [0, 0, 0, 3, 3, 5]


def test_edges_of_things_do_not_take_the_finest_parts():
    """Bending goes on behind them: rays beside an edge end apart without any compression."""
    steps = np.zeros(PARTS * 4)
    steps[6] = 0.8
    assert relay_parts.times_as_fine(spread(steps)).tolist() == [[0, 3, 0, 0]]


def test_edges_of_shadows_and_disks_take_the_finest_parts():
    """Until no other pixels are left that take finer ones."""
    found = spread(np.full(PARTS * 6, 0.01 / PARTS), lost=slice(5, 7), layers=slice(17, None))
    for limit, times in ((1, 5), (256, 5), (512, 3), (1024, 0)):
        assert relay_parts.times_as_fine(found, limit).tolist() == [[0, times, 0, 0, times, 0]]


@pytest.mark.parametrize("ray_bytes", [24, 36])
def test_finer_parts_take_no_more_than_maps_may(ray_bytes, monkeypatch):
    """The most that they may, to a factor of two in what counts as compressed; all of them where there is room, as in
    small pictures."""
    few = [compressed(*np.zeros(60), 0.15), compressed(*np.zeros(61))]
    random = np.random.default_rng(1)
    many = [compressed(*random.exponential(0.3, 100)) for _ in range(5)]
    edges = [spread(np.zeros(PARTS * 100), layers=slice(0, None, 2))]
    assert relay_parts.affordable(many + edges, PARTS, ray_bytes) == 1
    monkeypatch.setattr(relay_parts, "_LEAST_BYTES", 0)
    assert relay_parts.affordable(few, PARTS, ray_bytes) == 1
    for found in (many, edges, many + edges):
        limit = relay_parts.affordable(found, PARTS, ray_bytes)
        pixels = sum(one.shape[2] * one.shape[3] for one in found)
        for tried, fits in ((limit, True), (limit / 2, False)):
            rays = sum((relay_parts.times_as_fine(one, tried) ** 2).sum() for one in found) + pixels
            assert (rays * ray_bytes <= 48 * pixels) == fits


def test_a_picture_that_is_compressed_all_over(tmp_path, monkeypatch, caplog):
    """It has the rays that it may have, and says so; what none of them is left to do is done as it was."""
    shining_room()
    bpy.ops.bentlight.black_hole_add(mass=0.3, location=(0, 0, 0))
    scene = cycles()
    scene.bentlight.relay_parts = 2
    bpy.ops.bentlight.relay_setup()
    whole, most = picture(tmp_path), relay._baked[scene.camera.name][1]
    assert most.limit == 1 and not caplog.text
    relay.forget_all()
    monkeypatch.setattr(relay_parts, "_LEAST_BYTES", 1 << 20)
    less, few = picture(tmp_path), relay._baked[scene.camera.name][1]
    assert few.limit > 1 and "raise Relay Parts" in caplog.text
    assert 0 < few.fine_pixels < most.fine_pixels
    padding = (-few.fine_pixels % relay_maps._COLUMNS) * 10**2  # cells fill whole rows
    assert (few.rays - padding) * 24 <= 1 << 20 < most.rays * 24
    kept = (less == whole).all(axis=-1)
    assert 0.2 < kept.mean() < 1


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
