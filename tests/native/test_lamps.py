"""What makes an instance a lamp: where it shines, whom it lights, and that it is no body. Against closed forms: exactly
where a path tells, else by a Z-test."""

import meshes
import numpy as np
import pytest
from bentlight_native import Influence, ProgramBuilder, Spacetime
from scenes import add, diffuse, emission, look_at, material, new_scene, perspective, quad, render

SAMPLINGS = ("BOTH", "SCATTERING", "CONNECTIONS")
IMMATERIAL, SHADOWLESS = 128, 32
ALL = 2**64 - 1
ALBEDO = 0.5
CEILING = np.diag([1.0, -1.0, -1.0, 1.0])  # turned over, facing down


def z_score(values, exact):
    values = np.asarray(values, float).ravel()
    return (values.mean() - exact) / (values.std(ddof=1) / np.sqrt(values.size))


def at_height(z, turned=False, scale=1.0):
    matrix = (CEILING if turned else np.eye(4)) @ np.diag([scale, scale, scale, 1.0])
    matrix[2, 3] = z
    return matrix


def floor(scene, **instance):
    return add(scene, quad(20, 20), diffuse((ALBEDO,) * 3), **instance)


def look_at_floor(scene):
    """A hair-thin view of the origin, from the side."""
    perspective(scene, look_at((3, -4, 2), (0, 0, 0)), half=1e-4)


def floor_radiance(scene, samples=64, **settings):
    """(256,) independent estimates."""
    settings = {"max_bounces": 0} | settings
    return render(scene, 16, 16, samples, names=("combined",), **settings)[0]["combined"][..., 0].ravel()


def square_factor(x):
    """Configuration factor from under the middle of a square of half side x times its height (Howell, B-4)."""
    return 4 / np.pi * x / np.hypot(1, x) * np.arctan(x / np.hypot(1, x))


def lamp_program(*factors, radiance=1.0):
    """An emission times the outputs of operations (name, operands, immediates)."""
    builder = ProgramBuilder()
    weight = builder.constant(1.0)
    for name, operands, immediates in factors:
        (factor,) = builder.emit(name, *map(builder.constant, operands), immediates=immediates)
        (weight,) = builder.emit("multiply", weight, factor)
    builder.emit("emission", weight, builder.constant(radiance), builder.constant(1.0))
    return builder.build()


def add_sphere_lamp(scene, radius, height, soft, radiance):
    """A polyhedron of the surface area, and so of the mean outline, of a sphere."""
    vertices, triangles = meshes.sphere(segments=64, rings=32)
    corners = vertices[triangles].astype(float)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    grown = (vertices * np.sqrt(4 * np.pi / area)).astype(np.float32)
    mesh = scene.add_mesh(grown, triangles, corner_normals=np.ascontiguousarray(vertices[triangles], np.float32))
    program = lamp_program(("sphere_lamp", [radius], ["ON" if soft else "OFF"]), radiance=radiance)
    materials = np.array([scene.add_material(program)], np.int32)
    at = np.diag([radius, radius, radius, 1.0])
    at[2, 3] = height
    return scene.add_instance(mesh, at, materials=materials, visibility=14 | IMMATERIAL)


# ---- A lamp is no body ----


def test_rays_go_through_an_immaterial_lamp_and_gather_its_light():
    scene = new_scene((0, 0, 0.25))
    for z in (-1.0, -2.0):
        add(scene, quad(), emission((1, 0.5, 0)), at=at_height(z), visibility=15 | IMMATERIAL)
    perspective(scene, half=0.2)
    scene.commit()
    channels, _ = render(scene, samples=1, max_bounces=0)
    assert (channels["combined"] == (2, 1, 0.25, 1)).all()
    assert (channels["emission"] == (2, 1, 0)).all() and (channels["environment"] == (0, 0, 0.25)).all()
    assert (channels["fate"] == 1).all() and (channels["depth"] == 1e10).all()
    channels, _ = render(scene, samples=1, max_bounces=0, transparent_bounces=1)
    assert (channels["combined"] == (2, 1, 0, 1)).all()  # counted as transparent surfaces


