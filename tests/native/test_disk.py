"""The accretion disk's physics: orbits, fluxes and shifts of frequency against golden data, closed forms and
quadrature; and rays that cross it, through the renderer."""

import numpy as np
import pytest
from bentlight_native import ProgramBuilder, Spacetime, disk_drawn_radius, disk_flux, disk_isco, disk_orbit_frequency
from golden import numbers, rows, sine_cosine_deg
from meshes import annulus
from rays import oblate_basis, unit
from scenes import add, glossy, look_at, new_scene, perspective, quad, render

RADII = rows("kerr_radii.csv")
SHIFTS = rows("redshift.csv")
RAYS = {row["id"]: row for row in rows("kerr_geodesics.csv")}
SPINS = (0.0, 0.3, 0.9, 0.998)


def disk_program(spin, order=None, chart="OBLATE"):
    """Shines with radius, azimuth and g as its colors, where it is met after `order` crossings (None: always), and lets
    all light through."""
    builder = ProgramBuilder()
    constant = builder.constant
    operands = (constant(1.0), constant(spin))
    radius, azimuth, doppler, gravitational, crossings = builder.emit("disk", *operands, immediates=(chart,))
    weight = constant(1.0)
    if order is not None:
        (weight,) = builder.emit("math", crossings, constant(order), constant(0.1), immediates=("COMPARE",))
    (ratio,) = builder.emit("multiply", doppler, gravitational)
    builder.emit("emission", weight, builder.emit("combine", radius, azimuth, ratio)[0], constant(1.0))
    builder.emit("transparent", constant(1.0), constant(1.0))
    return builder.build()


# ---- Orbits and flux ----


def test_last_stable_orbits():
    expected = numbers(RADII, "r_isco_prograde")
    found = np.array([disk_isco(spin) for spin in numbers(RADII, "a")])
    # The cubic's root at a = 1 is threefold: rounding of 1 - a counts by its cube root.
    assert np.abs(found / expected - 1).max() < 1e-12
    assert disk_isco(0.0) == pytest.approx(6, rel=1e-15)
    assert disk_isco(-0.9) == disk_isco(0.9)


def orbit(r, a):
    """Energy, angular momentum and angular frequency of circular orbits (Bardeen, Press & Teukolsky 1972), a second
    time; r may be complex."""
    root = np.sqrt(r)
    binding = r**0.75 * np.sqrt(r**1.5 - 3 * root + 2 * a)
    return (r**1.5 - 2 * root + a) / binding, (r**2 - 2 * a * root + a**2) / binding, 1 / (r**1.5 + a)


def slope(function, r):
    """Its derivative by a complex step, exact to rounding."""
    return np.imag(function(r + 1e-30j)) / 1e-30


@pytest.mark.parametrize("spin", SPINS)
@pytest.mark.parametrize("factor", [1.05, 1.6, 4.0, 50.0])
def test_flux_is_the_integral_of_conservation_laws(spin, factor):
    """Page & Thorne 1974, eqs. 12 and 15: energy and angular momentum that matter loses are radiated."""
    inner = disk_isco(spin)
    radius = factor * inner
    nodes, weights = np.polynomial.legendre.leggauss(60)
    middle, half = (np.log(radius) + np.log(inner)) / 2, (np.log(radius) - np.log(inner)) / 2
    r = np.exp(middle + half * nodes)
    energy, momentum, frequency = orbit(r, spin)
    lost = (weights * half * r * (energy - frequency * momentum) * slope(lambda x: orbit(x, spin)[1], r)).sum()
    energy, momentum, frequency = orbit(radius, spin)
    falling = -slope(lambda x: orbit(x, spin)[2], radius)
    expected = falling / (energy - frequency * momentum) ** 2 * lost / radius
    assert disk_flux(radius, spin) == pytest.approx(expected, rel=1e-9)
    assert disk_flux(radius, -spin) == disk_flux(radius, spin)


def test_flux_without_spin():
    """The closed form of that case; and nothing within the last stable orbit."""
    r = 13.0
    x, roots = np.sqrt(r), (np.sqrt(6), np.sqrt(3))
    logarithm = np.log((x + roots[1]) * (roots[0] - roots[1]) / ((x - roots[1]) * (roots[0] + roots[1])))
    expected = 1.5 / ((r - 3) * r**2.5) * (x - roots[0] + np.sqrt(3) / 2 * logarithm)
    assert disk_flux(r, 0.0) == pytest.approx(expected, rel=1e-12)
    assert disk_flux(r, 1e-9) == pytest.approx(expected, rel=1e-8)
    assert disk_flux(5.9, 0.0) == 0


def test_drawn_radii_and_frequency():
    assert disk_drawn_radius(10.0, 0.0, True) == pytest.approx((9 + np.sqrt(80)) / 2, rel=1e-15)
    assert disk_drawn_radius(10.0, 0.9, False) == pytest.approx(np.hypot(10, 0.9), rel=1e-15)
    assert disk_orbit_frequency(4.0, 0.5) == pytest.approx(1 / 8.5, rel=1e-15)


