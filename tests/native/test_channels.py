"""Channels in places where a pass may easily be wrong, against what geometry says."""

import numpy as np
import pytest
from bentlight_native import (
    CHANNELS,
    FATES,
    Cancelled,
    Part,
    PartError,
    Picture,
    Piece,
    Progress,
    RenderSettings,
    Spacetime,
    empty_state,
    write_exr,
)
from bentlight_native.parts import merge
from scenes import IDENTITY, add, diffuse, emission, look_at, new_scene, perspective, quad, render
from test_sky_filter import image_sky


def placed(*place):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


@pytest.mark.parametrize("spacetime", [Spacetime.schwarzschild(1.0), Spacetime.kerr(1.0, 0.9), Spacetime.ellis(1.0)])
def test_a_far_hole_occludes_nothing(spacetime):
    """No surface is near: rays that end in the hole, or beyond the throat, are as free as those that reach the sky."""
    scene = new_scene()
    add(scene, quad(50, 50), diffuse((0.5, 0.5, 0.5)))
    scene.set_spacetime(spacetime, placed(0, 0, 20))
    perspective(scene, placed(0, 0, 3))
    scene.commit()
    channels, _ = render(scene, 8, 8, 64, names=("ambient_occlusion",), occlusion_distance=1.0)
    np.testing.assert_allclose(channels["ambient_occlusion"], 1, rtol=1e-6)


@pytest.mark.parametrize(
    "spacetime",
    [Spacetime.schwarzschild(0.3), Spacetime.kerr(0.3, 0.27), Spacetime.ellis(0.6)],
    ids=["schwarzschild", "kerr", "ellis"],
)
def test_occlusion_near_a_hole_is_what_rays_from_there_meet(spacetime):
    """One place of a floor, a hole above it and a roof behind: of random rays by their cosine, the part that meets
    neither the roof nor, bent back, the floor within the distance. Straight rays would meet the roof far more often."""
    scene, distance = new_scene(), 5.0
    add(scene, quad(50, 50), diffuse((0.5, 0.5, 0.5)))
    add(scene, quad(2, 2), diffuse((0.5, 0.5, 0.5)), at=placed(0, 0, 2))
    scene.set_spacetime(spacetime, placed(0.2, 0.1, 1))
    perspective(scene, placed(-0.3, 0, 0.1), half=1e-6)
    scene.commit()
    names = ("ambient_occlusion", "position")
    seen, _ = render(scene, 8, 8, 48, names=names, occlusion_distance=distance, max_bounces=0)
    place = seen["position"].reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(seen["position"] - place, 0, atol=1e-5)
    across, turn = np.random.default_rng(5).uniform(size=(2, 8 * 8 * 48)) * [[1], [2 * np.pi]]
    rays = np.stack([*np.sqrt(across) * (np.cos(turn), np.sin(turn)), np.sqrt(1 - across)], axis=1)
    starts = np.tile((*place[:2].astype(float), 1e-6), (len(rays), 1))
    met = scene.intersect(starts, rays, 1e-5, length_max=distance)["fate"] == FATES.index("hit")
    error = np.sqrt(2 * met.mean() * (1 - met.mean()) / len(rays))
    assert abs(1 - seen["ambient_occlusion"].mean() - met.mean()) < 4 * error
    length = 2 / rays[:, 2]
    straight = (np.abs(starts + rays * length[:, None])[:, :2] < 2).all(axis=1) & (length < distance)
    assert straight.mean() - met.mean() > 5 * error


def test_deflection_of_parallel_rays_inside_and_outside_of_a_sphere():
    """An orthographic camera in a sphere sends rays from outside of it too: neither kind has come through a throat."""
    scene = new_scene((1, 1, 1))
    scene.set_spacetime_objects([(Spacetime.schwarzschild(1e-4), IDENTITY, 1.0, -1)])
    scene.set_camera("ORTHOGRAPHIC", placed(0.2, 0, 0), (-3, 3, -3, 3))
    add(scene, quad(9, 9), emission((1, 1, 1)), at=placed(0, 0, -4))
    scene.commit()
    places = render(scene, 16, 16, 1, names=("deflection",))[0]["deflection"]
    assert (places[..., 2] == 1).all()
    x, y = np.meshgrid((np.arange(16) + 0.5) / 16, (np.arange(16) + 0.5) / 16)
    np.testing.assert_allclose(places[..., :2], np.stack([x, y], -1), atol=1e-3)


