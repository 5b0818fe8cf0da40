"""Light by connections: closed forms for lamps, suns and skies in flat and curved space, agreement with light that
scattered rays find by chance, and the draws themselves."""

import meshes
import numpy as np
import pytest
from bentlight_native import Influence, ProgramBuilder, Spacetime, connect_sky
from scenes import (
    add,
    diffuse,
    emission,
    glass,
    glossy,
    look_at,
    material,
    new_scene,
    perspective,
    quad,
    render,
    transparent,
)
from test_render_curved import areal_radius, placed, shadow_sine
from test_render_light import z_score


def add_lamps(scene, *positions, intensity=1.0, **options):
    index = scene.add_material(material(emission((intensity,) * 3)))
    scene.set_lamps([placed(*p) for p in positions], index, **options)


def patch_radiance(scene, *, samples=1, at=(0, 0, 0), up=(0, 0, 1), side=(1, 0, 0), albedo=1.0, **settings):
    """Radiance of the diffuse patch at `at`, whose upper side is seen from near by: (64,) pixels of one
    place. max_bounces 0: direct light alone."""
    up, side = np.array(up, float), np.array(side, float)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([side, np.cross(up, side), up], axis=1)
    frame[:3, 3] = at
    add(scene, quad(1e-4, 1e-4), diffuse((albedo,) * 3), at=frame)
    eye = np.array(at) + 1e-4 * (up + 0.3 * side)
    perspective(scene, look_at(eye, at, up=np.cross(up, side)), half=1e-6)
    scene.commit()
    settings = {"max_bounces": 0, "light_threshold": 0} | settings
    channels, _ = render(scene, 8, 8, samples, names=("combined",), **settings)
    return channels["combined"][..., 0].ravel().astype(float)


# ---- Flat space ----


def test_point_lamp_in_flat_space():
    """E = I cos / d^2; a white patch sends back E / pi. No chance is left in it."""
    scene = new_scene()
    add_lamps(scene, (1, 2, 2), intensity=7.0)
    assert patch_radiance(scene) == pytest.approx(7 * (2 / 3) / 9 / np.pi, rel=1e-5)


def test_lamps_behind_the_surface_give_nothing():
    scene = new_scene()
    add_lamps(scene, (1, 2, -2), intensity=7.0)
    assert (patch_radiance(scene) == 0).all()


def test_wide_lamps_below_the_surface_are_not_drawn():
    """However near: no chance is left in the light of the other lamp."""
    scene = new_scene()
    add_lamps(scene, (1, 2, 2), intensity=7.0)
    below = np.eye(4)
    below[2, 3] = -0.01
    add(scene, quad(4, 4), emission((5, 5, 5)), at=below)
    assert patch_radiance(scene) == pytest.approx(7 * (2 / 3) / 9 / np.pi, rel=1e-5)


@pytest.mark.parametrize("threshold", [0.0, 0.01, 10.0])
def test_many_lamps_add_up(threshold):
    """Their mean, each drawn by chance, and traced by chance where it brings little: a Z-test."""
    rng = np.random.default_rng(3)
    places = rng.uniform(-3, 3, (40, 3)) + np.array([0, 0, 3.5])
    scene = new_scene()
    add_lamps(scene, *places, intensity=2.0)
    distance = np.linalg.norm(places, axis=1)
    exact = (2.0 * places[:, 2] / distance**3).sum() / np.pi
    values = patch_radiance(scene, samples=256, light_threshold=threshold)
    assert abs(z_score(values, exact)) < 4


def grid(steps):
    """The square of `quad()` in 2 steps^2 triangles."""
    line = np.linspace(-1, 1, steps + 1, dtype=np.float32)
    vertices = np.stack([*np.meshgrid(line, line), np.zeros((steps + 1, steps + 1), np.float32)], axis=-1).reshape(
        -1, 3
    )
    first = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).reshape(-1, 1)
    faces = [first + corners for corners in ([0, 1, steps + 2], [0, steps + 2, steps + 1])]
    return vertices, np.concatenate(faces).astype(np.uint32)