def test_what_an_immaterial_lamp_does_not_light_is_not_counted():
    """Passing where it is dark costs nothing."""
    scene = new_scene((1, 1, 1))
    for z in range(1, 20):
        add(scene, quad(), emission((0, 0, 0)), at=at_height(-z), visibility=15 | IMMATERIAL)
    perspective(scene, half=0.02)
    scene.commit()
    assert (render(scene, samples=1, max_bounces=0)[0]["combined"] == 1).all()


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_immaterial_lamps_cast_no_shadows_on_each_other(sampling):
    """The square on top shines through the one below."""
    scene = new_scene()
    floor(scene)
    for z in (1.0, 1.3):
        add(scene, quad(), emission((1, 1, 1)), at=at_height(z, True), one_sided=True, visibility=14 | IMMATERIAL)
    look_at_floor(scene)
    scene.commit()
    exact = ALBEDO * (square_factor(1.0) + square_factor(1 / 1.3))
    assert abs(z_score(floor_radiance(scene, 256, light_sampling=sampling), exact)) < 4


# ---- Shadows: of instances, and of lights ----


def test_shadowless_is_of_the_instance_that_casts_not_of_the_one_that_shines():
    """A black screen before a lamp: shadowless, connections pass it; a shadowless lamp still has shadows."""

    def lit(screen, lamp):
        scene = new_scene()
        floor(scene)
        at = np.eye(4)
        at[2, 3] = 2
        scene.set_lamps([at], scene.add_material(material(emission((1, 1, 1)))))
        add(scene, quad(3, 3), diffuse((0, 0, 0)), at=at_height(1), visibility=14 | screen)
        add(scene, quad(0.5, 0.5), emission((1, 1, 1)), at=at_height(1.5, True), visibility=14 | lamp)
        look_at_floor(scene)
        scene.commit()
        return floor_radiance(scene, 16, light_sampling="CONNECTIONS").mean()

    assert lit(0, 0) == lit(0, SHADOWLESS) == 0
    quad_only = 0.1  # about what the quad gives; the point gives ALBEDO / pi / 4
    assert lit(SHADOWLESS, 0) > quad_only * ALBEDO / np.pi
    assert lit(SHADOWLESS, SHADOWLESS) > lit(SHADOWLESS, 0)  # the quad hides the point lamp above it


@pytest.mark.parametrize("emitter", ["lamp", "sun", "point of sun", "quad"])
def test_a_light_that_nothing_holds_up(emitter):
    """Without blockers, the floor is as bright behind a screen as without one; with all, it is black."""

    def radiance(screen, blockers):
        scene, influence = new_scene(), Influence(blockers=blockers)
        floor(scene)
        if emitter == "lamp":
            program = material(emission((1, 1, 1)))
            scene.set_lamps([at_height(2)], scene.add_material(program), influence=influence)
        elif emitter == "quad":
            light = emission((1, 1, 1))
            add(scene, quad(), light, at=at_height(2, True), visibility=14, influence=influence)
        else:
            scene.set_suns([(0, 0.3, 1)], [(1, 1, 1)], 0.2 if emitter == "sun" else 0.0, influence=influence)
        if screen:
            add(scene, quad(9, 9), diffuse((0, 0, 0)), at=at_height(1), visibility=14)
        look_at_floor(scene)
        scene.commit()
        return floor_radiance(scene)

    free = radiance(False, ALL)
    assert free.mean() > 0
    assert (radiance(True, ALL) == 0).all()
    passed = radiance(True, 0)
    error = np.hypot(free.std(ddof=1), passed.std(ddof=1)) / 16
    assert abs(passed.mean() - free.mean()) <= 4 * error + 1e-6 * free.mean()


# ---- Influence ----


