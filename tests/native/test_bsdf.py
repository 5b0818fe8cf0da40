"""BSDFs: what is drawn is what is evaluated, energy is conserved, and the laws of optics hold."""

import numpy as np
import pytest
from bentlight_native import ProgramBuilder
from bsdf_tools import (
    NORMAL,
    SCENE,
    Grid,
    brought,
    chi_square_z,
    diffuse,
    direction,
    draw_evenly,
    glass,
    glossy,
    immediates_of,
    material,
    metallic,
    principled,
    sheen,
    subsurface,
    transparent,
)
from closure_table import ROUGH
from microfacet_oracle import fresnel, layer_energy

DIFFUSE, GLOSSY, TRANSMISSION, TRANSPARENT = 2, 4, 8, 16

# A shading normal 0.3 radians off the geometric one, as a normal map or smooth shading gives.
TILTED = {"geometric_normal": (0, 0, 1), "normal": (np.sin(0.3), 0, np.cos(0.3))}

VIEWS = {
    "front": {"wo": direction(0.8)},
    "grazing": {"wo": direction(0.25)},
    "inside": {"wo": direction(0.7), "backfacing": 1.0},
    "tilted": {"wo": direction(0.6, 2.0)} | TILTED,
}


def uniform(count, seed=1):
    return np.random.default_rng(seed).random((count, 3))


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("name", ROUGH)
def test_drawn_directions_follow_the_pdf(name, view):
    grid, index, point = Grid(), material(*ROUGH[name]), VIEWS[view]
    directions = grid.directions()
    value, pdf = SCENE.evaluate_bsdf(index, directions.reshape(-1, 3), **point)
    pdf[value.max(axis=1) == 0] = 0  # absorbed when drawn
    chance = pdf.reshape(directions.shape[:3]).mean(axis=2).ravel() * grid.cell
    drawn = SCENE.draw_bsdf(index, uniform(200_000), **point)
    kept = drawn.lobe != 0
    # What the pdf gives below the horizon of a tilted normal is absorbed when drawn, and 0 when evaluated.
    observed = np.append(grid.count(drawn.wi[kept]), (~kept).sum())
    expected = np.append(chance, 1 - chance.sum()) * len(kept)
    assert chance.sum() < 1 + 1e-3
    assert chi_square_z(observed, np.maximum(expected, 0)) < 4


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("name", ROUGH)
def test_weight_is_value_over_pdf_and_its_mean_the_albedo(name, view):
    index, point = material(*ROUGH[name]), VIEWS[view]
    drawn = SCENE.draw_bsdf(index, uniform(100_000, 2), **point)
    kept = drawn.lobe != 0
    value, pdf = SCENE.evaluate_bsdf(index, drawn.wi[kept], **point)
    np.testing.assert_allclose(np.linalg.norm(drawn.wi[kept], axis=1), 1, rtol=1e-12)
    np.testing.assert_allclose(drawn.pdf[kept], pdf, rtol=1e-12)
    np.testing.assert_allclose(drawn.weight[kept], value / pdf[:, None], rtol=1e-12)
    grid = Grid(rows=32, columns=32, fine=20)
    value, _ = SCENE.evaluate_bsdf(index, grid.directions().reshape(-1, 3), **point)
    deviation = drawn.weight.std(axis=0) / np.sqrt(len(kept))
    assert (np.abs(drawn.weight.mean(axis=0) - value.mean(axis=0) * 4 * np.pi) < 4.5 * deviation + 2e-4).all()


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.6, 1.0])
@pytest.mark.parametrize("mu", [0.05, 0.2, 0.5, 1.0])
@pytest.mark.parametrize("distribution", ["GGX", "MULTI_GGX"])
def test_white_plastic_loses_what_its_layer_keeps(roughness, mu, distribution):
    """The light that the specular layer takes from the diffuse one but does not reflect. Several bounces between the
    facets of white glass reflect some of it, but not more."""
    reflected, taken = layer_energy(roughness, mu, 1.5)
    index = material(principled(distribution, base_color=1.0, roughness=roughness))
    weight = SCENE.draw_bsdf(index, uniform(40_000, 3), wo=direction(mu)).weight[:, 0]
    error = 4 * weight.std() / np.sqrt(len(weight)) + (0.007 if mu > 0.08 else 0.02)  # microfacet_energy.h
    least = reflected + 1 - taken
    most = least if distribution == "GGX" else 1
    assert least - error < weight.mean() < most + error


