"""Rays through veils (Scene.intersect with `veils`): closed forms in flat space, golden crossings around holes."""

import math

import numpy as np
import pytest
from bentlight_native import FATES, Spacetime
from golden import sine_cosine_deg
from meshes import annulus
from rays import oblate_basis, unit
from scenes import add, diffuse, emission, new_scene, quad, transparent
from test_disk import CROSSINGS, OUTER, RAYS, disk_program

HIT, ESCAPED, CAPTURED = (FATES.index(name) for name in ("hit", "escaped", "captured"))
COLORS = np.array([[1.0, 2.0, 0.5], [0.3, 0.1, 4.0], [2.0, 0.0, 1.0]])
TINTS = np.array([[0.5, 0.8, 1.0], [1.0, 0.25, 0.1], [0.9, 0.6, 0.3]])


def at_height(z):
    matrix = np.eye(4)
    matrix[2, 3] = z
    return matrix


def stack(scene, *heights, **instance):
    """Colored veils one above the other; returns flags for all instances, the last of which is a floor at z = 0."""
    for height, color, tint in zip(heights, COLORS, TINTS, strict=False):
        add(scene, quad(), emission(tuple(color)), transparent(tuple(tint)), at=at_height(height), **instance)
    add(scene, quad(), diffuse((0.5, 0.5, 0.5)))
    scene.commit()
    return np.arange(len(heights) + 1) < len(heights)


def down(scene, veils, x=(0.1,), start=4.0, **options):
    origins = np.array([[each, 0.2, start] for each in x])
    return scene.intersect(origins, np.tile([0.0, 0, -1], (len(x), 1)), 1e-6, veils=veils, **options)


def test_each_is_dimmed_by_those_before_it():
    """In the order of the ray, whatever that of the instances; the hit is that of the floor."""
    scene = new_scene()
    hits = down(scene, stack(scene, 1.0, 3.0, 2.0), x=(0.1, 5.0))
    first, second, third = (1, 2, 0)
    expected = COLORS[first] + TINTS[first] * (COLORS[second] + TINTS[second] * COLORS[third])
    np.testing.assert_allclose(hits["glow"], [expected, (0, 0, 0)], rtol=1e-12)
    np.testing.assert_allclose(hits["transmission"], [TINTS.prod(axis=0), (1, 1, 1)], rtol=1e-12)
    np.testing.assert_array_equal(hits["layers"], [3, 0])
    np.testing.assert_array_equal(hits["fate"], [HIT, ESCAPED])
    assert hits["instance"][0] == 3 and hits["length"][0] == pytest.approx(4, abs=2e-6)
    np.testing.assert_allclose(hits["position"][0], (0.1, 0.2, 0), atol=1e-6)


def test_only_what_is_in_the_rays_range_counts():
    """Of veils and of what is behind them; hidden ones are not there, holdouts are black, meshes hide."""
    scene = new_scene()
    veils = stack(scene, 1.0, 3.0, 2.0)
    np.testing.assert_allclose(down(scene, veils, length_min=1.5)["glow"][0], COLORS[2] + TINTS[2] * COLORS[0])
    short = down(scene, veils, length_max=2.5)
    np.testing.assert_allclose(short["glow"][0], COLORS[1] + TINTS[1] * COLORS[2])
    assert short["fate"][0] == ESCAPED
    hidden = new_scene()
    assert not down(hidden, stack(hidden, 1.0, visibility=14), visibility=1)["layers"].any()
    held_out = new_scene()
    black = down(held_out, stack(held_out, 1.0, visibility=15 | 16))
    assert not black["glow"].any() and not black["transmission"].any() and black["layers"][0] == 1
    covered = new_scene()
    add(covered, quad(), diffuse((0.5, 0.5, 0.5)), at=at_height(2.0))
    seen = down(covered, np.append(False, stack(covered, 1.0)))
    assert not seen["layers"].any() and seen["instance"][0] == 0