def test_denoising_depth_counts_the_way_through_what_is_not_there():
    """The backs of one-sided surfaces and of lamps let rays pass: the way goes on behind them."""
    scene = new_scene((0, 0, 0))
    add(scene, quad(), emission((5, 5, 5)), at=look_at((0, 0, 3), (0, 0, 6), (0, 1, 0)), one_sided=True)
    add(scene, quad(9, 9), diffuse((1, 1, 1)), at=placed(0, 0, -4))
    perspective(scene, placed(0, 0, 6), half=0.01)
    scene.commit()
    turned = new_scene((0, 0, 0))
    add(turned, quad(9, 9), diffuse((1, 1, 1)), at=placed(0, 0, -4))
    perspective(turned, placed(0, 0, 6), half=0.01)
    turned.commit()
    with_back, without = (
        render(each, 4, 4, 4, names=("denoising_depth",))[0]["denoising_depth"] for each in (scene, turned)
    )
    np.testing.assert_allclose(without, 10, rtol=1e-3)
    np.testing.assert_allclose(with_back, without, rtol=1e-5)


def test_an_image_of_the_sky_that_changes_is_sampled_anew():
    """Edited or new, a scene gives the same picture to the last bit: the map of bright places follows the image."""
    pictures = []
    sun = np.zeros((64, 128, 4), np.float32)
    sun[50, 40, :3] = 1000
    for edits in ([sun], [np.full((64, 128, 4), 0.1, np.float32), sun]):
        scene = image_sky(edits[0])
        add(scene, quad(50, 50), diffuse((0.5, 0.5, 0.5)))
        perspective(scene, placed(0, 0, 3))
        scene.commit()
        for pixels in edits[1:]:
            scene.update_image(0, pixels)
            scene.commit()
        pictures.append(render(scene, 8, 8, 4, names=("combined",))[0]["combined"])
    np.testing.assert_array_equal(*pictures)
    assert pictures[0][..., :3].min() > 0  # chance alone does not find the sun


@pytest.mark.parametrize("group", [1, 1431655766, 2**31 - 1])
def test_light_groups_that_are_not_there_get_no_light(group):
    scene = new_scene((1, 1, 1))
    perspective(scene)
    scene.set_labels(world_group=group)
    scene.commit()
    names = ("combined", "light_groups", "aovs")
    channels, _ = render(scene, 4, 4, 4, names=names, light_groups=1)
    assert (channels["combined"][..., :3] == 1).all()
    assert not channels["light_groups"].any() and not channels["aovs"].any()


def test_a_resumed_call_that_is_cancelled_at_once_has_what_there_was():
    scene = new_scene((0.5, 0.6, 0.7))
    perspective(scene)
    scene.commit()
    names, progress = ("combined", "sample_count"), Progress()
    settings = RenderSettings(8, 8, sample_count=4, photon_ring_samples=8)
    state = empty_state(names, settings, 8, 8)
    done = {name: np.zeros((8, 8, CHANNELS[name].components), np.float32) for name in names}
    scene.render_tile(0, 0, 8, 8, settings, done, state=state)
    progress.cancel()
    more = RenderSettings(8, 8, first_sample=4, sample_count=4, photon_ring_samples=8, resume=True)
    channels = {name: np.full_like(values, np.nan) for name, values in done.items()}
    with pytest.raises(Cancelled):
        scene.render_tile(0, 0, 8, 8, more, channels, progress, state=state)
    for name in names:
        np.testing.assert_array_equal(channels[name], done[name])


def test_long_names_are_told_of(tmp_path):
    """OpenEXR 2: names of more than 31 bytes need a flag in the file's version."""
    for name, flag in (("R", 0), ("V" * 31, 0), ("V" * 32, 0x400)):
        write_exr(tmp_path / "file.exr", {name: np.zeros((2, 3), np.float32)}, {})
        version = int.from_bytes((tmp_path / "file.exr").read_bytes()[4:8], "little")
        assert version & 0x400 == flag


def test_parts_with_stars_and_without_are_different_pictures():
    names, settings = ("combined", "sample_count"), RenderSettings(4, 4, sample_count=2)
    picture = Picture("Layer", "", 1, settings, (0, 0, 4, 4), False, names, (), "scene")
    parts = [Part(picture, [Piece(0, 0, 4, 4, i, 1)], empty_state(names, settings, 4, 4)) for i in range(2)]
    parts[0].stars = np.zeros((4, 4, 3), np.float32)
    for order in (parts, parts[::-1]):
        with pytest.raises(PartError, match="stars"):
            merge(order)