@pytest.mark.parametrize("bent", [False, True])
def test_a_square_of_many_triangles(bent):
    """205,000 shining triangles, drawn one by one: in flat space they bring what the square's form factor says, and in
    bent space what two large triangles bring."""
    radiance, distance = 3.0, 1.5
    lit = {}
    for steps in (320, 1):
        scene = new_scene()
        below = placed(0, 0, distance) @ np.diag([1, -1, -1, 1.0])
        add(scene, grid(steps), emission((radiance,) * 3), at=below, one_sided=True)
        if bent:
            scene.set_spacetime(Spacetime.schwarzschild(0.02), placed(0.4, 0.1, 0.7))
        lit[steps] = patch_radiance(scene, samples=256, light_sampling="BOTH" if bent else "CONNECTIONS")
    half = 1 / distance
    exact = radiance * 4 / np.pi * half / np.hypot(1, half) * np.arctan(half / np.hypot(1, half))
    if not bent:
        assert all(abs(z_score(values, exact)) < 4 for values in lit.values()), exact
    assert abs(z_score(lit[320] - lit[1], 0)) < 4
    assert all(values.std() / 8 < 0.01 * exact for values in lit.values())


@pytest.mark.parametrize("angle", [0.0, 1e-3, 1.0])
def test_sun(angle):
    """A sun of irradiance E at 60 degrees: E cos / pi, exactly where it is a point."""
    scene = new_scene()
    direction = (np.sqrt(3) / 2, 0, 0.5)
    solid = np.pi * np.sin(angle / 2) ** 2 if angle else 1.0
    scene.set_suns([direction], [(3 / solid,) * 3], angle)
    values = patch_radiance(scene, samples=64)
    exact = 3 * 0.5 / np.pi
    assert values == pytest.approx(exact, rel=1e-5) if angle == 0 else abs(z_score(values, exact)) < 4


def checkered_sky(bright):
    """A sky of radiance 0.1 and `bright` by octants of a checker: its program, and its radiance as a function."""
    builder = ProgramBuilder()
    vector = builder.emit("coordinate", immediates=["GENERATED"])[0]
    colors = [builder.constant((value,) * 3) for value in (0.1, bright)]
    color = builder.emit("checker", vector, *colors, builder.constant(2.0))[0]
    builder.emit("emission", builder.constant(1), color, builder.constant(1))

    def radiance(directions):
        odd = np.floor(2 * directions).sum(axis=-1) % 2 != 0
        return np.where(odd, 0.1, bright)

    return builder.build(), radiance


def test_uneven_sky():
    """Irradiance of a tilted patch by a checkered sky against quadrature over its hemisphere."""
    program, radiance = checkered_sky(5.0)
    scene = new_scene()
    scene.set_world(program)
    up, side = np.array([0.48, 0.6, 0.64]), np.array([0.8, 0.0, -0.6])
    steps = (np.arange(2000) + 0.5) / 2000
    cosine2, turn = np.meshgrid(steps, 2 * np.pi * steps)
    sine, ahead = np.sqrt(1 - cosine2), np.cross(up, side)
    parts = (sine * np.cos(turn), side), (sine * np.sin(turn), ahead), (np.sqrt(cosine2), up)
    directions = sum(length[..., None] * axis for length, axis in parts)
    exact = radiance(directions).mean()
    for sampling in ("CONNECTIONS", "BOTH"):
        values = patch_radiance(scene, samples=256, up=up, side=side, light_sampling=sampling)
        assert abs(z_score(values, exact)) < 4, sampling


@pytest.mark.parametrize("x", [-1e-4, 1e-4])
def test_shadow_of_an_edge(x):
    """A screen at half the lamp's height ends at x = 0: the lamp at 2 x is hidden from the patch just where x < 0."""
    scene = new_scene()
    add(scene, quad(5, 5), diffuse((0, 0, 0)), at=placed(-5, 0, 1))
    add_lamps(scene, (2 * x, 0, 2))
    assert ((patch_radiance(scene) > 0) == (x > 0)).all()


