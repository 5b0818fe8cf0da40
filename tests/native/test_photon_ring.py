"""More samples where bending spreads a pixel's rays: how many, which ones, and what they are worth."""

from dataclasses import replace

import meshes
import numpy as np
import pytest
from bentlight_native import (
    CHANNELS,
    Progress,
    RenderSettings,
    Spacetime,
    develop_state,
    empty_state,
    merge_states,
)
from bentlight_native.geometry import CAPTURED, ESCAPED_FAR, UNRESOLVED
from scenes import add, diffuse, emission, look_at, new_scene, perspective, render
from test_direct_light import placed

WIDTH, HEIGHT = 48, 36


def scene_of(spacetime, sky=(0.3, 0.5, 0.7), shine=(2, 1, 0.5)):
    """Balls that shine around an object that bends light, one of them before it, seen against the sky."""
    scene = new_scene(sky)
    ball = scene.add_mesh(*meshes.sphere(1.0, segments=24, rings=12))
    bright = add(scene, meshes.sphere(1.0, segments=24, rings=12), emission(shine), at=placed(-8, 1, 2))
    assert bright == 0
    for place in [(3, -2, 1), (-6, -3, -2), (-2, 6, 0)]:
        scene.add_instance(ball, placed(*place))
    if spacetime is not None:
        scene.set_spacetime(spacetime)
    perspective(scene, look_at((9, 0, 2), (0, 0, 0)), half=0.45, aspect=WIDTH / HEIGHT)
    scene.commit()
    return scene


def expected_multiples(scene, distance, most):
    """The rule, from the scene's own rays through the corners of all pixels."""
    u, v = np.meshgrid(np.arange(WIDTH + 1) / WIDTH, np.arange(HEIGHT + 1) / HEIGHT)
    rays = scene.camera_rays(np.stack([u.ravel(), v.ravel()], axis=1))
    shape = HEIGHT + 1, WIDTH + 1
    launch = rays.directions.reshape(*shape, 3)
    tolerance = {"tolerance": 1e-4 * distance, "angular_tolerance": 1e-4}
    traces = [scene.intersect(rays.origins, rays.directions, visibility=bits, **tolerance) for bits in (1, 0)]

    def spread(a, b):
        values = []
        for trace in traces:
            direction = trace["direction"].reshape(*shape, 3)
            fate = trace["fate"].reshape(shape)
            side = np.select([np.isin(fate, (CAPTURED, UNRESOLVED)), fate == ESCAPED_FAR], [0, 2], 1)
            before, after = (np.linalg.norm(rays[a] - rays[b], axis=-1) for rays in (launch, direction))
            values.append(np.where(side[a] != side[b], np.inf, np.where(side[a] == 0, 0, after - before)))
        return np.minimum(*values)

    across = spread(np.s_[:, 1:], np.s_[:, :-1])
    upwards = spread(np.s_[1:, :], np.s_[:-1, :])
    widest = np.max([across[1:], across[:-1], upwards[:, 1:], upwards[:, :-1]], axis=0)
    return np.clip(np.floor(1.5 + np.maximum(widest, 0) / 0.1), 1, most)


SPACETIMES = {
    "schwarzschild": Spacetime.schwarzschild(0.5),
    "kerr": Spacetime.kerr(0.5, 0.45),
    "ellis": Spacetime.ellis(1.5),
}


@pytest.mark.parametrize("name", SPACETIMES)
def test_the_number_of_samples_is_as_the_rule_says(name):
    scene, distance = scene_of(SPACETIMES[name]), np.sqrt(85)
    for most in (2, 8, 64):
        wanted = expected_multiples(scene, distance, most)
        counts = render(scene, WIDTH, HEIGHT, 3, names=("sample_count",), photon_ring_samples=most)[0]["sample_count"]
        np.testing.assert_array_equal(counts[..., 0], 3 * wanted)
    assert (wanted == 64).any() and 0.5 < (wanted == 1).mean() < 1  # the ring, and most of the picture


