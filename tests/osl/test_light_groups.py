"""View layers and light groups of what lenses and the relay camera's screen add to a sky, and of accretion disks."""

import bpy
import numpy as np
import objects
import pytest
import rendering
import skies

from blender_addon.cycles import filtered_sky, lens, light_groups, relay, screen, setup
from tests.engine import stage


@pytest.fixture(autouse=True)
def no_maps_left():
    yield
    relay.forget_all()


@pytest.fixture(params=["lens", "relay"])
def hole(request, scene, tmp_path):
    """A hole with a small disk before points, in pictures that are the same whenever they are rendered."""
    skies.show(scene, skies.sky_file(tmp_path, skies.points()))
    scene.world.cycles.sampling_method = "NONE"
    objects.camera((0.3, -20, 3), (0, 0, 0), lens_mm=60)
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    hole = bpy.context.object
    hole.bentlight.disk.outer_radius, hole.bentlight.disk.enable = 9.0, False
    hole.bentlight.sphere_radius = hole.bentlight.lens_radius = 12.0
    rendering.set_size(scene, 64, 40)
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 4, False, False
    bpy.ops.bentlight.cycles_setup()
    if request.param == "relay":
        bpy.ops.bentlight.relay_setup(bake=False)
    return hole


def passes(scene, folder, sky_filter=1.0):
    """Of every view layer."""
    scene.bentlight.sky_filter = sky_filter
    setup.update(scene, bpy.context.evaluated_depsgraph_get())
    layers = stage.render_layers(folder)
    return {layer: {name: pixels[..., :3] for name, pixels in found.items()} for layer, found in layers.items()}


def add_group(scene, name, *owners):
    for layer in scene.view_layers:
        layer.lightgroups.add(name=name)
    for owner in owners:
        owner.lightgroup = name


def is_filtered(scene):
    setup.update(scene, bpy.context.evaluated_depsgraph_get())
    return filtered_sky.read(scene, bpy.context.evaluated_depsgraph_get())[0] is not None


def test_view_layers_without_the_world_have_none_of_it(hole, scene, tmp_path):
    """Beside layers that have it, where it is filtered as ever."""
    hole.bentlight.disk.enable = True
    alone = passes(scene, tmp_path)["ViewLayer"]["Combined"]
    scene.view_layers.new("Without").use_sky = False
    both, unfiltered = (passes(scene, tmp_path, sky_filter) for sky_filter in (1.0, 0.0))
    np.testing.assert_array_equal(both["ViewLayer"]["Combined"], alone)
    assert np.abs(alone - unfiltered["ViewLayer"]["Combined"]).max() > 0.1
    np.testing.assert_array_equal(both["Without"]["Combined"], unfiltered["Without"]["Combined"])
    assert both["Without"]["Combined"].max() > 0.1  # the disk


def test_the_sky_is_in_the_light_group_of_the_world(hole, scene, tmp_path):
    """All of the picture is, and is the same as without groups."""
    alone = passes(scene, tmp_path)["ViewLayer"]["Combined"]
    add_group(scene, "Sky", scene.world)
    add_group(scene, "Other", hole)
    found = passes(scene, tmp_path)["ViewLayer"]
    np.testing.assert_array_equal(found["Combined"], alone)
    np.testing.assert_allclose(found["Combined_Sky"], alone, rtol=1e-6, atol=1e-6)
    assert not found["Combined_Other"].any()


def test_disks_are_in_the_light_group_of_their_hole(hole, scene, tmp_path):
    """As in the engine. What a shader shows is in one group, so that only in that of the disk a sky is filtered."""
    hole.bentlight.disk.enable = True
    add_group(scene, "Disk", hole)
    add_group(scene, "Sky", scene.world)
    assert not is_filtered(scene)
    found = passes(scene, tmp_path)["ViewLayer"]
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    black = passes(scene, tmp_path)["ViewLayer"]
    np.testing.assert_array_equal(found["Combined_Disk"], black["Combined"])
    np.testing.assert_allclose(found["Combined_Disk"] + found["Combined_Sky"], found["Combined"], rtol=1e-5, atol=1e-5)
    assert min(found[name].max() for name in ("Combined_Disk", "Combined_Sky")) > 0.1
    scene.world.lightgroup = "Disk"
    assert is_filtered(scene)


def test_groups_of_lenses_follow_holes_and_the_world(hole, scene):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    (shown,) = lens.all_of(scene)
    scene.world.lightgroup, hole.lightgroup = "Sky", "Disk"
    for enabled, group in ((False, "Sky"), (True, "Disk"), (False, "Sky")):
        hole.bentlight.disk.enable = enabled
        setup.update(scene, depsgraph)
        assert shown.lightgroup == group


def test_disks_in_several_groups_by_the_relay_camera(hole, scene):
    """Its one screen can be in one group alone; the panel says so."""
    if not relay.source_of(scene.camera):
        bpy.ops.bentlight.relay_setup(bake=False)
    hole.bentlight.disk.enable, hole.lightgroup = True, "Disk"
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(30, 0, 0))
    other = bpy.context.object
    other.bentlight.disk.enable = True
    assert light_groups.of_screen(scene) == "" and len(light_groups.warnings(scene)) == 1
    other.lightgroup = "Disk"
    assert light_groups.of_screen(scene) == "Disk" and not light_groups.warnings(scene)
    relay.update(scene, bpy.context.evaluated_depsgraph_get())
    assert screen.find(scene.camera).lightgroup == "Disk"