def test_transparent_shadow():
    """Light through two panes of transmittance 0.5 and 0.4; one of three is too many for 2 transparent bounces."""
    for panes, factor in [(1, 0.5), (2, 0.2), (3, 0.0)]:
        scene = new_scene()
        for i, color in enumerate([0.5, 0.4, 0.9][:panes]):
            add(scene, quad(5, 5), transparent((color,) * 3), at=placed(0, 0, 0.3 + 0.1 * i))
        add_lamps(scene, (0, 0, 2))
        values = patch_radiance(scene, transparent_bounces=2)
        assert values == pytest.approx(factor / 4 / np.pi, rel=1e-5), panes


def test_shadowless():
    """A lamp without shadows shines through a wall; an object that casts none does not hide a lamp."""
    for blockers, wall, lit in [(2**64 - 1, 15, 0), (0, 15, 1), (2**64 - 1, 15 + 32, 1)]:
        scene = new_scene()
        add(scene, quad(5, 5), diffuse((0.5,) * 3), at=placed(0, 0, 1), visibility=wall)
        add_lamps(scene, (0, 0, 2), influence=Influence(blockers=blockers))
        assert patch_radiance(scene) == pytest.approx(lit / 4 / np.pi, rel=1e-5), (blockers, wall)


# ---- Around a hole ----


def annulus(inner, outer, sides):
    """A flat ring around the z axis."""
    angle = np.arange(sides) * 2 * np.pi / sides
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = np.concatenate([np.stack([i, i + sides, j + sides], 1), np.stack([i, j + sides, j], 1)])
    return np.concatenate([inner * circle, outer * circle]).astype(np.float32), faces.astype(np.uint32)


@pytest.mark.parametrize("u", [0.3, 1.0, 2.0])
def test_lamp_behind_a_hole(u):
    """The lens equation's total magnification (u^2 + 2) / (u sqrt(u^2 + 4)) (Einstein 1936), u the lamp's angle from
    the hole in Einstein radii. A patch that faces a tiny hole half-way; corrections are of the order of 1e-4."""
    mass, distance = 1e-8, 1.0
    ring = np.sqrt(4 * mass / (2 * distance))  # angular, for a lens half-way to a lamp at 2
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(mass), placed(0, 0, distance))
    add_lamps(scene, (2 * distance * ring * u, 0, 2 * distance))
    exact = (u**2 + 2) / (u * np.sqrt(u**2 + 4)) / (2 * distance) ** 2 / np.pi
    assert patch_radiance(scene, samples=64).mean() == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("u", [0.3, 1.5])
def test_transparent_shadows_of_two_images(u):
    """Magnifications (u^2 + 2) / (2 u sqrt(u^2 + 4)) +- 1/2 (Einstein 1936), each image dimmed by a pane of its own."""
    mass, distance = 1e-8, 1.0
    ring = np.sqrt(4 * mass / (2 * distance))
    scene = new_scene()
    scene.set_spacetime(Spacetime.schwarzschild(mass), placed(0, 0, distance))
    add_lamps(scene, (2 * distance * ring * u, 0, 2 * distance))
    for side, color in [(1, 0.5), (-1, 0.8)]:
        add(scene, quad(5, 5), transparent((color,) * 3), at=placed(5 * side, 0, 0.9 * distance))
    mean = (u**2 + 2) / (2 * u * np.sqrt(u**2 + 4))
    exact = (0.5 * (mean + 0.5) + 0.8 * (mean - 0.5)) / (2 * distance) ** 2 / np.pi
    assert patch_radiance(scene, samples=64).mean() == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("name", ["isotropic", "areal", "spinning"])
def test_transparent_shadow_of_a_ball_around_a_hole(name):
    """What goes around the hole crosses the ball twice, on any curve; a lamp inside of it shines through it once."""
    for lamp, factor in [((0.05, 0.3, 4), 0.36), ((0.05, 0.3, 1), 0.6)]:
        lit = []
        for has_ball in (False, True):
            scene = new_scene()
            scene.set_spacetime(SPACETIMES[name])
            if has_ball:
                add(scene, meshes.sphere(2.0), transparent((0.6, 0.6, 0.6)))
            add_lamps(scene, lamp)
            lit.append(patch_radiance(scene, at=(0, 0, -4), samples=4))
        assert (lit[0] > 0).all() and lit[1] == pytest.approx(factor * lit[0], rel=1e-5), lamp


