"""The accretion disk as a light: irradiance in closed form, and agreement of all ways to find its light."""

import meshes
import numpy as np
import pytest
from bentlight_native import ProgramBuilder, Spacetime
from meshes import annulus
from scenes import add, look_at, new_scene, perspective
from test_bidirectional import GRAY, assert_equal_means, pictures
from test_direct_light import patch_radiance
from test_render_light import z_score


def power_law_program(spin, mass=1.0, power=-2.0, doppler=1.0, gravitational=1.0):
    """An opaque disk of radiance g^4 (r / mass)^power, each factor of g to the power of its slider."""
    builder = ProgramBuilder()
    constant = builder.constant
    operands = (constant(mass), constant(spin))
    radius, _azimuth, *factors, _order = builder.emit("disk", *operands, immediates=("OBLATE",))
    radiance = builder.emit("math", radius, constant(power), constant(0), immediates=("POWER",))[0]
    for factor, slider in zip(factors, (doppler, gravitational), strict=True):
        (shift,) = builder.emit("math", factor, constant(4 * slider), constant(0), immediates=("POWER",))
        (radiance,) = builder.emit("multiply", radiance, shift)
    builder.emit("emission", constant(1.0), radiance, constant(1.0))
    return builder.build()


def disk_scene(spin, inner=6.0, outer=20.0, mass=1.0, **sliders):
    """A hole at the origin and its disk, whose edges are polygons of 512 sides."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.kerr(mass, mass * spin) if spin else Spacetime.schwarzschild(mass, "areal"))
    material = scene.add_material(power_law_program(spin, mass, **sliders))
    mesh = scene.add_mesh(*annulus(inner * mass, outer * mass, 8, 512))
    scene.add_instance(mesh, np.eye(4), materials=np.array([material], np.int32))
    return scene


def test_irradiance_on_the_axis():
    """Nearly flat space (radii of 1e6 masses and more): a ring at radius r, of radiance L, brings 2 pi L h^2 r dr /
    (h^2 + r^2)^2 to a patch that faces it at height h. L = 1 / r^2 has a closed integral. g is 1 but for 1e-3 that
    cancel: the first order in v is odd in azimuth, the second adds 1e-5."""
    inner, outer, height = 1.0, 3.0, 2.0
    scene = disk_scene(0.0, inner * 1e6, outer * 1e6, 1e-6)

    def integral(r):  # of 1 / (r (h^2 + r^2)^2), times h^4
        square = height**2 + r**2
        return 0.5 * np.log(r**2 / square) + 0.5 * height**2 / square

    side = 2 * np.pi / 512
    area = np.sin(side) / side  # of the polygons, over that of circles
    expected = 2 * area * (integral(outer) - integral(inner)) / height**2 * 1e-12
    values = patch_radiance(scene, samples=256, at=(0, 0, height), up=(0, 0, -1))
    assert abs(z_score(values, expected)) < 4


@pytest.mark.parametrize("spin", [0.0, 0.9])
def test_all_ways_to_find_the_disk_agree(spin):
    """Beside a hole, where its light comes shifted and from all around: connections with it, chance, and both, by a
    Z-test."""
    means, variances = [], []
    for sampling, samples in (("SCATTERING", 192), ("CONNECTIONS", 48), ("BOTH", 48)):
        place, up = np.array([0.0, 11.0, 4.0]), np.array([0.0, -0.8, -0.6])
        scene = disk_scene(spin, 4.0, 9.0)
        settings = {"light_sampling": sampling, "tolerance": 1e-3}
        values = patch_radiance(scene, samples=samples, at=place, up=up, **settings)
        means.append(values.mean())
        variances.append(values.var(ddof=1) / values.size)
    for i in (1, 2):
        assert abs(means[0] - means[i]) / np.sqrt(variances[0] + variances[i]) < 4, means
    assert np.sqrt(variances[2]) < 0.03 * means[2]  # or the test could not tell


def test_from_both_ends():
    """A room lit by the disk, traced from both ends: the shift between disk and camera is known when light starts."""
    scene = disk_scene(0.0, 6.0, 9.0, 0.15, power=0.0)
    add(scene, meshes.box((-2, -2, -2), (2, 2, 2)), GRAY)
    perspective(scene, look_at((0, -1.9, 0.9), (0, 1.9, -0.9)))
    scene.commit()
    assert scene.bidirectional_obstacle() is None
    both = pictures(scene, 8, 16, integrator="BIDIRECTIONAL")
    assert_equal_means(both, pictures(scene, 32, 16))