@pytest.mark.parametrize("arguments", [(1.9, 0.0), (0.0, 0.0), (5.0, 1.0), (np.nan, 0.0), (5.0, np.nan), (np.inf, 0.0)])
def test_bad_places_are_refused(arguments):
    with pytest.raises(ValueError):
        disk_flux(*arguments)


# ---- Frequency ----


def shade_disk(spin, radius, k_r, k_phi, chart="OBLATE"):
    """What a distant observer sees of the disk's place at azimuth 0, by a unit direction towards him: (3,)."""
    scene = new_scene()
    material = scene.add_material(disk_program(spin, chart=chart))
    k_theta = np.sqrt(max(0.0, 1 - k_r**2 - k_phi**2))
    drawn = disk_drawn_radius(radius, spin, chart == "ISOTROPIC")
    return scene.shade(material, position=(drawn, 0, 0), wo=(k_r, k_phi, k_theta))["emission"][0]


@pytest.mark.parametrize("row", [r for r in SHIFTS if r["kind"] == "observer_at_infinity"], ids=lambda row: row["id"])
def test_shift_to_infinity(row):
    """Golden g for given constants of the light's motion, E = 1: its direction in the local frame follows from L."""
    spin, r, L = (float(row[name]) for name in ("a", "r_em", "L"))
    area = (r**2 + spin**2) ** 2 - spin**2 * (r**2 - 2 * r + spin**2)
    local_energy = (1 - 2 * spin * r / area * L) / (r * np.sqrt((r**2 - 2 * r + spin**2) / area))
    k_phi = L * r / np.sqrt(area) / local_energy
    seen = shade_disk(spin, r, 0.0, k_phi)
    assert seen == pytest.approx([r, 0, float(row["g=nu_obs/nu_em"])], rel=1e-12, abs=1e-12)
    if spin != 0:  # in the mirror
        assert shade_disk(-spin, r, 0.0, -k_phi)[2] == seen[2]
    else:
        isotropic = shade_disk(spin, r, 0.0, k_phi, "ISOTROPIC")
        assert isotropic == pytest.approx(seen, rel=1e-12, abs=1e-12)


def test_legs_multiply():
    """A camera on the axis sees the disk in a mirror behind it: the two legs' factors make that between disk and
    camera, as without the mirror. g of light without angular momentum is sqrt(1 - 3/r) over the camera's lapse."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(1, "areal"))
    material = scene.add_material(disk_program(0.0))
    ring = scene.add_mesh(*annulus(6, 20, 12, 64))
    scene.add_instance(ring, np.eye(4), materials=np.array([material], np.int32))
    above = np.eye(4)
    above[2, 3] = 12
    add(scene, quad(40, 40), glossy((1, 1, 1), 0.0), at=above)
    perspective(scene, look_at((0, 0, 8), (0, 0, 12), (0, 1, 0)), half=1.5)
    scene.commit()
    settings = {"max_bounces": 1, "glossy_bounces": 1, "transparent_bounces": 9}
    seen = render(scene, 32, 32, 1, names=("combined",), **settings)[0]["combined"].astype(float)
    r, g = seen[..., 0], seen[..., 2]
    once = (r > 6) & (r < 20) & (g < np.sqrt(1 - 3 / 20) / np.sqrt(1 - 2 / 8) + 1e-6)  # not the sum of two crossings
    assert once.sum() > 50
    assert np.abs(g[once] / np.sqrt((1 - 3 / r[once]) / (1 - 2 / 8)) - 1).max() < 1e-5


def test_falling_matter():
    """Within the last stable orbit matter keeps its energy and angular momentum: light straight outwards, which has
    none, is shifted by 1 / (u^t - u^r dt/dr). Schwarzschild, in Boyer-Lindquist components."""
    r = 4.0
    energy, momentum = 2 * np.sqrt(2) / 3, 2 * np.sqrt(3)
    lapse2 = 1 - 2 / r
    u_r = -np.sqrt(energy**2 - lapse2 * (1 + momentum**2 / r**2))
    expected = 1 / (energy / lapse2 - u_r / lapse2)
    assert shade_disk(0.0, r, 1.0, 0.0)[2] == pytest.approx(expected, rel=1e-12)
    just_out, just_in = (shade_disk(0.9, disk_isco(0.9) * factor, 0.3, 0.4)[2] for factor in (1 + 1e-6, 1 - 1e-6))
    assert just_in == pytest.approx(just_out, rel=1e-4)


# ---- Rays ----

CONDITION_MAX, OUTER = 1e3, 200.0


def is_clear(row):
    """Whether a golden shift belongs to a ray that does not multiply errors, and to a place of the disk."""
    ray = RAYS.get(row["kerr_row:crossing"].split(":")[0])
    return ray is not None and float(ray["cond_dir"] or np.inf) < CONDITION_MAX and float(row["r_em"]) < OUTER


CROSSINGS = [row for row in SHIFTS if is_clear(row)]


@pytest.mark.parametrize("spin", sorted({float(row["a"]) for row in CROSSINGS}))
def test_crossings_through_the_renderer(spin):
    """Radius, azimuth and g of the golden crossings, picked by their number on the ray, as the camera sees them. Rays
    that are nearly critical multiply rounding and are left out."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.kerr(1, spin))
    material = scene.add_material(disk_program(spin))
    ring = scene.add_mesh(*annulus(1.02, 1.1 * OUTER, 12, 32))
    scene.add_instance(ring, np.eye(4), materials=np.array([material], np.int32), visibility=1)
    for row in (row for row in CROSSINGS if float(row["a"]) == spin):
        name, number = row["kerr_row:crossing"].split(":")
        ray = RAYS[name]
        position, *basis = oblate_basis(spin, float(ray["r_obs"]), *sine_cosine_deg(float(ray["theta_obs_deg"])))
        look = unit(np.array([float(ray[f"n_{k}"]) for k in ("r", "theta", "phi")]))
        direction = sum(part * axis for part, axis in zip(look, basis, strict=True))
        scene.update_material(material, disk_program(spin, int(number)))
        up = (0, 0, 1) if abs(direction[2]) < 0.9 else (1, 0, 0)
        perspective(scene, look_at(position, position + direction, up), half=5e-10, clip_start=1e-6)
        scene.commit()
        settings = {"tolerance": 1e-9, "filter": "BOX", "transparent_bounces": 50, "max_bounces": 0}
        seen = render(scene, 1, 1, 1, names=("combined",), **settings)[0]["combined"][0, 0].astype(float)
        assert seen[0] == pytest.approx(float(row["r_em"]), rel=1e-6), row["id"]
        turned = (seen[1] - float(row["phi_em"]) + np.pi) % (2 * np.pi) - np.pi
        assert abs(turned) < 1e-6, row["id"]
        assert seen[2] == pytest.approx(float(row["g=nu_obs/nu_em"]), rel=1e-6), row["id"]