def test_hole_in_a_screen_lets_nothing_through():
    """A screen around the hole with an opening smaller than the critical impact parameter: what aims at the opening
    falls in, so a lamp exactly behind it, and beside it, gives no light. Without the hole it shines through."""
    for mass, lit in [(0.1, False), (0.0, True)]:
        scene = new_scene()
        scene.set_spacetime(Spacetime.schwarzschild(mass))
        add(scene, annulus(0.3, 20.0, 256), diffuse((0, 0, 0)))
        add_lamps(scene, (0.05, 0, 4))
        values = patch_radiance(scene, at=(0, 0, -4), up=(0, 0, 1))
        assert (values > 0).all() if lit else (values == 0).all()


@pytest.mark.parametrize(("light", "albedo"), [("suns", 1.0), ("world", 0.4)])
@pytest.mark.parametrize("factor", [2.1, 2.5, 2.9, 3.1, 4.0, 10.0])
def test_patch_near_a_hole_under_an_even_sky(factor, light, albedo):
    """A sky of radiance 1, or two suns that fill it. Inside the photon sphere a patch that faces outward sees the sky
    in a cone of half-angle chi, outside one that faces inward sees a shadow of half-angle psi; both have the sine of
    Synge (1966). Irradiance over pi: sin^2(chi), or 1 - sin^2(psi)."""
    mass = 0.5
    r = factor * mass
    isotropic = (r - mass + np.sqrt(r * (r - 2 * mass))) / 2
    assert areal_radius(isotropic, mass) == pytest.approx(r)
    share = shadow_sine(r, mass) ** 2
    for sampling in ("CONNECTIONS", "BOTH", "SCATTERING"):
        scene = new_scene()
        scene.set_spacetime(Spacetime.schwarzschild(mass))
        if light == "suns":
            scene.set_suns([(1, 1, 1), (-1, -1, -1)], np.ones((2, 3)), np.pi)
        else:
            scene.set_world(material(emission((1, 1, 1))))
        up = (0, 0, 1) if factor < 3 else (0, 0, -1)
        values = patch_radiance(
            scene, samples=128, at=(0, 0, isotropic), up=up, albedo=albedo, light_sampling=sampling, tolerance=1e-5
        )
        exact = albedo * (share if factor < 3 else 1 - share)
        # from the third image on, connections are cut at a share of 1e-4
        assert abs(values.mean() - exact) < 4 * values.std(ddof=1) / np.sqrt(values.size) + 1e-4, sampling


@pytest.mark.parametrize("radius", [1.2, 2.0, 5.0, 50.0])
def test_images_of_a_lamp_keep_its_energy(radius):
    """A lamp's light that all places of the sky receive by all images together is what does not fall into the hole: the
    integral of the sum of 1 / spread over the sky is 4 pi less the shadow's solid angle (Synge 1966)."""
    mass = 0.5
    r = areal_radius(radius, mass)
    edge = np.arcsin(shadow_sine(r, mass))
    edge = edge if r > 3 * mass else np.pi - edge
    x, weight = np.polynomial.legendre.leggauss(200)
    angle = (x + 1) * np.pi / 2
    sky = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    places = np.tile([0, 0, radius], (len(angle), 1))
    images = connect_sky(Spacetime.schwarzschild(mass), places, sky, max_images=8, tolerance=1e-10)
    received = (2 * np.pi * np.sin(angle) * np.nansum(1 / images["spread"], axis=1) * weight).sum() * np.pi / 2
    assert received == pytest.approx(4 * np.pi - 2 * np.pi * (1 - np.cos(edge)), rel=1e-9)


# ---- Against chance ----

SPACETIMES = {
    "flat": None,
    "isotropic": Spacetime.schwarzschild(0.1),
    "areal": Spacetime.schwarzschild(0.1, "areal"),
    "wormhole": Spacetime.ellis(0.3),
    "spinning": Spacetime.kerr(0.15, 0.14),
}
MATERIALS = {
    "diffuse": diffuse((0.8, 0.5, 0.2)),
    "metal": glossy((0.9, 0.9, 0.9), 0.4),
    "glass": glass((1, 1, 1), 0.5, 1.5),
}


