"""Light transport around holes and through wormholes, against closed forms."""

import meshes
import numpy as np
import pytest
from bentlight_native import Spacetime, lapse
from bentlight_native.geometry import CAPTURED
from scenes import add, diffuse, emission, look_at, new_scene, perspective, quad, render
from test_render_light import z_score

GRAY = (0.5, 0.5, 0.5)
LONG = {"max_bounces": 100, "diffuse_bounces": 100, "roulette_start": 100, "light_sampling": "SCATTERING"}


def areal_radius(isotropic, mass):
    return isotropic * (1 + mass / (2 * isotropic)) ** 2


def shadow_sine(r, mass):
    """sin of the angle of the shadow's edge to the center, for a static observer at areal radius r (Synge 1966)."""
    return 3 * np.sqrt(3) * mass * np.sqrt(1 - 2 * mass / r) / r


def placed(x, y, z, scale=1.0):
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = x, y, z
    return matrix


@pytest.mark.parametrize("chart", ["isotropic", "areal"])
@pytest.mark.parametrize("distance", [3.2, 10.0, 100.0])
def test_shadow_of_a_hole(chart, distance):
    """Under an even sky everything outside the shadow has the sky's radiance exactly; the shadow's area gives its
    radius. The camera looks at the center; a circle of angle psi is drawn with radius tan(psi)."""
    mass, size = 0.5, 96
    r = distance if chart == "areal" else areal_radius(distance, mass)
    edge = np.arcsin(shadow_sine(r, mass))
    half = 1.25 * np.tan(edge)
    scene = new_scene((1, 1, 1))
    scene.set_spacetime(Spacetime.schwarzschild(mass, chart))
    perspective(scene, look_at((0, -distance, 0), (0, 0, 0)), half=half)
    scene.commit()
    channels, statistics = render(scene, size, size, 16, filter="BOX", tolerance=1e-6)
    sky = channels["combined"][..., 0]
    assert sky.max() == 1 and sky.min() == 0
    assert ((channels["fate"] == 1) | (channels["fate"] == 2) | (channels["fate"] == 0)).all()
    radius = np.sqrt((1 - sky).sum() / np.pi) * 2 * half / size
    pixel = 2 * half / size
    assert abs(radius - np.tan(edge)) < 0.02 * pixel
    assert statistics.unresolved < 1e-3 * statistics.rays
    ys, xs = np.mgrid[:size, :size] + 0.5
    away = np.abs(np.hypot(xs - size / 2, ys - size / 2) * pixel - np.tan(edge)) > pixel
    inside = np.hypot(xs - size / 2, ys - size / 2) * pixel < np.tan(edge)
    assert (sky[away & inside] == 0).all() and (sky[away & ~inside] == 1).all()


def test_channels_of_a_hole():
    """Captured rays are black and opaque, also on a transparent film; winding grows towards the edge."""
    scene = new_scene((1, 1, 1))
    scene.set_spacetime(Spacetime.schwarzschild(0.5))
    perspective(scene, look_at((0, -10, 0), (0, 0, 0)), half=0.5)
    scene.commit()
    channels, _ = render(scene, 64, 64, 4, film_transparent=True)
    captured, sky = channels["fate"] == 2, channels["fate"] == 1
    assert (channels["combined"][0, 0] == 0).all()
    assert (channels["combined"][32, 32] == (0, 0, 0, 1)).all()
    assert (channels["environment"][0, 0] == 1).all() and (channels["environment"][32, 32] == 0).all()
    assert (channels["depth"][captured | sky] == np.float32(1e10)).all()
    row = channels["winding"][32, :32, 0]
    outside = row[channels["fate"][32, :32, 0] == 1]
    assert 0.9 < outside[0] < 1.2 and (np.diff(outside[:-1]) > 0).all() and outside[-2] > 1.2


def test_furnace_around_a_hole():
    """A closed wall on a sphere around a hole: light is lost only to the hole, which takes sin^2(psi) of a diffuse
    wall's light, psi the angle of its shadow. So L = e / (1 - rho (1 - sin^2 psi)); all wall is at one radius, and no
    frequency shifts. Seen from the wall's inside, it has this radiance everywhere outside the shadow."""
    mass, radius, rho, e = 0.5, 3.0, 0.7, 0.3
    loss = shadow_sine(areal_radius(radius, mass), mass) ** 2
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(mass))
    add(scene, meshes.sphere(radius, segments=96, rings=48), diffuse((rho,) * 3), emission((e,) * 3))
    perspective(scene, look_at((2.5, 0, 0), (2.9, 0.6, 0.1)), half=0.3)
    scene.commit()
    channels, statistics = render(scene, 16, 16, 256, max_bounces=60, diffuse_bounces=60, roulette_start=8)
    assert (channels["fate"] == 4).all()
    assert abs(z_score(channels["combined"][..., 0], e / (1 - rho * (1 - loss)))) < 4
    assert statistics.unresolved < 1e-4 * statistics.rays