@pytest.mark.parametrize(
    "closure",
    [
        diffuse(0.7, 0.9),
        glossy(0.9, 0.4, distribution="GGX"),
        glossy(0.9, 0.4, distribution="GGX", anisotropy=0.6),
        sheen(0.9, 0.7, distribution="ASHIKHMIN"),
    ],
)
def test_reflection_is_reciprocal(closure):
    """f(a, b) = f(b, a), where the model says so: not for lobes whose Fresnel layer or compensation sees wo alone."""
    index = material(closure)
    a, b = direction(0.3, 1.0), direction(0.8, -2.0)
    there, _ = SCENE.evaluate_bsdf(index, [b], wo=a)
    back, _ = SCENE.evaluate_bsdf(index, [a], wo=b)
    np.testing.assert_allclose(there / b[2], back / a[2], rtol=1e-12)


def test_refraction_is_reciprocal_up_to_the_solid_angle():
    """Walter et al. (2007), section 5.4, but with the radiance L / eta^2 that is carried here."""
    index = material(glass(1.0, 0.5, 1.5, distribution="GGX"))
    above, below = direction(0.7, 0.4), -direction(0.8, 0.1)
    down, _ = SCENE.evaluate_bsdf(index, [below], wo=above)
    flipped = {"wo": -below, "backfacing": 1.0}
    up, _ = SCENE.evaluate_bsdf(index, [-above], **flipped)
    np.testing.assert_allclose(down / abs(below[2]) / 1.5**2, up / above[2], rtol=1e-12)


def test_mirror():
    drawn = SCENE.draw_bsdf(material(glossy((0.9, 0.5, 0.2), 0.0)), uniform(10), wo=direction(0.6))
    np.testing.assert_allclose(drawn.wi, np.tile(direction(0.6, np.pi), (10, 1)), atol=1e-12)
    np.testing.assert_allclose(drawn.weight, np.tile([0.9, 0.5, 0.2], (10, 1)), rtol=1e-12)
    assert (drawn.pdf == 0).all() and (drawn.lobe == GLOSSY).all()
    value, pdf = SCENE.evaluate_bsdf(material(glossy(1.0, 0.0)), drawn.wi, wo=direction(0.6))
    assert (value == 0).all() and (pdf == 0).all()


@pytest.mark.parametrize("ior", [1.05, 1.5, 2.4])
@pytest.mark.parametrize("backfacing", [0.0, 1.0])
@pytest.mark.parametrize("mu", [0.1, 0.5, 0.9, 1.0])
def test_smooth_glass_obeys_snell_and_fresnel(ior, backfacing, mu):
    wo, eta = direction(mu, 0.7), 1 / ior if backfacing else ior
    drawn = draw_evenly(glass(ior=ior), wo=wo, backfacing=backfacing)
    through = drawn.lobe == TRANSMISSION
    assert (drawn.pdf == 0).all() and (through | (drawn.lobe == GLOSSY)).all()
    expected = fresnel(mu, eta)
    for lobe, part in ((GLOSSY, expected), (TRANSMISSION, 1 - expected)):
        assert brought(drawn, lobe) == pytest.approx(part, abs=2 / len(through))
    if through.any():
        assert np.abs(drawn.wi[through][:, :2] + wo[:2] / eta).max() < 1e-12
        assert (drawn.wi[through][:, 2] < 0).all()
    else:
        assert expected == pytest.approx(1)


@pytest.mark.parametrize("backfacing", [0.0, 1.0])
@pytest.mark.parametrize("ior", [1.33, 1.5])
@pytest.mark.parametrize("mu", [0.95, 1.0])
def test_lamps_in_smooth_glass_make_little_noise(ior, backfacing, mu):
    """By the part R of the light that it reflects, the second moment of what is seen mirrored alone is R where chance
    follows R: here it is half of that. Where all is as bright both ways, it was 1: here it is hardly more.
    """
    drawn = draw_evenly(glass(ior=ior), wo=direction(mu), backfacing=backfacing)
    square = drawn.weight[:, 0] ** 2
    assert (square * (drawn.lobe == GLOSSY)).mean() < 0.5 * fresnel(mu, 1 / ior if backfacing else ior)
    assert square.mean() < 1.05