def test_blockers_hold_up_the_light_of_those_who_name_them():
    """Two lamps of red and green light; the screen is in set 5, which only the green lamp names."""
    scene = new_scene()
    floor(scene)
    add(scene, quad(9, 9), diffuse((0, 0, 0)), at=at_height(1), visibility=14, blocker_set=5)
    colors = [scene.add_material(material(emission(color))) for color in ((1, 0, 0), (0, 1, 0))]
    blockers = [Influence(blockers=ALL & ~(1 << 5)), Influence(blockers=1 << 5)]
    scene.set_lamps([at_height(2)] * 2, colors, influence=blockers)
    look_at_floor(scene)
    scene.commit()
    pixels = render(scene, 8, 8, 16, names=("combined",), max_bounces=0)[0]["combined"]
    assert pixels[..., 0].mean() == pytest.approx(ALBEDO / np.pi / 4, rel=0.2) and (pixels[..., 1] == 0).all()


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("emitter", ["quad", "sun"])
def test_receivers_are_those_that_a_light_names(emitter, sampling):
    """Half of the floor is in set 63, which the light leaves out; the camera sees the light all the same."""
    scene, others = new_scene(), Influence(receivers=ALL >> 1)
    for x, receiver_set in ((-5, 63), (5, 0)):
        at = np.eye(4)
        at[0, 3] = x
        add(scene, quad(5, 5), diffuse((ALBEDO,) * 3), at=at, receiver_set=receiver_set)
    if emitter == "quad":
        add(scene, quad(2, 2), emission((1, 1, 1)), at=at_height(1, True), influence=others)
    else:
        scene.set_suns([(0, 0, 1)], [(1, 1, 1)], 1.0, influence=others)
    for x, seen in ((-1.0, False), (1.0, True)):
        perspective(scene, look_at((x, -6, 0.5), (x, 0, 0)), half=1e-4)
        scene.commit()
        assert (floor_radiance(scene, light_sampling=sampling).mean() > 0) == seen
    perspective(scene, look_at((-1, 0, 0.1), (-1, 1e-6, 1)), half=1e-4)
    scene.commit()
    assert (floor_radiance(scene, 1, light_sampling=sampling) == 1).all()


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_a_light_stops_at_its_bounces(sampling):
    """In a closed white sphere with a glowing wall each scattering adds half as much."""
    for max_bounces in (0, 1, 3):
        scene = new_scene()
        grey = (0.5, 0.5, 0.5)
        add(scene, meshes.sphere(), diffuse(grey), emission(grey), influence=Influence(max_bounces=max_bounces))
        perspective(scene, look_at((0.3, 0.2, 0.1), (0, 0, 0)))
        scene.commit()
        limits = dict.fromkeys(("max_bounces", "diffuse_bounces", "roulette_start"), 30)
        values = floor_radiance(scene, 16, light_sampling=sampling, **limits)
        exact = 1 - 0.5 ** (max_bounces + 2)
        if sampling == "SCATTERING":
            assert values == pytest.approx(exact, rel=1e-6)
        else:
            assert abs(z_score(values, exact)) < 4


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_clamp_indirect_leaves_direct_light(sampling):
    """Light that is scattered once is not cut, that of a second scattering is: here to nearly nothing."""
    scene = new_scene()
    add(scene, meshes.sphere(), diffuse((0.5,) * 3), emission((1, 1, 1)))
    perspective(scene, look_at((0.3, 0.2, 0.1), (0, 0, 0)))
    scene.commit()
    limits = dict.fromkeys(("max_bounces", "diffuse_bounces", "roulette_start"), 5)
    values = floor_radiance(scene, 64, light_sampling=sampling, clamp_indirect=1e-6, **limits)
    assert values.mean() == pytest.approx(1.5, rel=0.02)