@pytest.mark.parametrize(
    "spacetime", [Spacetime.schwarzschild(0.5, "areal"), Spacetime.kerr(0.5, 0.45)], ids=["areal", "oblate"]
)
def test_furnace_in_other_charts(spacetime):
    """A furnace at one temperature is even, in every chart: walls that emit 1 - rho and reflect rho, and a hole that
    takes light. The exact bound: between the emission and 1, and every path's sum geometric."""
    scene = new_scene()
    scene.set_spacetime(spacetime)
    add(scene, meshes.sphere(4.0), diffuse(GRAY), emission(GRAY))
    perspective(scene, look_at((3, 0, 0), (3.9, 0.6, 0.1)), half=0.3)
    scene.commit()
    channels, statistics = render(scene, samples=16, **LONG)
    values = channels["combined"][..., 0]
    assert (channels["fate"] == 4).all() and (values >= 0.5).all() and (values <= 1).all()
    one = render(scene, samples=1, **LONG)[0]["combined"][..., 0].astype(float)
    assert np.isin(one, 1 - 2.0 ** -np.arange(1, 60)).all()  # each path is 1 - 2^-k: lost into the hole after k walls
    assert statistics.unresolved < 1e-3 * statistics.rays


@pytest.mark.parametrize("spin", [0.0, 0.9])
def test_normals_are_local_in_charts_that_stretch(spin):
    """In areal and oblate charts a tilted wall's normal n is a covector: on the equator its local components are
    e_r = sqrt(Delta / Sigma) d/dr with dx/dr = r / x, e_phi = d/dphi / sqrt(g_phiphi), e_theta = d/dtheta / sqrt(Sigma)
    with dz/dtheta = -r, where x = sqrt(r^2 + a^2) is the drawn radius."""
    mass, r, tilt = 1.0, 3.0, 0.6
    x = np.sqrt(r**2 + spin**2)
    wall = np.eye(4)
    wall[:3, 2], wall[:3, 0] = (np.cos(tilt), 0, np.sin(tilt)), (0, 1, 0)
    wall[:3, 1] = np.cross(wall[:3, 2], wall[:3, 0])
    wall[:3, 3] = x, 0, 0
    scene = new_scene((1, 1, 1))
    scene.set_spacetime(Spacetime.kerr(mass, spin) if spin else Spacetime.schwarzschild(mass, "areal"))
    add(scene, quad(0.05, 0.05), diffuse(GRAY), at=wall)
    perspective(scene, look_at((x + 0.01, 0, 0), (x, 0, 0)), half=0.02)
    scene.commit()
    channels, _ = render(scene, 8, 8, 1)
    assert (channels["fate"] == 4).all()
    delta, sigma = r**2 - 2 * mass * r + spin**2, r**2
    g_phi = ((r**2 + spin**2) ** 2 - spin**2 * delta) / sigma
    phi = np.arctan2(channels["position"][..., 1], channels["position"][..., 0])
    c, s = np.cos(phi), np.sin(phi)
    radial, tangential = c * wall[0, 2], -s * wall[0, 2]
    local_r, local_phi = np.sqrt(delta / sigma) * r / x * radial, x / np.sqrt(g_phi) * tangential
    local = np.stack([c * local_r - s * local_phi, s * local_r + c * local_phi, 0 * phi + wall[2, 2]], -1)
    local /= np.linalg.norm(local, axis=-1, keepdims=True)
    assert np.abs(channels["normal"] - local).max() < 2e-3  # the wall spans 2e-3 in r and z as the camera sees it
    assert np.abs(local[0, 0] - wall[:3, 2]).max() > 0.1  # and the flat normal is far from it


def test_wormhole_joins_two_mouths():
    """One closed white furnace around both mouths of a wormhole: no light is lost, and 1 is exact everywhere."""
    scene = new_scene()
    a, b = placed(-3, 0, 0), placed(3, 0.5, 0)
    scene.set_spacetime_objects([(Spacetime.ellis(0.5), a, 2.0, 1), (Spacetime.ellis(0.5), b, 2.0, 0)])
    add(scene, meshes.sphere(8.0), diffuse(GRAY), emission(GRAY))
    perspective(scene, look_at((-3, -4, 0), (-3, 0, 0)), half=0.6)
    scene.commit()
    settings = {"light_sampling": "SCATTERING", "portal_sampling": False}  # without weights other than 1
    channels, statistics = render(scene, 24, 24, 4, max_bounces=60, diffuse_bounces=60, roulette_start=60, **settings)
    assert (channels["combined"] == 1).all() and statistics.unresolved == 0