def test_the_width_of_the_ring_does_not_depend_on_the_resolution():
    """Angles go like the logarithm of the distance from the critical curve: its n-th pixel is 1/n radians wide. So a
    curve of C pixels asks for about C sum_n (10/n) extra samples at any resolution: they stay in proportion to C."""
    scene = scene_of(Spacetime.schwarzschild(0.5))
    extra = []
    for scale in (2, 4, 8):
        width, height = WIDTH * scale, HEIGHT * scale
        names = ("sample_count",)
        counts = render(scene, width, height, 1, names=names, photon_ring_samples=8, max_bounces=0)[0]["sample_count"]
        extra.append((counts - 1).sum() / scale)
    assert extra[1] == pytest.approx(extra[0], rel=0.1) and extra[2] == pytest.approx(extra[1], rel=0.1)


def test_nothing_is_taken_where_nothing_is_compressed():
    """Flat space, a hole without mass, and a hole behind a wall."""
    hidden = scene_of(Spacetime.schwarzschild(0.5))
    add(hidden, meshes.box((5, -9, -9), (5.5, 9, 9)), diffuse((1, 1, 1)))
    hidden.commit()
    for scene in (scene_of(None), scene_of(Spacetime.minkowski()), hidden):
        counts = render(scene, WIDTH, HEIGHT, 1, names=("sample_count",), photon_ring_samples=64)[0]["sample_count"]
        assert (counts == 1).all()


def test_a_surface_before_the_hole_has_an_ordinary_edge():
    """Bending leads rays that pass a ball elsewhere than those that meet it: that alone is no compression."""
    near = new_scene((1, 1, 1))
    add(near, meshes.sphere(0.6, segments=48, rings=24), diffuse((1, 1, 1)), at=placed(5, 1.9, 0.8))
    near.set_spacetime(Spacetime.schwarzschild(0.2))
    perspective(near, look_at((9, 0, 2), (0, 0, 0)), half=0.45, aspect=WIDTH / HEIGHT)
    near.commit()
    channels = render(near, WIDTH, HEIGHT, 16, names=("sample_count", "normal"), photon_ring_samples=64)[0]
    share = np.linalg.norm(channels["normal"], axis=-1)
    edge = (share > 0.1) & (share < 0.9)
    assert edge.sum() > 20 and (channels["sample_count"][edge] == 16).all()


@pytest.fixture(scope="module")
def hole():
    return scene_of(Spacetime.schwarzschild(0.5))


def test_a_pixel_takes_its_own_next_samples(hole):
    """A pixel that takes m samples for one is, bit for bit, what it is with m times the samples for all."""
    names = ("combined", "normal", "winding", "depth", "sample_count")
    ring, _ = render(hole, WIDTH, HEIGHT, 3, names=names, photon_ring_samples=4)
    for multiple in (1, 2, 3, 4):
        plain, _ = render(hole, WIDTH, HEIGHT, 3 * multiple, names=names)
        there = ring["sample_count"][..., 0] == 3 * multiple
        assert there.any()
        for name in names:
            np.testing.assert_array_equal(ring[name][there], plain[name][there], err_msg=name)


def test_tiles_and_rounds_do_not_matter_and_ranges_merge(hole):
    settings = {"photon_ring_samples": 8}
    whole, _ = render(hole, WIDTH, HEIGHT, 7, **settings)
    part, _ = render(hole, WIDTH, HEIGHT, 7, tile=(17, 11, 13, 9), **settings)
    for name, values in part.items():
        np.testing.assert_array_equal(values, whole[name][11:20, 17:30], err_msg=name)
    a, _ = render(hole, WIDTH, HEIGHT, 3, **settings)
    b, _ = render(hole, WIDTH, HEIGHT, 4, first_sample=3, **settings)
    assert (a["sample_count"] + b["sample_count"] == whole["sample_count"]).all()
    share = b["sample_count"] / whole["sample_count"]
    np.testing.assert_allclose((1 - share) * a["combined"] + share * b["combined"], whole["combined"], rtol=1e-6)
    resumed = {name: values.copy() for name, values in a.items()}
    more = RenderSettings(WIDTH, HEIGHT, first_sample=3, sample_count=4, resume=True, **settings)
    hole.render_tile(0, 0, WIDTH, HEIGHT, more, resumed)
    np.testing.assert_array_equal(resumed["sample_count"], whole["sample_count"])
    np.testing.assert_allclose(resumed["combined"], whole["combined"], rtol=1e-6)


