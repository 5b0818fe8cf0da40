"""Accretion disks by the relay camera: as the engine sees them, with all that Cycles knows besides."""

import bpy
import numpy as np
import pytest
from bentlight_native.exr import read_exr
from test_disk_pictures import layered_material, smooth_image

from blender_addon.cycles import relay, relay_operators, render_state
from blender_addon.report import Reporter
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.osl import test_relay_motion as motion
from tests.osl.test_relay_camera import cycles, picture, shining_room

LOOKS = {
    "opaque": {"emission": "PAGE_THORNE", "opacity": 1.0},
    "thin": {"emission": "RAMP", "opacity": 0.5},
    "image": {"emission": "IMAGE", "opacity": 0.8},
    "material": {"emission": "MATERIAL", "softness": 0.0},  # with two ways through the engine draws one
}


def add_disk(spin: float = 0.6, location=(0, 0, 0), **look) -> bpy.types.Object:
    """A hole of mass 0.1 and its disk, tilted towards the camera of shining_room, without a pattern."""
    bpy.ops.bentlight.black_hole_add(mass=0.1, spin=spin, location=location)
    hole = bpy.context.object
    hole.rotation_euler = (0.3, 0.1, 0)
    disk = hole.bentlight.disk
    disk.enable, disk.pattern, disk.outer_radius = True, 0.0, 12.0
    disk.image, disk.material = smooth_image(), layered_material()
    for name, value in look.items():
        setattr(disk, name, value)
    return hole


@pytest.mark.parametrize("gravitational", [0, 1])
@pytest.mark.parametrize("look", LOOKS)
def test_it_sees_what_the_engine_sees(look, gravitational, tmp_path):
    """Through every crossing, with shining squares before and behind the disk and a sky of directions: the same color
    in the middle of each pixel."""
    shining_room()
    bpy.context.scene.bentlight.gravitational = gravitational
    hole = add_disk(**LOOKS[look])
    scene = cycles()
    scene.bentlight.relay_parts = 3  # one is in the middle
    ours = picture(tmp_path, "BENTLIGHT")
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.relay_setup()
    theirs = picture(tmp_path)
    off = np.abs(ours - theirs).max(axis=-1) / np.maximum(ours.max(axis=-1), 0.1)
    assert np.median(off) < 2e-5
    # Filters of a hundredth of a pixel still blur edges and the rings around the shadow.
    assert np.mean(off > 5e-3) < 0.02
    hole.bentlight.disk.enable = False
    changed = np.abs(picture(tmp_path) - theirs).max(axis=-1) > 0.01
    assert 0.1 < changed.mean() < 0.6


def bake(scene: bpy.types.Scene) -> str:
    """What a render does before: how the maps' paths begin then."""
    relay_operators._before_render(scene)
    return scene.camera.data.cycles_custom["Maps"]


def test_what_disks_look_like_is_baked_anew():
    """Their settings, image, material and, with a pattern, frame; not the look of anything else."""
    shining_room()
    disk = add_disk(emission="RAMP").bentlight.disk
    lamp = stage.add_light("POINT", (3, 0, 0), energy=20)
    scene = cycles()
    scene.bentlight.relay_parts = 1
    bpy.ops.bentlight.relay_setup(bake=False)
    seen = [bake(scene)]
    bpy.data.materials["red"].node_tree.nodes["Emission"].inputs["Strength"].default_value = 2.0
    lamp.data.energy = 30
    scene.frame_set(2)
    assert bake(scene) == seen[0]

    def set_pixel() -> None:
        disk.image.pixels[0] = 0.123
        disk.image.update()

    emission = next(node for node in disk.material.node_tree.nodes if node.bl_idname == "ShaderNodeEmission")
    changes = [
        lambda: setattr(disk, "opacity", 0.4),
        lambda: setattr(disk.ramp.color_ramp.elements[0], "color", (0, 1, 0, 1)),
        lambda: setattr(disk, "emission", "IMAGE"),
        set_pixel,
        lambda: setattr(disk, "pattern", 0.5),
        lambda: scene.frame_set(3),
        lambda: setattr(disk, "emission", "MATERIAL"),
        lambda: setattr(emission.inputs["Strength"], "default_value", 7.0),
        lambda: setattr(disk, "enable", False),
    ]
    for change in changes:
        change()
        seen.append(bake(scene))
    assert len(set(seen)) == len(seen)
    assert not scene.camera.children, "without disks there is no screen"


def test_maps_hold_no_more_than_there_is():
    """Colors of disks that are gray to what is behind them are one pixel; without disks nothing is added."""
    shining_room()
    disk = add_disk(emission="RAMP", opacity=0.5).bentlight.disk
    scene = cycles()
    scene.bentlight.relay_parts = 2
    bpy.ops.bentlight.relay_setup()

    def sizes(name: str) -> list[int]:
        return [file.stat().st_size for file in relay._baked[scene.camera.name][1].files if name in file.name]

    assert max(sizes("tint")) < 2000 < min(sizes("glow")) < min(sizes("direction"))
    disk.emission = "MATERIAL"
    bake(scene)
    assert min(sizes("tint")) == min(sizes("glow"))
    disk.enable = False
    bake(scene)
    assert not sizes("tint") and not sizes("glow") and sizes("direction")