def room(spacetime, *closures):
    """A floor, a ball, a lamp overhead and a glowing ball beside it, and a sun, around a hole or wormhole."""
    scene = new_scene()
    add(scene, quad(3, 3), *closures)
    add(scene, meshes.sphere(0.4, segments=16, rings=8), *closures, at=placed(-1, 0.3, 0.5))
    lamp = np.diag([0.3, -0.3, -0.3, 1.0])
    lamp[:3, 3] = 0.4, 0.2, 2.0
    add(scene, quad(), emission((5, 5, 5)), at=lamp)
    add(scene, meshes.sphere(0.15, segments=8, rings=4), emission((2, 1, 4)), at=placed(1.2, -0.4, 0.4))
    scene.set_suns([(0.3, -0.5, 1)], [(20, 18, 15)], 0.3)
    if spacetime is not None:
        scene.set_spacetime(spacetime, placed(0, 0, 1.0))
    perspective(scene, look_at((0, -5, 3), (0, 0, 0.5)), half=0.4)
    scene.commit()
    return scene


@pytest.mark.parametrize("closures", MATERIALS)
@pytest.mark.parametrize("spacetime", SPACETIMES)
def test_all_ways_to_find_light_agree(spacetime, closures):
    """Chance, connections and both have the same mean: a Z-test of the picture's mean over independent seeds."""
    scene = room(SPACETIMES[spacetime], MATERIALS[closures])
    means, noise = {}, {}
    for sampling, samples in [("SCATTERING", 64), ("CONNECTIONS", 16), ("BOTH", 16)]:
        settings = {"light_sampling": sampling, "max_bounces": 3, "roulette_start": 9, "names": ("combined",)}
        runs = [render(scene, 16, 16, samples, seed=s, **settings)[0]["combined"][..., :3].mean() for s in range(24)]
        means[sampling] = np.mean(runs, dtype=float), np.var(runs, ddof=1) / len(runs)
        noise[sampling] = np.var(runs, ddof=1) * samples
    for sampling in ("CONNECTIONS", "BOTH"):
        (a, va), (b, vb) = means["SCATTERING"], means[sampling]
        assert abs(a - b) < 4 * np.sqrt(va + vb), (sampling, means)
    assert noise["BOTH"] < noise["SCATTERING"]


@pytest.mark.parametrize("spacetime", [*SPACETIMES, "pair"])
def test_furnace(spacetime):
    """Walls that emit 1/2 and reflect 1/2 have radiance 1 wherever light is not lost, also through a wormhole."""
    scene = new_scene()
    if spacetime == "pair":
        a, b = placed(-3, 0, 0), placed(3, 0.5, 0)
        scene.set_spacetime_objects([(Spacetime.ellis(0.5), a, 2.0, 1), (Spacetime.ellis(0.5), b, 2.0, 0)])
    elif SPACETIMES[spacetime] is not None:
        scene.set_spacetime(SPACETIMES[spacetime])
    if spacetime == "wormhole":
        scene.set_world(material(emission((1, 1, 1))))
    add(scene, meshes.sphere(8.0), diffuse((0.5,) * 3), emission((0.5,) * 3))
    perspective(scene, look_at((-3, -4, 0), (-3, 0, 0)), half=0.6)
    scene.commit()
    settings = {"max_bounces": 60, "diffuse_bounces": 60, "roulette_start": 60, "names": ("combined",)}
    if spacetime in ("isotropic", "areal", "spinning"):  # the hole takes light: chance is the measure
        exact = render(scene, 16, 16, 32, light_sampling="SCATTERING", **settings)[0]["combined"][..., 0]
        both = render(scene, 16, 16, 32, **settings)[0]["combined"][..., 0]
        difference = (both - exact).astype(float)
        assert abs(z_score(difference, 0)) < 4
    else:
        assert abs(z_score(render(scene, 24, 24, 16, **settings)[0]["combined"][..., 0], 1)) < 4