def test_rough_glass_tends_to_smooth_glass():
    wo = direction(0.7, 0.7)
    for backfacing in (0.0, 1.0):
        rough = SCENE.draw_bsdf(material(glass(roughness=0.02)), uniform(20_000, 6), wo=wo, backfacing=backfacing)
        smooth = SCENE.draw_bsdf(material(glass()), uniform(20_000, 6), wo=wo, backfacing=backfacing)
        for lobe in (GLOSSY, TRANSMISSION):
            if not (smooth.lobe == lobe).any():
                continue
            mean = np.median(rough.wi[rough.lobe == lobe], axis=0)
            np.testing.assert_allclose(mean, smooth.wi[smooth.lobe == lobe][0], atol=2e-3)
        mirrored = [(drawn.weight[:, 0] * (drawn.lobe == GLOSSY)).mean() for drawn in (rough, smooth)]
        assert abs(mirrored[0] - mirrored[1]) < 0.015


def test_transparent_passes_straight_on():
    index = material(transparent((0.2, 0.5, 0.9)))
    drawn = SCENE.draw_bsdf(index, uniform(5), wo=direction(0.3))
    np.testing.assert_allclose(drawn.wi, np.tile(-direction(0.3), (5, 1)), rtol=1e-15)
    np.testing.assert_allclose(drawn.weight, np.tile([0.2, 0.5, 0.9], (5, 1)), rtol=1e-12)
    assert (drawn.lobe == TRANSPARENT).all() and (drawn.pdf == 0).all()


def test_alpha_splits_the_paths():
    drawn = SCENE.draw_bsdf(material(principled(alpha=0.3, metallic=1.0, base_color=1.0)), uniform(50_000, 7))
    passed = (drawn.lobe == TRANSPARENT).mean()
    assert abs(passed - 0.7) < 4.5 * np.sqrt(0.21 / 50_000) + 1e-3
    assert abs(drawn.weight[:, 0].mean() - 1) < 4e-3


def test_emission_of_a_lobe_stack():
    index = material(principled(emission_color=(1.0, 2.0, 3.0), emission_strength=2.0, alpha=0.5, weight=0.25))
    np.testing.assert_allclose(SCENE.shade(index)["emission"], [[0.25, 0.5, 0.75]], rtol=1e-12)


@pytest.mark.parametrize("mu", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("ior", [1.0, 1.3, 2.0])
def test_a_smooth_coat_dims_and_tints_what_is_below(mu, ior):
    """By its Fresnel reflectance, and by its tint to the power of the way through it: Snell's law."""
    tint, amount = np.array((0.9, 0.5, 0.2)), 0.7
    coat = {"coat_weight": amount, "coat_roughness": 0.0, "coat_ior": ior, "coat_tint": tuple(tint)}
    left = 1 - amount * fresnel(mu, ior) if ior > 1 else 1.0
    way = 1 / np.sqrt(1 - (1 - mu**2) / ior**2)
    expected = left * (1 - amount + amount * tint**way)
    point = {"wo": direction(mu)}
    light = {"emission_color": (1.0, 2.0, 3.0), "emission_strength": 2.0}
    emission = SCENE.shade(material(principled(**coat, **light)), **point)["emission"][0]
    np.testing.assert_allclose(emission, 2 * expected * (1, 2, 3), rtol=1e-9)
    wi = [direction(0.6, 1.0)]
    covered, bare = (
        SCENE.evaluate_bsdf(material(principled(base_color=(0.8, 0.4, 0.1), **settings)), wi, **point)[0][0]
        for settings in (coat, {})
    )
    np.testing.assert_allclose(covered, bare * expected, rtol=1e-9)


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("mu", [0.05, 0.3, 0.9])
def test_a_white_surface_under_a_coat_gains_no_energy(roughness, mu):
    """A coat reflects at most what it takes from the layers below, up to the error of microfacet_energy.h."""
    for below in ({"metallic": 1.0}, {"transmission": 1.0}, {}):
        closure = principled("GGX", base_color=1.0, roughness=0.0, coat_weight=1.0, coat_roughness=roughness, **below)
        weight = SCENE.draw_bsdf(material(closure), uniform(40_000, 11), wo=direction(mu)).weight[:, 0]
        error = 0.007 if mu > 0.08 else 0.02
        assert weight.mean() < 1 + 4 * weight.std() / np.sqrt(len(weight)) + error, below


@pytest.mark.parametrize(
    "settings, ratio",
    [
        ({"anisotropy": 0.5}, 0.5),
        ({"anisotropy": -0.75}, 4.0),
        ({"anisotropy": 1.0}, 0.01),
        ({"metallic": 1.0, "base_color": 1.0, "anisotropy": 1.0}, np.sqrt(10)),
        ({"metallic": 1.0, "base_color": 1.0, "anisotropy": 0.4}, 1 / np.sqrt(1 - 0.9 * 0.4)),
    ],
)
def test_roughness_is_stretched_along_the_tangent(settings, ratio):
    """Heitz, "Understanding the Masking-Shadowing Function" (JCGT 2014), equations 84 to 87 and 99, in the axes of the
    turned tangent. Blender's Glossy BSDF is smoother along it, its Principled BSDF rougher."""
    roughness, turn = 0.45, 0.15
    make = principled if "metallic" in settings else glossy
    index = material(make(distribution="GGX", roughness=roughness, rotation=turn, **settings))
    axes = np.array([direction(0.0, 2 * np.pi * turn), direction(0.0, 2 * np.pi * (turn + 0.25)), (0, 0, 1)])
    alpha = np.clip([roughness**2 * ratio, roughness**2 / ratio], 0, 1)

    def smith(w):
        slope2 = (alpha**2 * w[..., :2] ** 2).sum(axis=-1) / w[..., 2] ** 2
        return (np.sqrt(1 + slope2) - 1) / 2

    rng = np.random.default_rng(13)
    wo, wi = direction(0.6, 1.0), direction(rng.uniform(0.1, 1, 200), rng.uniform(0, 7, 200))
    found, _ = SCENE.evaluate_bsdf(index, wi, wo=wo)
    out, into = axes @ wo, wi @ axes.T
    half = (out + into) / np.linalg.norm(out + into, axis=1)[:, None]
    slopes2 = ((half[:, :2] / half[:, 2:] / alpha) ** 2).sum(axis=1)
    density = 1 / (np.pi * alpha.prod() * half[:, 2] ** 4 * (1 + slopes2) ** 2)
    expected = density / (4 * out[2] * (1 + smith(out) + smith(into)))
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-9)


