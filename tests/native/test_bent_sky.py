"""The light of an uneven sky on surfaces in bent space, found in every way, against quadrature over traced rays."""

import numpy as np
import pytest
from bentlight_native import Spacetime, trace_rays
from scenes import new_scene
from test_direct_light import checkered_sky, patch_radiance
from test_render_light import z_score

ESCAPED, ESCAPED_FAR = 1, 3
BRIGHT = 20.0
# Axes of the spacetime in the world: none along an edge of the checker.
TURNED = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
TURNED *= np.linalg.det(TURNED)
# Spacetime, distance of the patch from the center, and which way it faces.
CASES = {
    "isotropic, inward": (Spacetime.schwarzschild(0.5), 1.6, -1),
    "isotropic, beside the horizon": (Spacetime.schwarzschild(0.5), 0.5, 1),
    "areal, inward": (Spacetime.schwarzschild(0.5, "areal"), 3.0, -1),
    "areal, outward": (Spacetime.schwarzschild(0.5, "areal"), 1.3, 1),
    "wormhole, inward": (Spacetime.ellis(0.5), 0.8, -1),
    "wormhole, outward": (Spacetime.ellis(0.5), 0.4, 1),
    "spinning, inward": (Spacetime.kerr(0.5, 0.45), 2.5, -1),
    "spinning, outward": (Spacetime.kerr(0.5, 0.45), 1.7, 1),
}


def received(spacetime, distance, sign, radiance, steps=600):
    """Irradiance over pi by rays even in the hemisphere's projection. Directions of the far sky are mirrored."""
    grid = (np.arange(steps) + 0.5) / steps
    cosine2, turn = (a.ravel() for a in np.meshgrid(grid, 2 * np.pi * grid))
    sine = np.sqrt(1 - cosine2)
    launch = np.stack([sign * np.sqrt(cosine2), sine * np.cos(turn), sine * np.sin(turn)], axis=1)
    rays = trace_rays(spacetime, np.tile([distance, 0.0, 0], (len(launch), 1)), launch, 1e-6)
    seen = np.where(rays["fate"][:, None] == ESCAPED_FAR, [1, -1, 1], 1) * rays["direction"]
    escaped = np.isin(rays["fate"], (ESCAPED, ESCAPED_FAR))
    return (radiance(seen[escaped] @ TURNED.T)).sum() / len(launch)


@pytest.mark.parametrize("case", CASES)
def test_an_uneven_sky_in_bent_space(case):
    """Chance, connections and both bring what traced rays see. Around a spinning hole connections know two images only,
    and are left out there alone."""
    spacetime, distance, sign = CASES[case]
    program, radiance = checkered_sky(BRIGHT)
    exact = received(spacetime, distance, sign, radiance)
    ways = {"SCATTERING": 256, "BOTH": 128} | ({} if case.startswith("spinning") else {"CONNECTIONS": 128})
    at = np.eye(4)
    at[:3, :3] = TURNED
    for sampling, samples in ways.items():
        scene = new_scene()
        scene.set_spacetime(spacetime, at)
        scene.set_world(program)
        place, up, side = distance * TURNED[:, 0], sign * TURNED[:, 0], TURNED[:, 1]
        settings = {"samples": samples, "light_sampling": sampling, "tolerance": 1e-5}
        values = patch_radiance(scene, at=place, up=up, side=side, **settings)
        assert abs(z_score(values, exact)) < 4, (sampling, values.mean(), exact)
        assert sampling == "CONNECTIONS" or values.std() / 8 < 0.02 * exact
