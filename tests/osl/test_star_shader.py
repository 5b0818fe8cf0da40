"""Stars in Cycles: as much light as the engine's, straight and by way of a lens, and what setting up does to worlds."""

import bpy
import numpy as np
import objects
import pytest
import rendering

from blender_addon.cycles import files, setup, shaders, star_cells, stars

SEEDS = 8


def add_stars(scene, count=3):
    """A hole beside the camera, a camera that looks past it, and few stars."""
    settings = scene.world.bentlight
    settings.stars, settings.star_count, settings.star_seed, settings.star_strength = "PROCEDURAL", count, 5, 1e3
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 0))
    hole = bpy.context.object
    hole.bentlight.sphere_radius = 2.0
    return hole


def look_past(scene, hole, star):
    """The camera looks at a star, the hole stands behind it."""
    camera = objects.camera((0, 0, 0), tuple(10 * star), lens_mm=50)
    hole.location = -8 * star
    return camera


def directions(scene):
    return stars.read_stars(scene.world).directions


def compare(scene, size, samples, allowed=0.0):
    """All light in the picture by both renderers: a Z-test. The engine's has no noise. allowed: part of it that may be
    missing besides."""
    rendering.set_size(scene, size, size)
    scene.cycles.filter_width = 1.0  # a box: the weights of a point in all pixels add up to 1, wherever it is
    bpy.ops.bentlight.cycles_setup()
    ours = rendering.render(scene, "BENTLIGHT", 0, 1).sum(axis=(0, 1))
    theirs = np.array([rendering.render(scene, "CYCLES", seed, samples).sum(axis=(0, 1)) for seed in range(SEEDS)])
    error = theirs.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    assert (error < 0.03 * ours).all()
    # 5: of Student's distribution, 1 in 600
    assert (np.abs(theirs.mean(axis=0) - ours) < 5 * error + allowed * ours).all()


def test_a_star_has_as_much_light_as_in_the_engine(scene):
    hole = add_stars(scene)
    look_past(scene, hole, directions(scene)[0])
    compare(scene, 24, 64)


@pytest.mark.parametrize("sky_filter", [0.0, 1.0])
def test_lenses_magnify_stars_as_the_engine_does(scene, sky_filter):
    """Both images of a star that is nearly behind the hole, in all several times as bright as without it. Spots of one
    size in the sky are magnified as stars so wide are: different by the square of their radius over the distance to the
    axis. Those that are round in the picture lose up to twice the inverse square of the ring's radius in pixels:
    docs/limits.md."""
    add_stars(scene, count=1)
    star, size = directions(scene)[0], 72
    aside = np.cross(star, (0.3, 0.5, -0.4))
    objects.camera(tuple(-9 * star + 0.9 * aside), (0, 0, 0), lens_mm=45)
    scene.bentlight.sky_filter = sky_filter
    pixel = 36 / 45 / size
    ring = np.sqrt(4 * 0.1 / 9) / pixel  # of the hole's mass at its distance
    distance = 0.9 * np.linalg.norm(aside) / 9
    compare(scene, size, 64, 2 / ring**2 if sky_filter else (1.1 * pixel / distance) ** 2)


def test_spots_are_as_large_by_a_relay_camera(scene):
    """1.1 pixels of the camera that it stands for."""
    add_stars(scene)
    objects.camera((0, -10, 0), (0, 0, 0), lens_mm=60)
    expected = 1.1 * scene.camera.data.angle / scene.render.resolution_x
    for make in (bpy.ops.bentlight.cycles_setup, lambda: bpy.ops.bentlight.relay_setup(bake=False)):
        make()
        setup.update(scene, bpy.context.evaluated_depsgraph_get())
        assert stars.find(scene.world.node_tree).inputs["Radius"].default_value == pytest.approx(expected)


def test_stars_are_seen_by_the_camera_alone(scene):
    """As in the engine: they light nothing."""
    hole = add_stars(scene, count=2000)
    hole.location = (0, 0, 50)
    white = bpy.data.materials.new("White")
    objects.quad("Wall", (-9, 3, -9), (18, 0, 0), (0, 0, 18), white)
    objects.camera((0, -8, 0), (0, 3, 0))
    bpy.ops.bentlight.cycles_setup()
    assert rendering.render(scene, "CYCLES", 0, 4).max() == 0


def world_state(scene):
    tree = scene.world.node_tree
    links = sorted(
        (a.from_node.name, a.from_socket.identifier, a.to_node.name, a.to_socket.identifier) for a in tree.links
    )
    return sorted(node.name for node in tree.nodes), links


def test_setting_up_and_taking_back(scene):
    add_stars(scene)
    before = world_state(scene)
    bpy.ops.bentlight.cycles_setup()
    assert len(world_state(scene)[0]) == len(before[0]) + 2
    again = world_state(scene)
    bpy.ops.bentlight.cycles_setup()
    assert world_state(scene) == again
    bpy.ops.bentlight.cycles_clear()
    assert world_state(scene) == before


def test_a_bad_catalog_is_refused_and_changes_nothing(scene):
    add_stars(scene)
    scene.world.bentlight.stars = "CATALOG"
    before, objects_before = world_state(scene), sorted(obj.name for obj in scene.objects)
    with pytest.raises(RuntimeError, match="no file is chosen"):
        bpy.ops.bentlight.cycles_setup()
    assert world_state(scene) == before and sorted(obj.name for obj in scene.objects) == objects_before
    assert not setup.is_set_up(scene)