@pytest.mark.parametrize("count", [33, 1000])
def test_any_number_of_lobes_is_sampled(count):
    """Diffuse lobes with three colors in turn, each with an equal part: none is left out, whatever their number."""
    lobes = [diffuse(tuple(np.eye(3)[k % 3]), weight=1 / count) for k in range(count)]
    index = material(*lobes)
    parts = np.bincount(np.arange(count) % 3) / count
    np.testing.assert_allclose(SCENE.shade(index)["albedo"], [parts], rtol=1e-12)
    drawn = SCENE.draw_bsdf(index, uniform(1000, 9))
    np.testing.assert_allclose(drawn.weight, np.tile(parts, (1000, 1)), rtol=1e-12)


def test_any_number_of_mirrors_is_drawn_by_their_parts():
    """Of 100 mirrors on each side of the diffuse lobe, the colored ones come as often as they weigh."""
    mirrors = [glossy(weight=0.9 / 200, roughness=0.0, color=(1.0, 1.0 - k % 2, 1.0)) for k in range(200)]
    index = material(*mirrors[:100], diffuse(weight=0.1), *mirrors[100:])
    drawn = SCENE.draw_bsdf(index, uniform(50_000, 10))
    for lobe, share in ((DIFFUSE, 0.1), (GLOSSY, 0.9)):
        seen = drawn.weight[:, 1] * (drawn.lobe == lobe)
        expected = share * (1.0 if lobe == DIFFUSE else 0.5)
        assert abs(seen.mean() - expected) < 4.5 * seen.std() / np.sqrt(len(seen))


def test_black_absorbs():
    for closure in (diffuse(0.0), glossy(0.0), transparent(0.0), diffuse(weight=0.0)):
        drawn = SCENE.draw_bsdf(material(closure), uniform(10))
        assert (drawn.lobe == 0).all() and (drawn.weight == 0).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0, 1e300])
def test_colors_out_of_range_stay_harmless(bad):
    """Constants are finite, but arithmetic in a program may overflow; negative colors count as black."""
    index = material(diffuse((min(bad, 1e300), 0.5, 0.5) if bad == bad else 0.5), glossy(0.5))
    drawn = SCENE.draw_bsdf(index, uniform(1000))
    assert np.isfinite(drawn.weight).all() and (drawn.weight >= 0).all()


