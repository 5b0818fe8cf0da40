"""Local rays from the coordinates and constants of the motion that papers and golden data give them in.

The formulas are the textbook's (Bardeen, Press & Teukolsky 1972), written here a second time, apart from the core's.
"""

import numpy as np


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def oblate_basis(a, r, sin_theta, cos_theta):
    """Position at azimuth 0 and flat basis (e_r, e_theta, e_phi) of the oblate chart; vectors last."""
    a, r, s, c = np.broadcast_arrays(a, r, sin_theta, cos_theta)
    q, zero = np.hypot(r, a), np.zeros_like(r, dtype=float)
    sigma = np.sqrt(r**2 + (a * c) ** 2)[..., None]
    position = np.stack([q * s, zero, r * c], -1)
    e_r = np.stack([r * s, zero, q * c], -1) / sigma
    e_theta = np.stack([q * c, zero, -r * s], -1) / sigma
    return position, e_r, e_theta, np.stack([zero, zero + 1, zero], -1)


def kerr_functions(a, r, sin_theta, cos_theta):
    """Sigma, Delta, A of the Kerr metric with M = 1."""
    sigma, delta = r**2 + (a * cos_theta) ** 2, r**2 - 2 * r + a**2
    return sigma, delta, (r**2 + a**2) ** 2 - delta * (a * sin_theta) ** 2


def rays_from_constants(spin_seen, r, sin_theta, cos_theta, L, Q, polar_sign, radial_sign=-1.0):
    """Origins and local directions of rays with E = 1, L, Q in the axes of ``Spacetime.kerr(1, -spin_seen)``.

    spin_seen is the spin as the backward ray sees it, minus the hole's. polar_sign: of d(theta)/d(lambda).
    """
    s = spin_seen
    sigma, delta, area = kerr_functions(s, r, sin_theta, cos_theta)
    omega, g_phi = 2 * s * r / area, np.sqrt(area / sigma) * sin_theta
    radial = radial_sign * np.sqrt(np.maximum(0, (r**2 + s**2 - s * L) ** 2 - delta * (Q + (L - s) ** 2)))
    polar = polar_sign * np.sqrt(np.maximum(0, Q + (s * cos_theta) ** 2 - (L * cos_theta / sin_theta) ** 2))
    energy = (1 - omega * L) / np.sqrt(sigma * delta / area)
    d = [radial / np.sqrt(sigma * delta) / energy, polar / np.sqrt(sigma) / energy, L / g_phi / energy]
    position, *basis = oblate_basis(s, r, sin_theta, cos_theta)
    directions = sum(np.asarray(x)[..., None] * e for x, e in zip(d, basis, strict=True))
    return np.broadcast_to(position, directions.shape).copy(), unit(directions)


def image_plane_rays(spin_seen, inclination_deg, r, alpha, beta):
    """Rays of an image plane (Bardeen 1973): L = -alpha sin i, Q = beta^2 + cos^2 i (alpha^2 - s^2)."""
    s, c = np.sin(np.deg2rad(inclination_deg)), np.cos(np.deg2rad(inclination_deg))
    Q = beta**2 + c**2 * (alpha**2 - spin_seen**2)
    return rays_from_constants(spin_seen, r, s, c, -alpha * s, Q, np.where(beta > 0, -1.0, 1.0))


def image_grid(spin_seen=0.9, inclination_deg=80.0, r=50.0, grid=256, half_width=15.0):
    """Rays of a square grid of cell centers across the image plane, alpha fastest: the speed benchmark's rays."""
    cells = (2 * (np.arange(grid) + 0.5) / grid - 1) * half_width
    return image_plane_rays(spin_seen, inclination_deg, r, np.tile(cells, grid), np.repeat(cells, grid))


def planar_rays(radius, cos_psi, sin_psi, along=(1.0, 0.0, 0.0), toward=(0.0, 1.0, 0.0)):
    """Rays at scene radius `radius` on the axis `along`, at angle psi from outward, turning to `toward`."""
    radius, cos_psi, sin_psi = np.broadcast_arrays(radius, cos_psi, sin_psi)
    along, toward = np.asarray(along, float), np.asarray(toward, float)
    return radius[:, None] * along, cos_psi[:, None] * along + sin_psi[:, None] * toward


def isotropic_radius(r, mass=1.0):
    """Scene radius of the isotropic Schwarzschild chart, exact at the horizon."""
    return 0.5 * (r - mass + np.sqrt(r * (r - 2 * mass)))


def angle_between(a, b):
    """Angle between unit vectors, accurate when small."""
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
