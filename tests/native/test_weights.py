"""Multiple importance sampling does what it promises: the noise of light that is found by chance, by connections and by
both is what the power heuristic's weights (Veach and Guibas 1995) make of the densities of both ways."""

import numpy as np
import pytest
from bsdf_tools import NORMAL, material
from scenes import emission, look_at, new_scene, perspective, quad, render
from scenes import material as emitter

DIFFUSE = ("diffuse", (1.0, 0.0, NORMAL), None, 1.0)
NUMBERS = 1 << 18  # of each estimate
SIZE = 128  # pixels along a side: one sample each


def metal(roughness):
    return ("glossy", (1.0, roughness, NORMAL, 0.0, 0.0, (1.0, 0.0, 0.0)), "GGX", 1.0)


# A patch's material, the half width of the square lamp above it at height 1, and the way that is noisy there.
CASES = {
    "small lamp": (DIFFUSE, 0.1, "SCATTERING"),
    "both alike": (metal(0.5), 0.4, None),
    "sharp metal": (metal(0.15), 1.5, "CONNECTIONS"),
}


def lit_patch(closure, half_width):
    """A small patch in the plane z = 0, seen from near by, and the lamp; returns the scene and the patch's material."""
    scene = new_scene()
    patch = material(closure, scene=scene)
    mesh = scene.add_mesh(*quad(1e-4, 1e-4))
    scene.add_instance(mesh, np.eye(4), materials=np.array([patch], np.int32))
    light = np.array([scene.add_material(emitter(emission((1, 1, 1))))], np.int32)
    above = np.diag([1.0, -1, -1, 1])
    above[2, 3] = 1
    scene.add_instance(scene.add_mesh(*quad(half_width, half_width)), above, materials=light)
    perspective(scene, look_at((3e-5, 0, 1e-4), (0, 0, 0), up=(0, 1, 0)), half=1e-6)
    scene.commit()
    return scene, patch


def predicted(scene, patch, half_width):
    """What each way of sampling finds, (n,) estimates by name; BOTH: of its two halves."""
    rng = np.random.default_rng(1)
    wo = np.array([0.3, 0, 1]) / np.hypot(0.3, 1)
    _, target, probability = scene.draw_lights(
        np.zeros((NUMBERS, 3)), np.tile([0.0, 0, 1], (NUMBERS, 1)), rng.random((NUMBERS, 4))
    )
    distance = np.linalg.norm(target, axis=1)
    wi = target / distance[:, None]
    per_angle = distance**2 / (2 * half_width**2 * wi[:, 2])  # from a share of one triangle to a pdf by solid angle
    drawn, weighed = probability[:, 0] * per_angle, probability[:, 1] * per_angle
    assert np.ptp(weighed) < 1e-6 * weighed[0]  # even in solid angle, and the triangles are mirror images
    value, rival = scene.evaluate_bsdf(patch, wi, wo=wo)
    connections = value[:, 0] / drawn
    connections_weighed = connections * weighed**2 / (weighed**2 + rival**2)
    samples = scene.draw_bsdf(patch, rng.random((NUMBERS, 3)), wo=wo)
    hit = (samples.wi[:, 2] > 0) & (np.abs(samples.wi[:, :2]).max(axis=1) < half_width * samples.wi[:, 2])
    scattering = samples.weight[:, 0] * hit
    scattering_weighed = scattering * samples.pdf**2 / (samples.pdf**2 + weighed[0] ** 2)
    return {
        "SCATTERING": [scattering],
        "CONNECTIONS": [connections],
        "BOTH": [scattering_weighed, connections_weighed],
    }


def rendered(scene, way):
    settings = {"max_bounces": 0, "light_threshold": 0, "light_sampling": way, "sampling_pattern": "CLASSIC"}
    runs = [
        render(scene, SIZE, SIZE, 1, seed=s, names=("combined",), **settings)[0]["combined"][..., 0]
        for s in range(NUMBERS // SIZE**2)
    ]
    return np.concatenate(runs, axis=None).astype(float)


def moments(*terms):
    """Mean and variance of a sum of independent numbers, and the squared errors of both."""
    result = np.zeros(4)
    for numbers in terms:
        variance = numbers.var()
        fourth = ((numbers - numbers.mean()) ** 4).mean()
        result += numbers.mean(), variance, variance / len(numbers), (fourth - variance**2) / len(numbers)
    return result


@pytest.mark.parametrize("case", CASES)
def test_the_noise_is_that_of_the_power_heuristic(case):
    """Mean and variance of 2^18 samples of each way, by Z-tests against the formula. Where one way alone is bad, both
    together are as good as the other but for a part of the squared mean, less than the half that Veach and Guibas 1995
    prove for the balance heuristic."""
    closure, half_width, bad = CASES[case]
    scene, patch = lit_patch(closure, half_width)
    noise = {}
    for way, terms in predicted(scene, patch, half_width).items():
        expected, found = moments(*terms), moments(rendered(scene, way))
        error = np.sqrt(expected[2:] + found[2:])
        assert np.all(np.abs(found[:2] - expected[:2]) < 4 * error), (way, expected, found)
        noise[way] = found[1] / found[0] ** 2
    if bad:
        both, worst = noise.pop("BOTH"), noise.pop(bad)
        assert worst > 10 and both < min(noise.values()) + 0.1