def test_bad_influences_are_refused():
    scene = new_scene()
    mesh = scene.add_mesh(*quad())
    with pytest.raises(ValueError, match="below 64"):
        scene.add_instance(mesh, np.eye(4), receiver_set=64)
    with pytest.raises(ValueError, match="below 64"):
        scene.add_instance(mesh, np.eye(4), blocker_set=99)
    with pytest.raises(TypeError, match="influence"):
        scene.add_instance(mesh, np.eye(4), influence=3)
    with pytest.raises(ValueError, match="influence"):
        scene.set_suns([(0, 0, 1)], [(1, 1, 1)], 0.1, influence=[Influence()] * 2)
    with pytest.raises(TypeError, match="influence"):
        scene.set_lamps([np.eye(4)], 0, influence=[None])


# ---- Where lamps shine ----


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("radius", [0.3, 0.9, 3.0])
@pytest.mark.parametrize("soft", [False, True])
def test_irradiance_under_a_sphere(soft, radius, sampling):
    """At distance 1: of a sphere pi L r^2, or pi L from inside; of the soft one's disk pi L r^2 / (1 + r^2)."""
    scene = new_scene()
    floor(scene)
    add_sphere_lamp(scene, radius, 1.0, soft, radiance=1.0)
    look_at_floor(scene)
    scene.commit()
    exact = ALBEDO * (radius**2 / (1 + radius**2) if soft else min(radius, 1) ** 2)
    values = floor_radiance(scene, 256, light_sampling=sampling)
    error = values.std(ddof=1) / 16
    polyhedron = 1.5e-3 * exact  # of 64 times 32 faces: how much larger or smaller than the sphere it looks from near
    assert abs(values.mean() - exact) < 4 * error + polyhedron
    assert error < 0.02 * exact


@pytest.mark.parametrize(("soft", "chart"), [(True, "isotropic"), (False, "areal")])
def test_around_a_hole_both_ways_of_finding_a_lamp_agree(soft, chart):
    """A lamp across a hole, behind a sheet of light: what scattered rays meet is what connections bring."""
    scene = new_scene()
    floor(scene)
    add_sphere_lamp(scene, 0.6, 2.0, soft, radiance=1.0)
    add(scene, quad(3, 3), emission((0.05,) * 3), at=at_height(1.3), visibility=14 | IMMATERIAL)
    at = np.eye(4)
    at[:3, 3] = 0.15, 0.1, 0.8
    scene.set_spacetime(Spacetime.schwarzschild(0.04, chart), at)
    look_at_floor(scene)
    scene.commit()
    found = [floor_radiance(scene, 96, light_sampling=sampling) for sampling in SAMPLINGS]
    for a in found[1:]:
        error = np.hypot(a.std(ddof=1), found[0].std(ddof=1)) / 16
        assert abs(a.mean() - found[0].mean()) < 4 * error
        assert error < 0.02 * a.mean()


def test_spot_cone_in_its_axes():
    """Cycles' smoothstep between the cosine of the edge and that of full strength; an ellipse where axes are scaled."""
    scene, half, blend = new_scene(), 0.6, 0.4
    edge = np.cos(half)
    index = scene.add_material(lamp_program(("spot_cone", [edge, (1 - edge) * blend, 0.0], [])))
    sharp = scene.add_material(lamp_program(("spot_cone", [edge, 0.0, 0.0], [])))
    angle = np.linspace(0, 3, 200)
    wo = np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    t = np.clip((np.cos(angle) - edge) / ((1 - edge) * blend), 0, 1)
    np.testing.assert_allclose(scene.shade(index, wo=wo)["emission"][:, 0], t * t * (3 - 2 * t), atol=1e-12)
    assert (scene.shade(sharp, wo=wo)["emission"][:, 0] == (angle < half)).all()
    wide = scene.shade(sharp, np.diag([2.0, 1.0, 1.0, 1.0]), wo=wo)["emission"][:, 0]
    assert (wide == ((np.tan(angle) < 2 * np.tan(half)) & (angle < np.pi / 2))).all()


