"""Light that walks below surfaces: where it enters, that none is lost or won, and whose surface it comes out of."""

import meshes
import numpy as np
import pytest
from bsdf_tools import SCENE, Grid, chi_square_z, direction, material, subsurface
from scenes import add, emission, glossy, look_at, new_scene, perspective, render

SUBSURFACE = 32
LITTLE = {"width": 6, "height": 6, "samples": 256, "max_bounces": 8, "names": ("combined",)}


def flesh(color=(1, 1, 1), radius=(1, 1, 1), scale=1.0, anisotropy=0.0, method="RANDOM_WALK", alpha=0.0):
    """An operation for scenes.add."""
    return ("subsurface", color, radius, scale, 1.4, alpha, anisotropy, (0, 0, 0), [method])


def mean_and_error(scene, **settings):
    """The mean radiance (3,) of the picture, and its standard error, by renders with different seeds."""
    pictures = [render(scene, **LITTLE | settings, seed=seed)[0]["combined"][..., :3] for seed in range(8)]
    means = np.array([picture.mean(axis=(0, 1)) for picture in pictures], float)
    return means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(len(means))


def seen_from_above(scene, mesh, *closures, half=0.1):
    add(scene, mesh, *closures)
    perspective(scene, look_at((0.0, -4.0, 1.0), (0, 0, 0)), half=half)


@pytest.mark.parametrize("anisotropy", [0.0, 0.6, 0.9])
@pytest.mark.parametrize("method", ["RANDOM_WALK", "RANDOM_WALK_SKIN"])
def test_white_flesh_in_a_white_sky_cannot_be_seen(method, anisotropy):
    """A medium that absorbs nothing gives back what enters, whatever its shape, its free paths and the guiding: these
    are long enough here, and different enough, that walks are not cut and channels are weighed against each other."""
    scene = new_scene((1, 1, 1))
    radius = np.array((3.0, 8.0, 20.0)) * (1 if method == "RANDOM_WALK" else 300) / (1 - anisotropy)
    closure = flesh(radius=radius, anisotropy=anisotropy, method=method)
    seen_from_above(scene, meshes.box((-1, -1, -1), (1, 1, 1)), closure)
    scene.commit()
    mean, error = mean_and_error(scene)
    assert (error < 0.01).all()
    assert (np.abs(mean - 1) < 4.5 * error + 1e-4).all(), (mean, error)


@pytest.mark.parametrize("color", [0.2, 0.5, 0.8])
def test_a_deep_medium_reflects_its_color(color):
    """The single-scattering albedo is a fit to half spaces that are lit evenly; within its error, 0.02, this is one."""
    scene = new_scene((1, 1, 1))
    closure = flesh((color, 1.1 * color, 0.9 * color), radius=(0.1, 0.1, 0.1), method="RANDOM_WALK_SKIN", alpha=1.0)
    seen_from_above(scene, meshes.box((-1, -1, -1), (1, 1, 1)), closure)
    scene.commit()
    mean, error = mean_and_error(scene)
    assert (np.abs(mean - color * np.array((1, 1.1, 0.9))) < 4.5 * error + 0.02).all(), (mean, error)


def test_light_leaves_only_through_the_object_that_it_entered():
    pictures = []
    for hidden in (False, True):
        scene = new_scene((0.3, 0.4, 0.5))
        closure = flesh((0.8, 0.5, 0.3), radius=(2.0, 1.0, 0.5), anisotropy=0.3)
        seen_from_above(scene, meshes.box((-1, -1, -1), (1, 1, 1)), closure, half=0.4)
        add(scene, meshes.box((-3, -3, -1.5), (3, 3, -1.2)), glossy((0.9, 0.8, 0.7), 0.2))
        if hidden:
            add(scene, meshes.sphere(0.5, (0.2, 0.1, 0.0)), emission((100.0, 0.0, 0.0)))
        scene.commit()
        pictures.append(render(scene, **LITTLE, light_sampling="SCATTERING")[0]["combined"])
    np.testing.assert_array_equal(*pictures)