def test_an_opaque_one_is_the_hit():
    scene = new_scene()
    add(scene, quad(), emission((2, 3, 4)), at=at_height(1.0))
    hits = down(scene, np.append(True, stack(scene)))
    np.testing.assert_array_equal(hits["glow"], [(2, 3, 4)])
    assert not hits["transmission"].any() and hits["instance"][0] == 0 and hits["length"][0] == pytest.approx(3)


def test_too_many_are_unresolved():
    scene = new_scene()
    for i in range(80):
        add(scene, quad(), transparent((1, 1, 1)), at=at_height(1 + i / 80))
    scene.commit()
    flags = np.ones(80, bool)
    assert FATES[down(scene, flags)["fate"][0]] == "unresolved"
    some = down(scene, flags, start=1.5)
    assert some["fate"][0] == ESCAPED and not some["layers"].any()


def test_bad_flags_are_refused():
    scene = new_scene()
    stack(scene, 1.0)
    for flags in (np.ones(3, bool), np.ones((2, 1), bool), np.ones(0, bool)):
        with pytest.raises(ValueError, match="veils"):
            down(scene, flags)


def golden_rays(spin):
    """Starts and directions of the golden rays of this spin, (n, 3) each, and their crossings, by ray and number."""
    chosen = [[*row["kerr_row:crossing"].split(":"), row] for row in CROSSINGS if float(row["a"]) == spin]
    names = sorted({name for name, _, _ in chosen})
    starts, directions = [], []
    for name in names:
        ray = RAYS[name]
        position, *basis = oblate_basis(spin, float(ray["r_obs"]), *sine_cosine_deg(float(ray["theta_obs_deg"])))
        look = unit(np.array([float(ray[f"n_{k}"]) for k in ("r", "theta", "phi")]))
        starts.append(position)
        directions.append(sum(part * axis for part, axis in zip(look, basis, strict=True)))
    return np.array(starts), np.array(directions), {(names.index(name), int(k)): row for name, k, row in chosen}


@pytest.mark.parametrize("spin", sorted({float(row["a"]) for row in CROSSINGS}))
def test_golden_crossings(spin):
    """Radius, azimuth and g of every crossing, by a disk that shines with them on that crossing alone. Rays end as
    without the disk."""
    starts, directions, crossings = golden_rays(spin)
    scene = new_scene()
    scene.set_spacetime(Spacetime.kerr(1, spin))
    material = scene.add_material(disk_program(spin))
    ring = scene.add_mesh(*annulus(1.02, 1.1 * OUTER, 12, 32))
    scene.add_instance(ring, np.eye(4), materials=np.array([material], np.int32))
    found = {}
    for order in {number for _, number in crossings}:
        scene.update_material(material, disk_program(spin, order))
        scene.commit()
        options = {"angular_tolerance": 1e-9, "length_min": 1e-6}  # some start in the disk
        found[order] = scene.intersect(starts, directions, 1e-9, veils=np.ones(1, bool), **options)
    for (ray, order), row in crossings.items():
        radius, azimuth, shift = found[order]["glow"][ray]
        assert radius == pytest.approx(float(row["r_em"]), rel=1e-6), row["id"]
        assert abs(math.remainder(azimuth - float(row["phi_em"]), 2 * math.pi)) < 1e-6, row["id"]
        assert shift == pytest.approx(float(row["g=nu_obs/nu_em"]), rel=1e-6), row["id"]
        assert found[order]["layers"][ray] == 1
    scene.clear_instances()
    scene.commit()
    alone = scene.intersect(starts, directions, 1e-9, angular_tolerance=1e-9)
    through = found[0]
    np.testing.assert_array_equal(alone["fate"], through["fate"])
    assert {ESCAPED, CAPTURED} >= set(alone["fate"])
    away = alone["fate"] == ESCAPED
    np.testing.assert_allclose(through["direction"][away], alone["direction"][away], atol=1e-5)  # near-critical ones
    np.testing.assert_allclose(through["swept"][away], alone["swept"][away], atol=1e-5)
