"""Joins that are not found are counted: as many as `connect` itself says of the same pairs, in a render too."""

import numpy as np
import pytest
from bentlight_native import RenderSettings, Spacetime, connect, connect_sky
from scenes import add, diffuse, look_at, new_scene, perspective, quad, render
from test_direct_light import add_lamps
from test_render_curved import placed

FAST, SLOW = (Spacetime.kerr(1, spin) for spin in (0.999, 0.3))
NEAR = (1.6, 0, 0)  # 1.2 horizons from the fast hole's center: rays from here are at times not found
TOLERANCE, LEAST_SHARE = 1e-5, 1e-4  # of a render's joins around a spinning hole


def found_by_connect(spacetime, places, ends, sky, images=2):
    """How many images there are, and how many of them are lost."""
    find = connect_sky if sky else connect
    counts = find(spacetime, places, ends, images, TOLERANCE, min_share=LEAST_SHARE)["counts"]
    return sum(counts.values()) - counts["none"], counts["coarse"] + counts["failed"]


@pytest.mark.parametrize("sky", [False, True])
@pytest.mark.parametrize("spacetime", [FAST, SLOW], ids=["fast", "slow"])
def test_joins_say_what_they_have_lost(spacetime, sky):
    """Of joins of one place near the horizon with others around it, and with the sky."""
    scene = new_scene()
    scene.set_spacetime(spacetime)
    scene.commit()
    rng = np.random.default_rng(1)
    way = rng.normal(size=(1500, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    places = (
        (way if sky else way * rng.uniform(2.2, 6, (1500, 1))),
        np.tile(NEAR if spacetime is FAST else (3, 0, 0), (1500, 1)),
    )
    joined = scene.join(places[1], places[0], sky=sky)
    wanted, lost = found_by_connect(spacetime, *places[::-1], sky)
    assert (joined["wanted"].sum(), joined["lost"].sum()) == (wanted, lost)
    assert (joined["count"].sum() == wanted - lost) and (spacetime is not FAST or lost > 20), (wanted, lost)


def lit_floor(spacetime, lamp):
    """A floor below a hole, lit by a lamp without size."""
    scene = new_scene()
    scene.set_spacetime(spacetime)
    add(scene, quad(2, 2), diffuse((0.8, 0.8, 0.8)), at=placed(3, 0, -2))
    add_lamps(scene, lamp)
    perspective(scene, look_at((9, 0, 5), (3, 0, -2)), half=0.1)
    scene.commit()
    return scene


def test_a_render_counts_the_joins_that_it_has_lost():
    """One vertex a sample: it looks for, and loses, what joins of those places do."""
    scene = lit_floor(FAST, NEAR)
    channels, statistics = render(scene, 48, 48, 1, names=("combined", "position", "fate"), max_bounces=0)
    places = channels["position"][channels["fate"][..., 0] == 4].astype(float)
    assert len(places) > 1000
    u = np.random.default_rng(2).random(len(places))
    joined = scene.join(places, np.tile(NEAR, (len(places), 1)), u=u)
    for counted, expected in [(statistics.joins, joined["wanted"]), (statistics.lost_joins, joined["lost"])]:
        assert abs(counted - expected.sum()) < 5 * np.sqrt(2 * len(places) * expected.var()) + 1, (
            counted,
            expected.sum(),
        )
    assert statistics.lost_joins > 20


def test_joins_that_cannot_be_lost_are_not_counted_as_lost():
    """Around a hole without spin every image is found, and in flat space there is nothing to look for."""
    for spacetime, wants in [(Spacetime.schwarzschild(1), True), (Spacetime.schwarzschild(0), False)]:
        _, statistics = render(lit_floor(spacetime, (2.5, 0, 0)), 16, 16, 4, names=("combined",))
        assert (statistics.joins > 0) == wants and statistics.lost_joins == 0


def test_light_subpaths_are_joined_and_counted():
    scene = lit_floor(Spacetime.schwarzschild(1), (2.5, 0, 0))
    light = np.zeros((16, 16, 3), np.int64)
    channels = {"combined": np.zeros((16, 16, 4), np.float32)}
    settings = [RenderSettings(16, 16, sample_count=4, integrator=kind) for kind in ("PATH", "BIDIRECTIONAL")]
    path, both = (scene.render_tile(0, 0, 16, 16, s, channels, light=light) for s in settings)
    assert both.joins > path.joins > 0