def test_instances_are_walked_through_where_they_are():
    """A mesh that is moved, turned, squeezed and mirrored is the same as its vertices are."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[0.8, -0.3, 0.1], [0.2, 1.1, 0.3], [-0.1, 0.2, -0.9]])
    matrix[:3, 3] = 0.1, 0.2, 0.05
    vertices, triangles = meshes.box((-1, -0.5, -0.7), (1, 0.5, 0.7))
    moved = (vertices @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)
    found = []
    for mesh, at in (((vertices, triangles), matrix), ((moved, triangles), np.eye(4))):
        scene = new_scene((0.3, 0.4, 0.5))
        scene.set_suns([(0.3, -0.5, 1)], [(30, 20, 10)], 0.3)
        add(scene, mesh, flesh((0.9, 0.5, 0.3), radius=(3.0, 1.5, 0.5)), at=at)
        perspective(scene, look_at((0.0, -4.0, 1.0), (0, 0, 0)), half=0.4)
        scene.commit()
        found.append(mean_and_error(scene))
    (here, error), (there, other) = found
    assert (np.abs(here - there) < 4.5 * np.hypot(error, other)).all()


def test_no_bounces_leave_direct_light():
    """As for diffuse surfaces: what comes out is lit, and goes no farther."""
    scene = new_scene((0.0, 0.0, 0.0))
    scene.set_suns([(0.0, -1.0, 1.0)], [(30, 30, 30)], 0.3)
    seen_from_above(scene, meshes.box((-1, -1, -1), (1, 1, 1)), flesh((0.8, 0.5, 0.3)))
    scene.commit()
    (direct, error), (all_light, other) = (mean_and_error(scene, max_bounces=n) for n in (0, 8))
    assert (direct > 0.1).all()
    assert (np.abs(direct - all_light) < 4.5 * np.hypot(error, other)).all()  # a convex body lights itself inside only


def entered(index, wo, count=200_000):
    drawn = SCENE.draw_bsdf(index, np.random.default_rng(5).random((count, 3)), wo=wo)
    assert (drawn.lobe == SUBSURFACE).all() and (drawn.pdf == 0).all() and (drawn.wi[:, 2] < 0).all()
    return drawn


@pytest.mark.parametrize("alpha, mu", [(0.3, 0.9), (0.6, 0.4), (1.0, 0.7)])
@pytest.mark.parametrize("method", ["RANDOM_WALK", "RANDOM_WALK_SKIN"])
def test_light_enters_through_the_visible_microfacets(method, alpha, mu):
    """By chi-square: refraction at normals that are seen (Walter et al. 2007, equation 17, by Heitz' visible normals);
    half of what enters skin goes by a cosine, the rest as through the roughest surface."""
    ior, grid, wo = 1.4, Grid(), direction(mu)
    drawn = entered(material(subsurface(0.5, ior=ior, alpha=alpha, method=method)), wo)
    skin = method == "RANDOM_WALK_SKIN"
    roughness = 1.0 if skin else alpha
    wi = grid.directions().reshape(-1, 3)
    half = -(wo + ior * wi)
    length = np.linalg.norm(half, axis=1)
    h = half / length[:, None] * np.sign(half[:, 2:])
    cos_i, cos_o = h @ wo, (h * wi).sum(axis=1)
    slope2 = (1 - h[:, 2] ** 2) / (roughness * h[:, 2]) ** 2
    density = 1 / (np.pi * roughness**2 * h[:, 2] ** 4 * (1 + slope2) ** 2)
    seen = 2 / (1 + np.sqrt(1 + roughness**2 * (1 / mu**2 - 1))) * np.maximum(cos_i, 0) * density / mu
    pdf = np.where((cos_i > 0) & (cos_o < 0), seen * ior**2 * np.abs(cos_o) / length**2, 0) * (wi[:, 2] < 0)
    if skin:
        pdf = (pdf + np.maximum(-wi[:, 2], 0) / np.pi) / 2
    chance = pdf.reshape(grid.rows * grid.columns, -1).mean(axis=1) * grid.cell
    assert abs(chance.sum() - 1) < 0.01
    assert chi_square_z(grid.count(drawn.wi), chance * len(drawn.wi)) < 4


def test_the_weight_of_entering_is_the_color():
    drawn = entered(material(subsurface((0.9, 0.5, 0.2), alpha=0.4)), direction(0.6), 100)
    np.testing.assert_allclose(drawn.weight, np.tile((0.9, 0.5, 0.2), (100, 1)), rtol=1e-12)


def test_channels_without_a_radius_are_diffuse():
    index = material(subsurface((0.9, 0.5, 0.2), radius=(1.0, 0.0, 0.0)))
    value, _ = SCENE.evaluate_bsdf(index, [direction(0.7)])
    np.testing.assert_allclose(value, [[0, 0.5 * 0.7 / np.pi, 0.2 * 0.7 / np.pi]], rtol=1e-12)
    np.testing.assert_allclose(SCENE.shade(index)["albedo"], [[0.9, 0.5, 0.2]], rtol=1e-12)
