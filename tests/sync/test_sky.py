"""The Sky Texture against Cycles where its kind is single scattering; other kinds say that they are approximated."""

import bentlight_native
import bpy
import numpy as np
import pytest
from cycles_values import render_world
from value_cases import empty_tree, new

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_world

KINDS = bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items.keys()
SINGLE = next(kind for kind in KINDS if kind in ("SINGLE_SCATTERING", "NISHITA"))
WIDTH, HEIGHT = 48, 96


def make_world(kind, **settings):
    world = bpy.data.worlds.new("sky")
    tree = empty_tree(world)
    sky = new(tree, "TexSky", sky_type=kind, **settings)
    background = new(tree, "Background", {"Color": sky.outputs[0]})
    new(tree, "OutputWorld", {"Surface": background.outputs[0]})
    return world


def our_sky(world):
    images, scene = ImageTable(), bentlight_native.Scene()
    compiled = compile_world(world, images)
    for pixels in images.images:
        scene.add_image(*pixels)
    scene.set_world(compiled.program)
    return scene.sky, compiled.warnings


def spherical(elevation, azimuth):
    planar = np.cos(elevation)
    return np.stack(np.broadcast_arrays(planar * np.cos(azimuth), planar * np.sin(azimuth), np.sin(elevation)), axis=-1)


@pytest.mark.parametrize(("elevation", "altitude"), [(0.05, 500.0), (0.26, 0.0), (1.0, 3000.0)])
def test_single_scattering_is_that_of_cycles(elevation, altitude, tmp_path):
    """Brightness and color everywhere above the horizon, and so the place of the sun."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings = {"sun_disc": False, "sun_elevation": elevation, "sun_rotation": 0.7, "altitude": altitude}
    world = make_world(SINGLE, **settings)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.panorama_type = "PANO", "EQUIRECTANGULAR"
    theirs = render_world(world, camera, (np.pi / 2, 0, -np.pi / 2), WIDTH, HEIGHT, tmp_path / "sky.exr")
    rows = ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5) * np.pi
    columns = np.pi - (np.arange(WIDTH) + 0.5) / WIDTH * 2 * np.pi
    sky, warnings = our_sky(world)
    ours = sky(spherical(rows[:, None], columns[None, :]).reshape(-1, 3)).reshape(HEIGHT, WIDTH, 3)
    assert warnings == []
    error = np.abs(ours - theirs).max(axis=-1) / theirs.mean(axis=-1).clip(1e-9)
    assert error[rows > 0].mean() < 0.025
    assert error[rows > 0.04].max() < 0.06
    assert error[(rows > 0) & (rows < 0.04)].max() < 0.1


def test_the_sun_is_where_and_as_bright_as_in_cycles(tmp_path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    elevation, rotation, size = 0.5, 0.7, 0.03
    world = make_world(SINGLE, sun_elevation=elevation, sun_rotation=rotation, sun_size=size, sun_intensity=0.3)
    azimuth = np.pi / 2 - rotation
    camera = bpy.data.cameras.new("camera")
    camera.angle = 2 * size
    theirs = render_world(world, camera, (np.pi / 2 + elevation, 0, azimuth - np.pi / 2), 32, 32, tmp_path / "sun.exr")
    place = (np.arange(32) + 0.5) / 32 * 2 - 1
    right = spherical(0.0, azimuth - np.pi / 2)
    up = spherical(elevation + np.pi / 2, azimuth)
    across = np.tan(size) * place
    rays = spherical(elevation, azimuth) + across[None, :, None] * right + across[:, None, None] * up
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    ours = our_sky(world)[0](rays.reshape(-1, 3)).reshape(32, 32, 3)
    bright = theirs[..., 0] > theirs[..., 0].max() / 20
    assert ((ours[..., 0] > ours[..., 0].max() / 20) != bright).mean() < 0.02
    np.testing.assert_allclose(ours[bright].mean(axis=0), theirs[bright].mean(axis=0), rtol=0.04)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != SINGLE])
def test_other_kinds_say_that_they_are_approximated(kind):
    sky, warnings = our_sky(make_world(kind))
    assert len(warnings) == 1 and kind in warnings[0]
    assert (sky([(0, 0, 1.0), (0.6, 0, 0.8)]) > 0).all()
