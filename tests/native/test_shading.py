"""Programs, images and materials at their borders: malformed ones are refused by name, good ones are thread safe."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from bentlight_native import OPERATIONS, Program, ProgramBuilder, Scene
from bsdf_tools import direction, material, principled


def program(code, constants=((1.0, 1.0, 1.0),), table=()):
    return Program(
        np.array(code, np.int32),
        np.array(constants, np.float64).reshape(-1, 3),
        np.array(table, np.float32).reshape(-1, 4),
    )


def opcode(name):
    return OPERATIONS[name].number


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ([9999, 0], "no operation 9999"),
        ([-1, 0], "no operation -1"),
        ([opcode("emission"), 0, -1], "emission at 0 is cut off"),
        ([opcode("emission"), 0, -1, -1, -2], "operand 2 is -2"),
        ([opcode("emission"), 0, -1, -1, 0], "operand 2 is 0"),
        ([opcode("emission"), 0, -1, -1, -(2**31)], "does not exist"),
        ([opcode("clamp"), 5, -1], "output register 5, expected 0"),
        ([opcode("math"), 0, -1, -1, -1, 1000], "immediate 0 is 1000"),
        ([opcode("image"), 0, -1, 0, 0, 0, 0], "immediate 0 is 0"),
        ([opcode("ramp"), 0, -1, 0, 1, 1], "immediate 0 is 0"),
    ],
)
def test_malformed_programs_are_refused(code, reason):
    with pytest.raises(ValueError, match=reason):
        Scene().add_material(program(code))


def test_ramp_within_its_table():
    table = np.ones((4, 4))
    scene = Scene()
    for start, count, fits in ((0, 4, True), (3, 1, True), (1, 4, False), (0, 0, False), (2, 2**31 - 1, False)):
        ramp = program([opcode("ramp"), 0, -1, start, count, 1], table=table)
        if fits:
            scene.add_material(ramp)
        else:
            with pytest.raises(ValueError, match="immediate"):
                scene.add_material(ramp)


def test_random_programs_are_refused_or_run():
    """No crash, whatever the numbers: all operations, operands and immediates around their limits."""
    rng = np.random.default_rng(0)
    scene, accepted = Scene(), 0
    scene.add_image(np.ones((2, 2, 4), np.float32))
    names = list(OPERATIONS)
    for _ in range(4000):
        code, registers = [], 0
        for _ in range(rng.integers(1, 6)):
            operation = OPERATIONS[names[rng.integers(len(names))]]
            low = -4 if rng.random() < 0.05 else -3
            code += [operation.number, registers]
            code += rng.integers(low, max(registers, 0), operation.operands).tolist()
            code += [int(rng.integers(0, max(len(choices), 2))) for choices in operation.choices]
            registers += operation.outputs
        constants = rng.normal(size=(3, 3)) * 10.0 ** rng.integers(-3, 4)
        try:
            index = scene.add_material(program(code, constants, rng.random((3, 4))))
        except ValueError:
            continue
        accepted += 1
        result = scene.shade(index, position=rng.normal(size=(4, 3)), uv=rng.normal(size=(4, 2)))
        drawn = scene.draw_bsdf(index, rng.random((8, 3)), wo=direction(0.5))
        assert np.isfinite(result["emission"]).all()
        assert np.isfinite(drawn.weight).all() and np.isfinite(drawn.pdf).all() and np.isfinite(drawn.wi).all()
    assert accepted > 1000


def test_constants_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="constants: contains NaN"):
        Scene().add_material(program([], constants=[(np.nan, 0, 0)]))


def test_a_refused_material_leaves_the_old_one():
    scene = Scene()
    good = program([opcode("emission"), 0, -1, -1, -1])
    index = scene.add_material(good)
    with pytest.raises(ValueError, match="no operation"):
        scene.update_material(index, program([9999, 0]))
    with pytest.raises(ValueError, match="no material 7"):
        scene.update_material(7, good)
    assert (scene.shade(index)["emission"] == 1).all()


def test_updates_replace_what_is_shown():
    scene, builder = Scene(), ProgramBuilder()
    image = scene.add_image(np.full((2, 3, 4), 0.25, np.float32))
    color = builder.emit("image", builder.constant(0.5), immediates=(image, "Linear", "EXTEND", "OFF"))[0]
    builder.emit("emission", builder.constant(1), color, builder.constant(1))
    index = scene.add_material(builder.build())
    np.testing.assert_allclose(scene.shade(index)["emission"], 0.25)
    scene.update_image(image, np.full((5, 4, 4), 51, np.uint8))
    np.testing.assert_allclose(scene.shade(index)["emission"], 0.2)
    with pytest.raises(ValueError, match="no image 1"):
        scene.update_image(1, np.ones((2, 2, 4), np.float32))
    with pytest.raises(ValueError, match="NaN"):
        scene.update_image(image, np.full((2, 2, 4), np.nan, np.float32))
    np.testing.assert_allclose(scene.shade(index)["emission"], 0.2)
    scene.update_material(index, program([opcode("emission"), 0, -1, -1, -1]))
    np.testing.assert_allclose(scene.shade(index)["emission"], 1)


@pytest.mark.parametrize(
    ("pixels", "reason"),
    [
        (np.ones((2, 2, 3), np.float32), "shape"),
        (np.ones((2, 2, 4), np.float64), "float32"),
        (np.full((2, 2, 4), np.nan, np.float32), "NaN"),
        (np.ones((0, 2, 4), np.float32), "size 2 x 0"),
    ],
)
def test_bad_images_are_refused(pixels, reason):
    with pytest.raises(ValueError, match=reason):
        Scene().add_image(pixels)


def image_scene(pixels, u, v, interpolation="Linear", extension="EXTEND"):
    scene, builder = Scene(), ProgramBuilder()
    index = scene.add_image(pixels)
    place = builder.constant((u, v, 0))
    if np.isinf(u):
        place = builder.emit("math", *[builder.constant(x) for x in (1000.0, 0, 0)], immediates=("EXPONENT",))[0]
    color = builder.emit("image", place, immediates=(index, interpolation, extension, "OFF"))[0]
    builder.emit("emission", builder.constant(1), color, builder.constant(1))
    return scene.shade(scene.add_material(builder.build()))["emission"][0]


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
@pytest.mark.parametrize("interpolation", ["Linear", "Closest", "Cubic", "Smart"])
@pytest.mark.parametrize("place", [1e30, -1e30, 1e15, -0.0, np.inf])
def test_images_far_away_are_harmless(place, interpolation, extension):
    pixels = np.random.default_rng(0).random((3, 5, 4), np.float32)
    color = image_scene(pixels, place, place, interpolation, extension)
    assert np.isfinite(color).all() and (color >= 0).all() and (color <= 1).all()


@pytest.mark.parametrize("place", [1e9, -1e9, 1e15])
def test_the_edge_of_an_image_goes_on_forever(place):
    """Also where a place is no integer of 32 bits any more, which is what `long` has on Windows."""
    pixels = np.random.default_rng(0).random((3, 5, 4), np.float32)
    pixels[..., 3] = 1
    edge = pixels[-1, -1, :3] if place > 0 else pixels[0, 0, :3]
    np.testing.assert_allclose(image_scene(pixels, place, place), edge, rtol=1e-6)


def test_bytes_and_floats_of_the_same_image_agree():
    bytes_ = np.random.default_rng(1).integers(0, 256, (4, 4, 4), np.uint8)
    floats = (bytes_ / 255).astype(np.float32)
    for u, v in np.random.default_rng(2).random((20, 2)):
        np.testing.assert_allclose(image_scene(bytes_, u, v), image_scene(floats, u, v), rtol=1e-6)


def test_unknown_material_is_default_gray():
    scene = Scene()
    for index in (-1, 0, 2**31 - 1):
        np.testing.assert_allclose(scene.shade(index)["albedo"], [[0.8, 0.8, 0.8]])


def test_builder_names_what_is_wrong():
    builder = ProgramBuilder()
    one = builder.constant(1.0)
    with pytest.raises(ValueError, match="'FROB' is none of ADD"):
        builder.emit("math", one, one, one, immediates=("FROB",))
    with pytest.raises(ValueError, match="expected 3 operands"):
        builder.emit("math", one, immediates=("ADD",))
    with pytest.raises(KeyError):
        builder.emit("frob", one)


def test_shading_is_the_same_on_all_threads():
    scene = Scene()
    index = material(principled(transmission=0.5, metallic=0.2), scene=scene)
    u = np.random.default_rng(3).random((20_000, 3))
    with ThreadPoolExecutor(4) as pool:
        runs = list(pool.map(lambda _: scene.draw_bsdf(index, u, wo=direction(0.4)), range(8)))
    for run in runs[1:]:
        for a, b in zip(runs[0], run, strict=True):
            np.testing.assert_array_equal(a, b)
