"""The named hard cases: rays on which geodesic codes fail. Tests and the speed benchmark share them."""

from dataclasses import dataclass

import numpy as np
from bentlight_native import Spacetime
from rays import isotropic_radius, kerr_functions, oblate_basis, planar_rays, rays_from_constants, unit

CRITICAL = 3 * np.sqrt(3)
DELTAS = np.array([1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
DELTAS = np.concatenate([DELTAS, -DELTAS])
EXTREME_SPINS = (0.5, 0.9, 0.998, 0.9999, 0.999999)


@dataclass(frozen=True)
class HardCase:
    """Rays of one kind; `fates` says what is known about them (0: not decided by the input), None: nothing."""

    name: str
    spacetime: Spacetime
    origins: np.ndarray
    directions: np.ndarray
    fates: np.ndarray | None = None


def sphere_of_directions(n=64, seed=1):
    return unit(np.random.default_rng(seed).normal(size=(n, 3)))


def everywhere(origin, n=64):
    """One origin, many directions, among them the six along the axes."""
    directions = np.concatenate([np.eye(3), -np.eye(3), sphere_of_directions(n)])
    return np.tile(np.asarray(origin, float), (len(directions), 1)), directions


def near_critical_schwarzschild(scale, chart):
    r = 50.0
    sine = CRITICAL * (1 + DELTAS) * np.sqrt(1 - 2 / r) / r
    radius = scale * (isotropic_radius(r) if chart == "isotropic" else r)
    rays = planar_rays(radius, -np.sqrt(1 - sine**2), sine)
    return HardCase(
        f"critical, Schwarzschild {chart}, scale {scale:g}",
        Spacetime.schwarzschild(scale, chart),
        *rays,
        np.where(DELTAS > 0, 1, 2),
    )


def near_critical_kerr(a, r):
    """Photons close to the spherical orbit of radius r (Bardeen 1973): L/E and sqrt(Q)/E, made smaller or
    larger together, seen from the equator at r = 50 with spin a (as the ray sees it)."""
    L = (r**2 * (3 - r) - a**2 * (r + 1)) / (a * (r - 1))
    Q = r**3 * (4 * a**2 - r * (r - 3) ** 2) / (a * (r - 1)) ** 2
    factor = 1 + DELTAS
    rays = rays_from_constants(a, 50.0, 1.0, 0.0, L * factor, np.maximum(Q, 0) * factor**2, 1.0)
    return HardCase(f"critical, Kerr {a:g}, orbit {r:.4g}", Spacetime.kerr(1, -a), *rays, np.where(DELTAS > 0, 1, 2))


def throat_rays(throat):
    b = throat * (1 + DELTAS)
    height = 5 * throat
    r = np.hypot(height, throat)
    sine = b / r
    rays = planar_rays((height + r) / 2, -np.sqrt(1 - sine**2), sine)
    return HardCase(f"throat, scale {throat:g}", Spacetime.ellis(throat), *rays, np.where(DELTAS > 0, 1, 3))


def ergosphere(a, r):
    """An observer on the equator inside the ergosphere looks everywhere; E <= 0 must fall in."""
    position, *basis = oblate_basis(a, r, 1.0, 0.0)
    local = np.concatenate([np.eye(3), -np.eye(3), sphere_of_directions()])
    _, delta, area = kerr_functions(a, r, 1.0, 0.0)
    # the forward photon of a backward ray in a hole of spin a sees the spin -a
    energy = np.sqrt(r**2 * delta / area) - 2 * a * r / area * np.sqrt(area) / r * local[:, 2]
    rays = np.tile(position, (len(local), 1)), local @ np.array(basis)
    return HardCase(f"ergosphere, spin {a:g}, r {r:g}", Spacetime.kerr(1, a), *rays, np.where(energy <= 0, 2, -1))


def axis_rays(a):
    """On the axis, along it, and off it with L = 0 and L = 1e-8, from 10 M."""
    on_axis = everywhere([0.0, 0.0, 10.0])
    position, e_r, e_theta, e_phi = oblate_basis(a, 10.0, np.sin(1.0), np.cos(1.0))
    angles = np.linspace(0, 2 * np.pi, 25)[:, None]
    meridian = np.cos(angles) * e_r + np.sin(angles) * e_theta
    nearly = unit(meridian + 1e-8 * e_phi)
    origins = np.concatenate([on_axis[0], np.tile(position, (50, 1))])
    return HardCase(f"axis, spin {a:g}", Spacetime.kerr(1, a), origins, np.concatenate([on_axis[1], meridian, nearly]))


def at_the_horizon(a):
    """A camera at 1.0001 r_plus, at 1 radian from the axis and on it, looks everywhere."""
    r = 1.0001 * (1 + np.sqrt(1 - a**2))
    position, *_ = oblate_basis(a, r, np.sin(1.0), np.cos(1.0))
    pole, *_ = oblate_basis(a, r, 0.0, 1.0)
    rays = [np.concatenate(parts) for parts in zip(everywhere(position), everywhere(pole), strict=True)]
    return HardCase(f"horizon, spin {a:g}", Spacetime.kerr(1, a), *rays)


def radial_rays():
    """Straight out and straight in, by every metric."""
    origin, out = np.array([[3.0, 4.0, 12.0]] * 2), np.array([[3.0, 4.0, 12.0], [-3.0, -4.0, -12.0]]) / 13
    yield HardCase("radial, Schwarzschild", Spacetime.schwarzschild(1), origin, out, np.array([1, 2]))
    yield HardCase("radial, Ellis", Spacetime.ellis(1), origin, out, np.array([1, 3]))
    yield HardCase("radial, Kerr", Spacetime.kerr(1, 0.9), origin, out, np.array([1, 2]))


def far_away(distance):
    """From far away, straight past, at the hole, and around it; all angles of the order of the hole's."""
    impact = np.linspace(0, 40, 41)
    origins = np.tile([distance * 0.6, 0.0, distance * 0.8], (41, 1))
    inward, across = -origins[0] / distance, np.array([0.0, 1.0, 0.0])
    return HardCase(
        f"from {distance:g} M", Spacetime.kerr(1, 0.9), origins, unit(inward + impact[:, None] / distance * across)
    )


def hard_cases():
    """All of them, as a list of HardCase."""
    cases = [near_critical_schwarzschild(s, c) for s in (1e-6, 1.0, 1e6) for c in ("isotropic", "areal")]
    for a in EXTREME_SPINS:
        cosine = np.cos(2 / 3 * np.arccos(np.array([-a, a])))
        prograde, retrograde = 2 * (1 + cosine)
        # between the equatorial orbits Q > 0; at the middle one the photon crosses the equator steeply
        cases += [near_critical_kerr(a, r) for r in (prograde * (1 + 1e-3), (prograde + retrograde) / 2)]
        cases += [axis_rays(a), at_the_horizon(a)]
    cases += [throat_rays(s) for s in (1e-6, 1.0, 1e6)]
    cases += [ergosphere(0.998, 1.2), ergosphere(0.998, 1.9), ergosphere(0.999999, 1.01)]
    cases += list(radial_rays())
    cases += [far_away(1e3), far_away(1e6)]
    tangent = np.array([[isotropic_radius(3.0), 0, 0]])
    cases.append(
        HardCase("circular orbit", Spacetime.schwarzschild(1), tangent, np.array([[0, 1.0, 0]]), np.array([0]))
    )
    inside = everywhere([isotropic_radius(2.5), 0.0, 0.0])
    cases.append(HardCase("inside the photon sphere", Spacetime.schwarzschild(1), *inside))
    return cases
