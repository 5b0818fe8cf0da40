"""The rays of the Kerr benchmark: a square of the image plane of a distant observer, as local rays for ``trace_rays``.

Image-plane coordinates (alpha, beta) as in Bardeen 1973: a photon of energy 1 has L = -alpha sin(i) and
Q = beta^2 + cos(i)^2 (alpha^2 - s^2), where s is the spin that the backward ray sees, minus the hole's.
"""

import numpy as np


def kerr_rays(spin_seen=0.9, inclination_deg=80.0, r=50.0, grid=256, half_width=15.0):
    """Origins and local directions (grid^2, 3) in the axes of ``Spacetime.kerr(1, -spin_seen)``."""
    s, theta = spin_seen, np.deg2rad(inclination_deg)
    cells = (2 * (np.arange(grid) + 0.5) / grid - 1) * half_width
    alpha, beta = np.tile(cells, grid), np.repeat(cells, grid)
    ct, st = np.cos(theta), np.sin(theta)
    L = -alpha * st
    Q = beta**2 + ct**2 * (alpha**2 - s**2)
    sigma, delta = r**2 + (s * ct) ** 2, r**2 - 2 * r + s**2
    area = (r**2 + s**2) ** 2 - delta * (s * st) ** 2
    omega, g_phi = 2 * s * r / area, np.sqrt(area / sigma) * st
    radial = -np.sqrt(np.maximum(0, (r**2 + s**2 - s * L) ** 2 - delta * (Q + (L - s) ** 2)))
    polar = np.where(beta > 0, -1, 1) * np.sqrt(np.maximum(0, Q + (s * ct) ** 2 - (L * ct / st) ** 2))
    d = np.stack([radial / np.sqrt(sigma * delta), polar / np.sqrt(sigma), L / g_phi], -1)
    d /= (1 - omega * L)[:, None] / np.sqrt(sigma * delta / area)
    q = np.hypot(r, s)
    basis = np.array([[r * st, 0, q * ct], [q * ct, 0, -r * st], [0, np.sqrt(sigma), 0]]) / np.sqrt(sigma)
    directions = d @ basis
    origins = np.tile([q * st, 0.0, r * ct], (grid * grid, 1))
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)