def test_a_disk_through_which_almost_nothing_passes_lets_nothing_pass():
    """Twice a ten-millionth of the sky: told as the length of a direction, it would be taken for light from a surface,
    many million times as bright."""
    shining_room()
    disk = add_disk(emission="RAMP").bentlight.disk
    disk.opacity, disk.softness = 1 - 2.0**-22, 0.0
    scene = cycles()
    scene.bentlight.relay_parts = 2
    bpy.ops.bentlight.relay_setup()
    files = relay._baked[scene.camera.name][1].files
    maps = [read_exr(file)[0] for file in files if "direction" in file.name]
    length = np.concatenate(
        [np.linalg.norm([channel.ravel().astype(float) for channel in m.values()], axis=0) for m in maps]
    )
    assert (length == 0).any() and (length > 1e18).any()
    once = length[(length > 1e11) & (length < 1e15)]
    assert len(once) > 100, "the sky through one opaque sheet"
    assert not ((length > 2) & (length < 1e11)).any()


def test_what_the_core_cannot_show_is_said():
    """As by the engine, naming the hole; nothing of the materials that are for Cycles to know."""
    shining_room()
    nodes = add_disk(emission="MATERIAL").bentlight.disk.material.node_tree.nodes
    for tree in (nodes.id_data, bpy.data.materials["red"].node_tree):
        output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
        tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], output.inputs["Volume"])
    nodes.new("ShaderNodeBsdfDiffuse")
    said = []
    scene = cycles()
    scene.bentlight.relay_parts = 1
    bpy.ops.bentlight.relay_setup(bake=False)
    with render_state.as_rendered(bpy.context.view_layer) as depsgraph:
        relay.update(scene, depsgraph, Reporter(lambda _level, text: said.append(text)))
    assert len(said) == 2
    assert "'Black Hole' only shines in Cycles" in said[0] and "Diffuse BSDF" in said[0]
    assert said[1].startswith("Black hole 'Black Hole'") and "Volume" in said[1]


def flat_ring(opacity: float, color: tuple[float, float, float]) -> bpy.types.Object:
    """A ring of radii 0.3 and 1, as a mesh that shines and lets light pass, or (see flat_disk) as a disk."""
    material = stage.emission(color, name="Ring")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    clear, mix = nodes.new("ShaderNodeBsdfTransparent"), nodes.new("ShaderNodeMixShader")
    mix.inputs["Fac"].default_value = opacity
    links.new(clear.outputs[0], mix.inputs[1])
    links.new(nodes["Emission"].outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes["Material Output"].inputs["Surface"])
    angles = np.linspace(0, 2 * np.pi, 256, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    faces = [(i, i + 256, (i + 1) % 256 + 256, (i + 1) % 256) for i in range(256)]
    return stage.add_mesh("Ring", np.concatenate([0.3 * circle, circle]), faces, material=material)


def flat_disk(opacity: float, color: tuple[float, float, float]) -> bpy.types.Object:
    """The same, around a hole that bends light by 1e-5 radians."""
    bpy.ops.bentlight.black_hole_add(mass=1e-6, location=(0, 0, 0))
    disk = bpy.context.object.bentlight.disk
    disk.enable, disk.inner_edge, disk.emission = True, "CUSTOM", "RAMP"
    disk.inner_radius, disk.outer_radius = 3e5, 1e6
    disk.doppler = disk.gravitational = disk.pattern = disk.softness = 0.0
    for element in disk.ramp.color_ramp.elements:
        element.color = (*color, 1.0)
    disk.opacity, disk.strength = opacity, 1.0
    return bpy.context.object


@pytest.mark.parametrize("out_of_focus", [False, True])
def test_in_flat_space_it_is_a_ring(out_of_focus, tmp_path):
    """As a mesh that Cycles knows: half covered by a square in front, before another one behind and a sky. With depth
    of field too: blocks of the picture, by a Z-test over seeds."""
    stage.set_world((0.2, 0.3, 0.4))
    camera = stage.add_camera((0, -3, 1.5), (np.radians(63), 0, 0))
    for place, size, color in (((-0.6, -0.9, 0.6), 0.5, (0.9, 0.1, 0.1)), ((0.4, 0.6, -0.6), 0.8, (0.1, 0.9, 0.2))):
        stage.add_square(size, place, stage.emission(color)).rotation_euler = (1.1, 0, 0)
    look = 0.6, (0.5, 0.25, 0.75)
    camera.data.dof.use_dof, camera.data.dof.focus_distance = out_of_focus, 2.0
    camera.data.dof.aperture_fstop = 0.15
    scene = cycles(32)
    scene.bentlight.relay_parts = 8
    ring = flat_ring(*look)
    own = motion.pictures(tmp_path)
    ring.hide_render = True
    flat_disk(*look)
    bpy.ops.bentlight.relay_setup()
    relayed = motion.pictures(tmp_path)
    assert motion.mean_square_z(motion.blocks(own), motion.blocks(relayed)) < 1.6
    assert abs((own - relayed).mean()) < 3e-4


def test_motion_blur_is_the_mean_of_stills(tmp_path):
    """A hole and its disk that move, each slice with light of its own."""
    shining_room()
    hole = add_disk(emission="RAMP", opacity=0.7)
    scene = motion.blurred(16)
    scene.bentlight.samples, scene.bentlight.relay_parts, scene.bentlight.relay_slices = 4, 3, 5
    motion.move(hole, (0.7, 0.0, -0.3))
    still = motion.stills(tmp_path, scene.bentlight.relay_slices, 0)
    bpy.ops.bentlight.relay_setup()
    relayed = motion.pictures(tmp_path)
    assert motion.mean_square_z(motion.blocks(still), motion.blocks(relayed)) < 1.6