def test_stars_follow_the_world(scene, tmp_path):
    """Other stars are another table; a table that is lost is made again; without stars the world is as it was."""
    add_stars(scene)
    before = world_state(scene)
    bpy.ops.bentlight.cycles_setup()
    node = stars.find(scene.world.node_tree)
    first = node.inputs["Cells"].default_value
    scene.world.bentlight.star_seed += 1
    depsgraph = bpy.context.evaluated_depsgraph_get()
    setup.update(scene, depsgraph)
    assert node.inputs["Cells"].default_value != first
    node.inputs["Cells"].default_value = str(tmp_path / "lost.exr")
    setup.update(scene, depsgraph)
    assert node.inputs["Cells"].default_value not in (first, str(tmp_path / "lost.exr"))
    scene.world.bentlight.stars = "OFF"
    setup.update(scene, depsgraph)
    assert world_state(scene) == before


def test_the_engine_draws_its_stars_once(scene):
    """What is added for Cycles is not rendered by the engine as well."""
    hole = add_stars(scene)
    look_past(scene, hole, directions(scene)[0])
    before = rendering.render(scene, "BENTLIGHT", 0, 1)
    bpy.ops.bentlight.cycles_setup()
    np.testing.assert_array_equal(rendering.render(scene, "BENTLIGHT", 0, 1), before)


def test_cells_hold_all_light_and_each_star_near_its_place():
    rng = np.random.default_rng(2)
    where = rng.normal(size=(5000, 3))
    where /= np.linalg.norm(where, axis=1, keepdims=True)
    where[:3] = (0, 0, 1), (0, 0, -1), (-1, 0, 0)
    light = rng.uniform(0, 1, (5000, 3))
    size = star_cells.size_for(len(where))
    cells = star_cells.star_cells(where, light, size)
    np.testing.assert_allclose(cells[..., 3:].sum(axis=(0, 1)), light.sum(axis=0), rtol=1e-5)
    kept = cells[cells[..., 3:].sum(axis=-1) > 0][:, :3].astype(float)
    assert 0.95 * len(where) < len(kept) <= len(where)
    nearest = np.array([np.linalg.norm(kept - star, axis=1).min() for star in where[:500]])
    assert (nearest < 1e-6).mean() > 0.9 and nearest.max() < 1.5 * 2 * np.pi / size


VIEWS = {"north pole": (0, 0, 1), "south pole": (0.004, -0.003, -1), "seam": (-1, 0, 0.3), "aside": (0.3, -0.8, 0.5)}
SIZE, FIELD = 256, 0.15  # cells at the equator, 0.025 wide; radians across the picture


def pixel_directions(camera, width):
    """(width, width, 3), from the top."""
    x = np.tan(FIELD / 2) * ((np.arange(width) + 0.5) / width * 2 - 1)
    local = np.stack([*np.meshgrid(x, -x), -np.ones((width, width))], axis=-1)
    local /= np.linalg.norm(local, axis=-1, keepdims=True)
    return local @ np.array(camera.matrix_world)[:3, :3].T


def show_table(world, cells, **inputs):
    """The world shows the stars of a table."""
    tree = world.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeOutputWorld")
    sockets = {name: ("NodeSocketFloat", value) for name, value in inputs.items()}
    sockets |= {
        "Size": ("NodeSocketInt", SIZE),
        "Cells": ("NodeSocketString", str(files.named_by_content("stars", cells))),
    }
    shaders.fill_node(node, shaders.compiled("stars"), sockets)
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])


@pytest.mark.parametrize("rows", [0.3, 1.6, 3.9])
@pytest.mark.parametrize("view", VIEWS)
def test_every_pixel_sees_the_stars_that_it_should(scene, view, rows):
    """Light over solid angle of all spots that a pixel lies in, which reach over so many rows, of all stars of the
    table: whichever cells they are in, across rows of another number of cells, around the poles, and where azimuths
    begin anew."""
    random = np.random.default_rng(6)
    middle = np.array(VIEWS[view]) / np.linalg.norm(VIEWS[view])
    where = middle + random.uniform(-FIELD, FIELD, (300, 3))
    where /= np.linalg.norm(where, axis=1, keepdims=True)
    cells = star_cells.star_cells(where, random.uniform(0.1, 1, (300, 3)), SIZE)
    radius, strength = rows * 2 * np.pi / SIZE, 2e-4
    show_table(scene.world, cells, Radius=radius, Strength=strength)
    scene.cycles.shading_system = True
    camera = objects.camera((0, 0, 0), tuple(middle))
    camera.data.angle = FIELD
    rendering.set_size(scene, 64, 64)
    seen = rendering.render(scene, "CYCLES", 0, 1)
    stars_there = cells[cells[..., 3:].sum(axis=-1) > 0].astype(float)
    bpy.context.view_layer.update()
    apart = np.linalg.norm(pixel_directions(camera, 64)[..., None, :] - stars_there[:, :3], axis=-1)
    profile = 3 / (np.pi * radius**2) * np.maximum(1 - (apart / radius) ** 2, 0) ** 2
    light = profile @ stars_there[:, 3:] * strength
    assert len(stars_there) > 15
    counts = (apart < radius).sum(axis=-1)
    assert (counts > 0).mean() > 0.1 and counts.max() > 1
    # the profile's largest slope is 16 / sqrt(108) over the radius; rays are up to 0.005 pixels aside along either axis
    slope = 16 / np.sqrt(108) / radius * 3 / (np.pi * radius**2) * (apart < radius) @ stars_there[:, 3:] * strength
    assert (np.abs(seen - light) < 5e-6 * light.max() + 0.005 * np.sqrt(2) * FIELD / 64 * slope).all()
