"""The Sky Texture against Cycles where its kind is single scattering; other kinds say that they are approximated."""

import bentlight_native
import bpy
import numpy as np
import pytest
from cycles_values import render_world
from value_cases import empty_tree, new

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_world
from blender_addon.sync.sky import Atmosphere, sky_radiance

KINDS = bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items.keys()
SINGLE = next(kind for kind in KINDS if kind in ("SINGLE_SCATTERING", "NISHITA"))
WIDTH, HEIGHT = 48, 96
TEXELS = np.array([128, 512])  # of Cycles' table, above the horizon and around it


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


def cycles_table(atmosphere, elevation, azimuth):
    """What Cycles reads from its table: texel (j, i) is made for the angles of its lower corner (for the left half of
    the sky, the right one mirrors it), but stands for its middle. Up to Blender 4.5 its rows end half a row beyond the
    zenith. Source: intern/sky/source/sky_single_scattering.cpp; in 4.5 sky_nishita.cpp."""
    rows, columns = TEXELS
    zenith = np.pi / 2 * (1 if bpy.app.version >= (5, 0, 0) else 1 + 0.5 / rows)
    row = rows * np.sqrt(elevation / (np.pi / 2)) - 0.5
    column = columns * np.abs((azimuth + np.pi) % (2 * np.pi) - np.pi) / (2 * np.pi) - 0.5
    total = 0
    for j, i in np.ndindex(2, 2):
        at_row, at_column = np.floor(row) + j, np.floor(column) + i
        weight = (1 - np.abs(row - at_row))[:, None] * (1 - np.abs(column - at_column))
        elevations = zenith * (np.clip(at_row, 0, rows - 1) / rows) ** 2
        azimuths = 2 * np.pi * (np.clip(at_column, 0, columns // 2 - 1) + 1) / columns
        total += weight[..., None] * sky_radiance(atmosphere, *np.meshgrid(elevations, azimuths, indexing="ij"))
    return total


@pytest.mark.parametrize(("elevation", "altitude"), [(0.05, 500.0), (0.26, 0.0), (1.0, 3000.0)])
def test_single_scattering_is_that_of_cycles(elevation, altitude, tmp_path):
    """Brightness and color everywhere above the horizon, and so the place of the sun: Cycles' to the digits of the
    atmosphere's constants where its table is, ours where it should be, but for the pixels of our image."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    rotation = 0.7
    settings = {"sun_disc": False, "sun_elevation": elevation, "sun_rotation": rotation, "altitude": altitude}
    world = make_world(SINGLE, **settings)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.panorama_type = "PANO", "EQUIRECTANGULAR"
    theirs = render_world(world, camera, (np.pi / 2, 0, -np.pi / 2), WIDTH, HEIGHT, tmp_path / "sky.exr")
    theirs = theirs[HEIGHT // 2 :]
    rows = ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5)[HEIGHT // 2 :] * np.pi
    columns = np.pi - (np.arange(WIDTH) + 0.5) / WIDTH * 2 * np.pi
    atmosphere, azimuths = Atmosphere(elevation, altitude), columns - (np.pi / 2 - rotation)
    np.testing.assert_allclose(cycles_table(atmosphere, rows, azimuths), theirs, rtol=1e-3)
    sky, warnings = our_sky(world)
    ours = sky(spherical(rows[:, None], columns[None, :]).reshape(-1, 3)).reshape(theirs.shape)
    exact = sky_radiance(atmosphere, *np.meshgrid(rows, azimuths, indexing="ij"))
    assert warnings == []
    np.testing.assert_allclose(ours, exact, rtol=0.01)


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
    np.testing.assert_allclose(ours[bright].mean(axis=0), theirs[bright].mean(axis=0), rtol=1e-3)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != SINGLE])
def test_other_kinds_say_that_they_are_approximated(kind):
    sky, warnings = our_sky(make_world(kind))
    assert len(warnings) == 1 and kind in warnings[0]
    assert (sky([(0, 0, 1.0), (0.6, 0, 0.8)]) > 0).all()