def radius_after(b, swept, start, steps=400):
    """1 / u after an angle on the orbit u'' = 3 u^2 - u with impact parameter b that comes in from radius `start`: the
    classical Runge-Kutta method, which shares nothing with the core."""
    u, v, h = 1 / start, np.sqrt(1 / b**2 - (1 - 2 / start) / start**2), swept / steps

    def force(u):
        return 3 * u * u - u

    for _ in range(steps):
        if not 0 < u < 1:  # escaped, or fallen in
            break
        u2, v2 = u + h / 2 * v, v + h / 2 * force(u)
        u3, v3 = u + h / 2 * v2, v + h / 2 * force(u2)
        u4, v4 = u + h * v3, v + h * force(u3)
        u, v = (
            u + h / 6 * (v + 2 * v2 + 2 * v3 + v4),
            v + h / 6 * (force(u) + 2 * force(u2) + 2 * force(u3) + force(u4)),
        )
    return 1 / u


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("alpha_deg", [30.0, 100.0, 160.0])
def test_isoradial_curves(alpha_deg, order):
    """Luminet 1979: the image of the circle r = 10 seen at an inclination of 80 degrees, direct and secondary. At polar
    angle alpha (from the near side of the image) light sweeps gamma, or 2 pi - gamma, with cos gamma = cos alpha /
    sqrt(cos^2 alpha + cot^2 i); the impact parameter of r = 10 is found by bisection."""
    inclination, distance, alpha = np.radians(80), 1000.0, np.radians(alpha_deg)
    gamma = np.arccos(np.cos(alpha) / np.hypot(np.cos(alpha), 1 / np.tan(inclination)))
    swept = gamma if order == 0 else 2 * np.pi - gamma
    low, high = 1.0, 30.0  # the radius grows with b between
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if 0 < radius_after(middle, swept, distance) < 10 else (low, middle)
    sine = low * np.sqrt(1 - 2 / distance) / distance
    outward = np.array([0, -np.sin(inclination), np.cos(inclination)])
    near = np.array([0, -np.cos(inclination), -np.sin(inclination)])  # on the sky, down
    side = np.array([1.0, 0, 0])
    away = near * np.cos(alpha) + side * np.sin(alpha)
    direction = -np.sqrt(1 - sine**2) * outward + sine * (away if order == 0 else -away)
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(1, "areal"))
    material = scene.add_material(disk_program(0.0, order))
    ring = scene.add_mesh(*annulus(3, 40, 12, 32))
    scene.add_instance(ring, np.eye(4), materials=np.array([material], np.int32), visibility=1)
    eye = distance * outward
    perspective(scene, look_at(eye, eye + direction), half=5e-10)
    scene.commit()
    settings = {"tolerance": 1e-9, "filter": "BOX", "transparent_bounces": 50, "max_bounces": 0}
    seen = render(scene, 1, 1, 1, names=("combined",), **settings)[0]["combined"][0, 0]
    assert seen[0] == pytest.approx(10, rel=1e-5)