def test_two_holes_by_two_spheres():
    """Two holes with spheres of influence: seen from far above each shadow has the size it has alone, but for the thin
    image of the other hole at its rim, whose rays cross three borders, not one. A lattice counts a disk of radius r to
    about r^(2/3) points, here a twentieth of its spacing in r."""
    mass, distance, size = 0.2, 10.0, 480
    scene = new_scene((1, 1, 1))
    hole = Spacetime.schwarzschild(mass)
    scene.set_spacetime_objects([(hole, placed(-3, 0, 0), 2.9, -1), (hole, placed(3, 0, 0), 2.9, -1)])
    scene.set_camera("ORTHOGRAPHIC", look_at((0, 0, distance), (0, 0, 0), up=(0, 1, 0)), (-6, 6, -6, 6))
    scene.commit()
    line = (np.arange(size) + 0.5) / size
    rays = scene.camera_rays(np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2))
    hits = scene.intersect(rays.origins, rays.directions)
    dark = ((hits["fate"] == CAPTURED) & (hits["borders"] == 1)).reshape(size, size)
    for half in (dark[:, : size // 2], dark[:, size // 2 :]):
        radius = np.sqrt(half.sum() / np.pi) * 12 / size
        # The ray meets the sphere at chart radius 2.9 with the flat impact parameter x: sin = x / 2.9 there.
        assert radius == pytest.approx(2.9 * shadow_sine(areal_radius(2.9, mass), mass), abs=0.06 * 12 / size)


def test_camera_inside_a_horizon_is_an_error():
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(1.0))
    perspective(scene, look_at((0.3, 0, 0), (1, 0, 0)))
    scene.commit()
    with pytest.raises(ValueError, match="inside the horizon"):
        render(scene)


def test_orthographic_camera_across_a_hole():
    """Its rays that would start inside the horizon are black; the others are traced."""
    scene = new_scene((1, 1, 1))
    scene.set_spacetime(Spacetime.schwarzschild(1.0))
    scene.set_camera("ORTHOGRAPHIC", placed(2, 0, 0), (-3, 3, -3, 3))
    scene.commit()
    channels, _ = render(scene, 24, 24, 1)
    assert (channels["combined"][12, 4, :3] == 0).all() and (channels["combined"][12, -1, :3] == 1).all()
    assert (channels["combined"][..., 3] == 1).all()


def test_weak_field_tends_to_flat_space():
    """Depth and position with a hole of vanishing mass are those of flat space."""
    results = []
    for spacetime in (Spacetime.minkowski(), Spacetime.schwarzschild(1e-12)):
        scene = new_scene((1, 1, 1))
        scene.set_spacetime(spacetime)
        add(scene, meshes.box((-1, 1, -1), (1, 2, 1)), diffuse(GRAY))
        perspective(scene, look_at((0.2, -3, 0.4), (0, 0, 0)))
        scene.commit()
        results.append(render(scene, 32, 32, 4)[0])
    flat, bent = results
    for name in ("depth", "position", "normal"):
        assert np.abs(flat[name] - bent[name]).max() <= 1e-5 * np.abs(flat[name]).max(), name
    assert np.abs(flat["combined"].mean() - bent["combined"].mean()) < 1e-3


def test_tiles_and_threads_do_not_change_a_bit_in_curved_space():
    scene = new_scene((0.3, 0.4, 0.5))
    scene.set_spacetime(Spacetime.kerr(0.3, 0.25))
    add(scene, meshes.sphere(6.0, segments=24, rings=12), diffuse(GRAY), emission((0.1, 0.1, 0.1)))
    add(scene, meshes.box((0.6, -0.3, -0.3), (1, 0.3, 0.3)), diffuse((0.2, 0.6, 0.3)))
    perspective(scene, look_at((0, -4, 0.5), (0, 0, 0)))
    scene.commit()
    whole, _ = render(scene, 30, 20, 3)
    for x, y, w, h in [(0, 0, 7, 20), (7, 0, 23, 3), (7, 3, 11, 17), (18, 3, 12, 17)]:
        part, _ = render(scene, 30, 20, 3, tile=(x, y, w, h))
        for name in whole:
            assert np.array_equal(part[name], whole[name][y : y + h, x : x + w]), name


def test_lapse_is_not_applied_to_radiance():
    """Documented: radiance is not shifted in frequency here; a lamp deep in the field looks as bright as it is."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(0.5))
    add(scene, meshes.sphere(0.5, segments=32, rings=16), emission((1, 1, 1)))
    perspective(scene, look_at((0, -8, 0), (0, 0, 0)), half=0.05)
    scene.commit()
    assert lapse(Spacetime.schwarzschild(0.5), [0.5, 0, 0]) < 0.5
    channels, _ = render(scene, samples=1)
    assert (channels["combined"] == 1).all()