def test_moments_count_by_their_samples_however_many_parts_those_have(hole):
    """A hole that has moved: each moment's samples add up to what they are alone, to the last bit in any order."""
    names, settings = ("combined", "normal", "sample_count", "matte_object"), {"photon_ring_samples": 8}
    moved = scene_of(Spacetime.schwarzschild(0.8))
    moments = [(hole, 0, 3), (moved, 3, 2), (hole, 5, 4)]
    alone, states = [], []
    whole = empty_state(names, RenderSettings(WIDTH, HEIGHT), WIDTH, HEIGHT)
    for scene, first, count in moments:
        channels = {name: np.zeros((HEIGHT, WIDTH, CHANNELS[name].components), np.float32) for name in names}
        wanted = RenderSettings(WIDTH, HEIGHT, first_sample=first, sample_count=count, **settings)
        states.append(empty_state(names, wanted, WIDTH, HEIGHT))
        scene.render_tile(0, 0, WIDTH, HEIGHT, wanted, channels, state=states[-1])
        alone.append(channels)
        resumed = {name: np.zeros_like(values) for name, values in channels.items()}
        scene.render_tile(0, 0, WIDTH, HEIGHT, replace(wanted, resume=first > 0), resumed, state=whole)
    counts = [channels["sample_count"] for channels in alone]
    assert (counts[0] / 3 != counts[1] / 2).mean() > 0.02
    np.testing.assert_array_equal(resumed["sample_count"], sum(counts))
    for name in ("combined", "normal"):
        expected = sum(channels[name] * n for channels, (_, _, n) in zip(alone, moments, strict=True)) / 9
        np.testing.assert_allclose(resumed[name], expected, rtol=1e-5, atol=1e-6)
    for order in ((0, 1, 2), (2, 0, 1)):
        merged = states[order[0]].copy()
        for other in order[1:]:
            merge_states(names, wanted, merged, states[other])
        for name, values in develop_state(names, wanted, merged).items():
            np.testing.assert_array_equal(values, resumed[name], err_msg=name)


def test_noise_threshold_looks_at_whole_samples(hole):
    """Pixels stop where others may: at the same number of samples times their own multiple."""
    multiple = render(hole, WIDTH, HEIGHT, 1, names=("sample_count",), photon_ring_samples=8)[0]["sample_count"]
    adaptive = {"noise_threshold": 0.02, "min_samples": 4, "photon_ring_samples": 8}
    counts = render(hole, WIDTH, HEIGHT, 100, names=("sample_count",), **adaptive)[0]["sample_count"]
    taken = counts / multiple
    assert np.isin(taken, [4 + 16 * k for k in range(6)] + [100]).all()
    assert len(np.unique(taken[multiple > 1])) > 2


def test_progress_counts_each_pixel_alike(hole):
    progress = Progress()
    render(hole, WIDTH, HEIGHT, 5, progress=progress, photon_ring_samples=8)
    assert progress.done == 5 * WIDTH * HEIGHT


def test_bad_numbers_are_named(hole):
    for bad in (0, 65):
        with pytest.raises(ValueError, match="photon_ring_samples must lie in"):
            render(hole, WIDTH, HEIGHT, 1, photon_ring_samples=bad)
    with pytest.raises(ValueError, match="below 2"):
        render(hole, WIDTH, HEIGHT, 1 << 26, photon_ring_samples=32)


def test_noise_falls_by_the_samples_that_are_taken(hole):
    """Where a pixel takes 8 samples for one, its variance over seeds is at most an eighth: never worse than independent
    samples would be. The ratio of the sums over n pixels of variances from k seeds is known to about
    sqrt(2 / (n (k - 1)) * (1 + excess)), which the spread over pixels tells."""
    seeds, names = 24, ("combined", "sample_count")
    pictures = {}
    for most in (1, 8):
        settings = {"names": names, "photon_ring_samples": most}
        rendered = [render(hole, WIDTH, HEIGHT, 2, seed=k, **settings)[0] for k in range(seeds)]
        pictures[most] = np.array([channels["combined"][..., 0] for channels in rendered], float)
    there = rendered[0]["sample_count"][..., 0] == 16
    plain, ring = (pictures[most][:, there].var(axis=0, ddof=1) for most in (1, 8))
    difference = ring - plain / 8
    z = difference.sum() / np.sqrt((difference**2).sum())
    assert there.sum() > 50 and z < 3 and plain.sum() > 0
