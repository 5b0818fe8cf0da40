"""Edges of shadows against the golden data: a hair outside a ray escapes, a hair inside it is captured."""

import numpy as np
import pytest
from bentlight_native import Spacetime, trace_rays
from golden import numbers, rows, sine_cosine_deg
from rays import image_plane_rays, oblate_basis, rays_from_constants

ROUTES = ["taylor", "auto"]


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("hair", [1e-6, 1e-8])
def test_edge_seen_from_r_10(route, hair):
    table = rows("shadow_r10.csv")
    spins, psi, position_angle = (
        numbers(table, name) for name in ("a", "psi_from_inward_rad", "pos_angle_rad=atan2(-n_theta,n_phi)")
    )
    sine, cosine = sine_cosine_deg(numbers(table, "theta_obs_deg"))
    position, e_r, e_theta, e_phi = oblate_basis(spins, numbers(table, "r_obs"), sine, cosine)
    for mirror in (1, -1):  # the other half of the edge
        for side, fate in ((1 + hair, 1), (1 - hair, 2)):
            n_theta = -np.sin(psi * side) * np.sin(position_angle) * mirror
            n_phi = np.sin(psi * side) * np.cos(position_angle)
            look = [-np.cos(psi * side), n_theta, n_phi]
            directions = sum(x[:, None] * e for x, e in zip(look, (e_r, e_theta, e_phi), strict=True))
            for a in np.unique(spins):
                of = spins == a
                got = trace_rays(Spacetime.kerr(1, a), position[of], directions[of], 1e-8, route=route)
                assert np.all(got["fate"] == fate), (a, mirror, side)


@pytest.mark.parametrize("route", ROUTES)
def test_edge_seen_from_far_away(route):
    """Fates depend on L/E and Q/E^2 alone, so the far observer's coordinates are launched from r = 100. The golden L is
    the photon's in a hole of spin a; the backward ray's coordinates are those of spin -a, mirrored in alpha."""
    table = rows("shadow_far.csv")
    spins, angle = numbers(table, "a"), numbers(table, "theta_obs_deg")
    alpha, beta = numbers(table, "alpha=-L/(E sin th)"), numbers(table, "beta(>=0; mirror -beta)")
    tilted = angle > 0
    assert np.count_nonzero(tilted) > 100
    for a, inclination in sorted(set(zip(spins[tilted], angle[tilted], strict=True))):
        of = (spins == a) & (angle == inclination)
        for factor, fate in ((1 + 1e-7, 1), (1 - 1e-7, 2)):
            for mirror in (1, -1):
                x, y = -alpha[of] * factor, mirror * beta[of] * factor
                got = trace_rays(
                    Spacetime.kerr(1, a), *image_plane_rays(-a, inclination, 100.0, x, y), 1e-8, route=route
                )
                assert np.all(got["fate"] == fate), (a, inclination, factor)


@pytest.mark.parametrize("route", ROUTES)
def test_equatorial_photon_orbits(route):
    """Prograde and retrograde critical impact parameters, and the horizon, of the closed forms."""
    for row in rows("kerr_radii.csv"):
        a = float(row["a"])
        for column in ("L_over_E_photon_prograde", "L_over_E_photon_retrograde"):
            for factor, fate in ((1 + 1e-8, 1), (1 - 1e-8, 2)):
                # seen by the ray, spin and L change sign together
                ray = rays_from_constants(a, np.array([50.0]), 1.0, 0.0, float(row[column]) * factor, 0.0, 1.0)
                assert trace_rays(Spacetime.kerr(1, -a), *ray, 1e-8, route=route)["fate"][0] == fate
        assert np.hypot(float(row["r_plus"]), a) == pytest.approx(Spacetime.kerr(1, a).core_radius, rel=1e-14)