@pytest.mark.parametrize("bad", ["infinite", "undefined", "negative", "huge"])
@pytest.mark.parametrize(
    "closure",
    [
        glossy(anisotropy=0.5),
        metallic(anisotropy=0.5),
        metallic(physical=True),
        sheen(),
        sheen(distribution="ASHIKHMIN"),
        subsurface(),
        subsurface(method="RANDOM_WALK_SKIN"),
        (*glass(roughness=0.5), ("film", (300.0, 1.4, 1.0, 100.0), np.ones((8, 4), np.float32))),
        principled(anisotropy=0.5, coat_weight=0.5, sheen_weight=0.5, subsurface_weight=0.5, emission_strength=1.0),
    ],
    ids=lambda closure: closure[0],
)
def test_any_operand_out_of_range_is_harmless(closure, bad):
    """What arithmetic in a program may give for one operand after the other: finite light, nothing below zero."""
    operation, operands, immediates, weight, *layers = closure
    instructions = [*layers, (operation, (weight, *operands), immediates)]
    rng = np.random.default_rng(14)
    for place in [(i, k) for i, instruction in enumerate(instructions) for k in range(len(instruction[1]))]:
        builder = ProgramBuilder()
        huge = builder.constant(1e300)
        (infinite,) = builder.emit("multiply", huge, huge)
        (undefined,) = builder.emit("multiply", infinite, builder.constant(0.0))
        wrong = {"infinite": infinite, "undefined": undefined, "negative": builder.constant(-2.0), "huge": huge}[bad]
        (normal,) = builder.emit("coordinate", immediates=("SHADING_NORMAL",))
        for i, (name, values, choices) in enumerate(instructions):
            numbers = [normal if value is NORMAL else builder.constant(value) for value in values]
            if i == place[0]:
                numbers[place[1]] = wrong
            table = isinstance(choices, np.ndarray)
            builder.emit(name, *numbers, immediates=builder.table(choices) if table else immediates_of(choices))
        index = SCENE.add_material(builder.build())
        for wo in (direction(0.5), direction(1e-6), (0, 0, 1)):
            drawn = SCENE.draw_bsdf(index, rng.random((200, 3)), wo=wo)
            value, pdf = SCENE.evaluate_bsdf(index, direction(rng.random(50), 1.0), wo=wo)
            shaded = SCENE.shade(index, wo=wo)
            for found in (drawn.weight, drawn.wi, drawn.pdf, value, pdf, shaded["albedo"]):
                assert np.isfinite(found).all(), place
            assert (drawn.weight >= 0).all() and (value >= 0).all() and (pdf >= 0).all(), place
            assert (shaded["emission"] >= 0).all(), place


@pytest.mark.parametrize("name", ROUGH)
def test_grazing_and_hidden_normals_give_no_nan_and_no_leak(name):
    """Shading normals up to a right angle off, and beyond: finite, never through an opaque surface."""
    rng = np.random.default_rng(8)
    index = material(*ROUGH[name])
    opaque = not {"glass", "refraction", "translucent", "everything", "mixed"} & set(name.split("_"))
    for k in range(300):
        wo = direction(10 ** rng.uniform(-8, 0), rng.uniform(0, 7))
        normal = direction(10 ** rng.uniform(-8, 0), rng.uniform(0, 7))
        point = {"wo": wo, "normal": normal, "geometric_normal": (0, 0, 1), "backfacing": float(k % 2)}
        drawn = SCENE.draw_bsdf(index, rng.random((64, 3)), **point)
        assert np.isfinite(drawn.wi).all() and np.isfinite(drawn.weight).all() and np.isfinite(drawn.pdf).all()
        assert (drawn.weight >= 0).all()
        if opaque:
            assert (drawn.wi[drawn.lobe != 0][:, 2] > 0).all()
        value, pdf = SCENE.evaluate_bsdf(index, -direction(rng.random(64), 1.0), **point)
        assert np.isfinite(value).all() and np.isfinite(pdf).all()
        assert not opaque or (value == 0).all()


def test_a_mirror_never_reflects_into_the_surface():
    """A normal map that would send the mirror ray below the horizon does not turn the surface black."""
    index = material(glossy(1.0, 0.0))
    for cos_o in (1e-6, 0.01, 0.2):
        for tilt in (0.2, 0.8, 1.5):
            point = {"wo": direction(cos_o), "normal": direction(np.cos(tilt), np.pi)}
            drawn = SCENE.draw_bsdf(index, uniform(3), **point)
            assert (drawn.wi[:, 2] > 0).all() and (drawn.weight == 1).all(), (cos_o, tilt)