def test_inside_a_spot_of_some_size_light_goes_away_from_the_middle():
    scene = new_scene()
    index = scene.add_material(lamp_program(("spot_cone", [np.cos(0.1), 0.0, 2.0], [])))
    for wo, length, seen in (((1, 0, 0), 2.5, 1), ((1, 0, 0), 1.5, 0), ((1, 0, 0), 4.5, 0), ((0, 0, -1), 9.0, 1)):
        point = {"position": -2 * np.array(wo, float), "wo": wo, "ray_length": (length,)}
        assert scene.shade(index, **point)["emission"][0, 0] == seen, (wo, length)


@pytest.mark.parametrize("spread", [0.1, 1.0, 3.0])
def test_spread_keeps_the_power(spread):
    """Over the hemisphere the light sums up to that of a lamp without slats: integral of f cos = pi."""
    scene, half = new_scene(), spread / 2
    factor = 1 / (np.tan(half) - half)
    index = scene.add_material(lamp_program(("area_spread", [np.tan(half), factor], [])))
    angle = (np.arange(20000) + 0.5) / 20000 * np.pi
    wo = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    values = scene.shade(index, wo=wo)["emission"][:, 0]
    assert (values[angle > half] == 0).all()
    total = (2 * np.pi * values * np.cos(angle) * np.sin(angle)).sum() * np.pi / len(angle)
    assert total == pytest.approx(np.pi, rel=1e-4)


def test_light_falloff():
    scene = new_scene()
    builder = ProgramBuilder()
    one = builder.constant(1.0)
    outputs = builder.emit("light_falloff", builder.constant(3.0), builder.constant(2.0))
    (color,) = builder.emit("combine", *outputs)
    builder.emit("emission", one, color, one)
    program = builder.build()
    index = scene.add_material(program)
    for length in (0.5, 2.0):
        quadratic = 3 * length**2 / (2 + length**2)
        expected = quadratic, quadratic * length, quadratic * length**2
        assert scene.shade(index, ray_length=(length,))["emission"][0] == pytest.approx(expected)
    scene.set_world(program)
    assert scene.sky([(0, 0, 1)])[0] == pytest.approx((3, 3, 3))  # infinitely far: left as it is


def test_ray_length_is_the_distance_to_where_light_is_scattered():
    """A lamp whose intensity grows with the square of the distance lights each distance alike; so does a small quad."""
    builder = ProgramBuilder()
    one = builder.constant(1.0)
    (length,) = builder.emit("coordinate", immediates=["RAY_LENGTH"])
    (squared,) = builder.emit("multiply", length, length)
    builder.emit("emission", squared, one, one)
    program = builder.build()
    for kind, sampling in (("lamp", "BOTH"), ("quad", "BOTH"), ("quad", "CONNECTIONS"), ("quad", "SCATTERING")):
        for height in (1.0, 3.0):
            scene, half = new_scene(), 0.05 * height if sampling != "SCATTERING" else 0.3 * height
            floor(scene)
            index = scene.add_material(program)
            if kind == "lamp":
                scene.set_lamps([at_height(height)], index)
                exact, slack = ALBEDO / np.pi, 1e-6
            else:
                mesh, materials = scene.add_mesh(*quad(half, half)), np.array([index], np.int32)
                scene.add_instance(mesh, at_height(height, True), materials=materials)
                # the integral of d^2 (h / d)^2 / d^2 over the square: its solid angle over its distance's cosine
                grid = (np.arange(200) + 0.5) / 100 * half - half
                d2 = grid[:, None] ** 2 + grid**2 + height**2
                exact, slack = ALBEDO / np.pi * (height**2 / d2).mean() * 4 * half**2, 1e-3
            look_at_floor(scene)
            scene.commit()
            values = floor_radiance(scene, 256, light_sampling=sampling)
            assert abs(values.mean() - exact) < 4 * values.std(ddof=1) / 16 + slack * exact, (kind, sampling, height)