@pytest.mark.unsanitized
def test_small_lights_beside_a_spinning_hole():
    """Where dragging is strong, chance and connections agree: surfaces at rest in the scene move past the ZAMO."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.kerr(0.25, 0.24), placed(0, 0, 0.8))
    add(scene, quad(1.5, 1.5), diffuse((0.8,) * 3))
    for sign in (-1, 1):
        side = np.array([[0, 0, sign, 0], [0, 1, 0, 0], [-sign, 0, 0, 0], [0, 0, 0, 1.0]])
        at = placed(0.75 * sign, 0.1, 0.8) @ side @ np.diag([0.15, 0.15, 0.15, 1])
        add(scene, quad(), emission((10.0 + sign, 0, 5 - 5 * sign)), at=at)
    perspective(scene, look_at((0, -3, 3), (0, 0, 0.2)), half=0.4)
    scene.commit()
    settings = {"max_bounces": 1, "roulette_start": 9, "names": ("combined",)}
    settings["tile"] = (0, 8, 16, 8)  # the half of the picture that is compared
    sums = {}
    for sampling, samples in [("SCATTERING", 512), ("CONNECTIONS", 24), ("BOTH", 24)]:
        pictures = [render(scene, 16, 16, samples, seed=s, light_sampling=sampling, **settings)[0] for s in range(10)]
        runs = [picture["combined"][..., ::2].mean((0, 1)) for picture in pictures]
        sums[sampling] = np.mean(runs, 0, dtype=float), np.var(runs, 0, ddof=1, dtype=float) / len(runs)
    for sampling in ("CONNECTIONS", "BOTH"):
        (a, va), (b, vb) = sums["SCATTERING"], sums[sampling]
        assert np.all(va < (0.01 * a) ** 2)
        assert np.all(np.abs(a - b) < 4 * np.sqrt(va + vb)), (sampling, sums)


def test_light_after_many_bounces_beside_a_spinning_hole():
    """Where joining is slow, deep vertices are joined by chance, and first images far from the hole weigh by an
    estimate: the mean is that of chance alone. Bright walls on five sides, so that most light is indirect."""
    scene = new_scene()
    scene.set_spacetime(Spacetime.kerr(0.04, 0.036))
    closures = [diffuse((0.85, 0.8, 0.6)), glossy((0.1, 0.1, 0.1), 0.3)]
    for axis in np.vstack([np.eye(3), -np.eye(3)])[:5]:
        across = np.roll(axis, 1)
        at = np.eye(4)
        at[:3, :3] = np.stack([1.5 * across, 1.5 * np.cross(-axis, across), -1.5 * axis], 1)
        at[:3, 3] = 1.5 * axis
        add(scene, quad(), *closures, at=at)
    lamp = np.diag([0.5, -0.5, -0.5, 1.0])
    lamp[:3, 3] = 0.2, 0.3, 1.4
    add(scene, quad(), emission((3, 4, 5)), at=lamp)
    perspective(scene, look_at((0, 0.4, -1.4), (0, 0.2, 1)), half=0.6)
    scene.commit()
    settings = {"max_bounces": 7, "diffuse_bounces": 7, "roulette_start": 9, "names": ("combined",)}
    sums = {}
    for sampling, samples in [("SCATTERING", 48), ("CONNECTIONS", 24), ("BOTH", 24)]:
        pictures = [render(scene, 16, 16, samples, seed=s, light_sampling=sampling, **settings)[0] for s in range(16)]
        runs = [picture["combined"][..., :3].mean((0, 1), dtype=float) for picture in pictures]
        sums[sampling] = np.mean(runs, 0), np.var(runs, 0, ddof=1) / len(runs)
    for sampling in ("CONNECTIONS", "BOTH"):
        (a, va), (b, vb) = sums["SCATTERING"], sums[sampling]
        assert np.all(np.sqrt(va + vb) < 0.01 * a)
        assert np.all(np.abs(a - b) < 4 * np.sqrt(va + vb)), (sampling, sums)


# ---- The draws ----


def shining_scene(bent):
    """Three balls, a square, two lamps and two suns; returns the scene and the world corners (3, 3) of all triangles by
    instance and number."""
    rng = np.random.default_rng(11)
    scene = new_scene()
    if bent:
        scene.set_spacetime(Spacetime.schwarzschild(0.1))
    tilted = np.array([[0.3, 0, -0.2, 1], [0, -0.5, 0, -1], [0.2, 0, -0.3, 2], [0, 0, 0, 1.0]])
    ball = meshes.sphere(0.3, segments=8, rings=4)
    corners = {}
    for k in range(4):
        at, mesh = (tilted, quad()) if k == 3 else (placed(*rng.uniform(-2, 2, 3)), ball)
        color = (4, 4, 4) if k == 3 else (1.0 + k, 1, 0.2)
        instance = add(scene, mesh, emission(color), at=at, one_sided=k == 3)
        for number, triangle in enumerate(mesh[1]):
            corners[instance, number] = mesh[0][triangle] @ at[:3, :3].T + at[:3, 3]
    add_lamps(scene, (1, 1, 1), (-2, 0, 0.5), intensity=2.0)
    scene.set_suns([(0, 0, 1), (1, 0, 0)], [(0.2, 0.2, 0.2), (0.1, 0.1, 0.1)], [0.5, 0.0])
    scene.commit()
    return scene, corners


def quarter(places, corner):
    """Which of the four congruent parts of a triangle each place lies in."""
    edges = (corner[1:] - corner[0]).T
    b = np.linalg.lstsq(edges, (places - corner[0]).T, rcond=None)[0]
    return np.argmax([np.full(len(places), 0.5), 1 - b[0] - b[1], b[0], b[1]], axis=0)


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize(
    ("point", "normal"), [((0, 0, 0.7), (0, 0, 1)), ((0.5, 0.3, -1), (0.6, 0, 0.8)), ((-5, 3, 2), (0, 0, 0))]
)
def test_draws_follow_their_probabilities(bent, point, normal):
    """Chi-square of 2e5 draws: lamps and suns are drawn as often as is said, and of triangles every quarter has its
    share of the sum of 1 / density. What weighs against scattering is looked up as it was drawn."""
    scene, corners = shining_scene(bent)
    n = 200000
    u = np.random.default_rng(12).random((n, 4))
    which, target, probability = scene.draw_lights(np.tile(point, (n, 1)), np.tile(normal, (n, 1)), u)
    assert probability[:, 2] == pytest.approx(probability[:, 1], rel=1e-9)
    z = []
    for row in np.unique(which, axis=0):
        chosen = (which == row).all(axis=1)
        drawn, places = probability[chosen, 0], target[chosen]
        if row[0] in (1, 2):
            z.append((chosen.sum() - n * drawn[0]) / np.sqrt(n * drawn[0] * (1 - drawn[0])))
        elif row[0] == 0 and chosen.sum() > 1000:
            part = quarter(places, corners[row[1], row[2]])
            for q in range(4):
                sums = [(drawn[part == q] ** -k).sum() for k in (1, 2)]
                z.append((sums[0] - n / 4) / np.sqrt(sums[1] - n / 16))
    assert len(z) >= 4 and max(np.abs(z)) < 5 and abs(np.square(z).mean() - 1) < 5 * np.sqrt(2 / len(z)), z


def test_draws_of_the_sky():
    """The mean of 1 / pdf over draws in a part of the sky is its solid angle: here 16 x 16 equal parts."""
    scene = new_scene()
    scene.set_world(checkered_sky(5.0)[0])
    scene.commit()
    n = 200000
    u = np.random.default_rng(5).random((n, 4))
    which, direction, pdf = scene.draw_lights(np.zeros((n, 3)), np.zeros((n, 3)), u)
    assert (which[:, 0] == 3).all() and np.linalg.norm(direction, axis=1) == pytest.approx(1)
    assert pdf[:, 1] == pytest.approx(pdf[:, 0], rel=1e-6)
    row = np.floor((direction[:, 2] + 1) * 8 * (1 - 1e-12))
    column = np.floor((np.arctan2(direction[:, 1], direction[:, 0]) / np.pi + 1) * 8 * (1 - 1e-12))
    part = (16 * row + column).astype(int)
    sums, squares = (np.bincount(part, weights=pdf[:, 0] ** -k, minlength=256) for k in (1, 2))
    error = np.sqrt(squares - sums**2 / n)
    z = (sums - n * 4 * np.pi / 256) / error
    assert abs(z).max() < 5 and abs((z**2).mean() - 1) < 5 * np.sqrt(2 / 256)
