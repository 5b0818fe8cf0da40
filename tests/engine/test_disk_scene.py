"""Accretion disks in Blender: their settings, what they look like, when they are refused."""

import bpy
import numpy as np
import pytest
from bentlight_native import disk_isco

from blender_addon.sync import thermal
from blender_addon.sync.cie_1931 import RGB_FROM_XYZ, RGB_FROM_XYZ_5
from tests.engine import stage

DISTANCE = 40.0


def add_hole(**settings):
    """A hole of mass 1 with a plain disk, seen from its axis."""
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=settings.pop("spin", 0.0), location=(0, 0, 0))
    hole = bpy.context.object
    disk = hole.bentlight.disk
    disk.enable, disk.pattern, disk.softness = True, 0.0, 0.0
    for name, value in settings.items():
        setattr(disk, name, value)
    return hole


def look(tilt=0.0, **camera):
    """A camera that many radii away, tilted out of the axis."""
    place = (0.0, -DISTANCE * np.sin(tilt), DISTANCE * np.cos(tilt))
    stage.add_camera(place, (tilt, 0, 0), **({"sensor_fit": "HORIZONTAL", "angle": 1.3, "clip_end": 1e4} | camera))
    stage.set_world((0, 0, 0))
    bpy.context.scene.bentlight.max_bounces = 0


def picture(tmp_path, samples=4):
    """Channels of the picture. Of one sample a pixel is what one ray sees, the same ray in each render."""
    bpy.context.scene.bentlight.photon_ring_samples = 1
    bpy.context.scene.bentlight.samples = samples
    bpy.context.scene.bentlight.use_adaptive_sampling = False
    return stage.render(tmp_path)["Combined"].astype(float)


def emission_material(attribute):
    """A material that shines with the number of an attribute."""
    material = bpy.data.materials.new(attribute)
    stage._use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    source = tree.nodes.new("ShaderNodeAttribute")
    source.attribute_name = attribute
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(source.outputs["Fac"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


@pytest.mark.parametrize("sphere", [0.0, 30.0])
def test_a_thermal_disk_seen_from_its_axis(tmp_path, sphere):
    """Face on, g = sqrt(1 - 3/r) over the camera's lapse, which is 1 outside a sphere of influence, at every azimuth:
    luminance and color are those of a blackbody of g T; and T follows the power law."""
    hole = add_hole(emission="POWER_LAW", temperature=6000.0, exponent=0.5, strength=2.0, outer_radius=20.0)
    hole.bentlight.sphere_radius = sphere
    radius = emission_material("bentlight_radius")
    look()
    pixels = picture(tmp_path, 1)[..., :3]
    hole.bentlight.disk.emission, hole.bentlight.disk.material = "MATERIAL", radius
    r = picture(tmp_path, 1)[..., 0]
    inside = r > 0
    assert inside.sum() > 100
    lapse = 1 if sphere else (DISTANCE - 0.5) / (DISTANCE + 0.5)
    kelvin = 6000 * (r[inside] / 6) ** -0.5 * np.sqrt(1 - 3 / r[inside]) / lapse
    table = RGB_FROM_XYZ if bpy.app.version < (5, 0) else RGB_FROM_XYZ_5
    expected = 2 * thermal.blackbody_xyz(kelvin) @ table.T / thermal.luminance(6000.0)
    assert np.abs(pixels[inside] / expected - 1).max() < 2e-3


@pytest.mark.parametrize("spin", [0.0, 0.9])
def test_the_inner_edge_is_the_last_stable_orbit(tmp_path, spin):
    material = emission_material("bentlight_radius")
    add_hole(spin=spin, emission="MATERIAL", material=material, outer_radius=15.0)
    look()
    r = picture(tmp_path, 1)[..., 0]
    assert disk_isco(spin) < r[r > 0].min() < disk_isco(spin) + 0.3
    assert 14.7 < r.max() < 15


def test_sliders_at_zero_are_the_same_in_the_mirror(tmp_path):
    """Without spin and shift, light on the left is that on the right: a Z-test over pixels. With nature's shift the
    side that approaches is brighter by far."""
    hole = add_hole(emission="POWER_LAW", doppler=0.0, gravitational=0.0)
    look(1.3)
    film = picture(tmp_path, 32)[..., 1]
    half = film.shape[1] // 2
    left, right = film[:, :half], film[:, half:][:, ::-1]
    difference = (left - right).sum(axis=1)
    assert abs(difference.sum()) < 4 * np.sqrt((difference**2).sum())
    assert abs(left.sum() / right.sum() - 1) < 0.01
    hole.bentlight.disk.doppler = 1.0
    natural = picture(tmp_path, 4)[..., 1]
    assert natural[:, :half].sum() > 2 * natural[:, half:].sum()  # it turns about +z


def test_the_pattern_loops(tmp_path):
    """A loop later the picture is the same; a frame later it has hardly moved, also where a layer starts afresh; in
    between it differs."""
    scene = bpy.context.scene
    add_hole(emission="POWER_LAW", pattern=1.0, loop_frames=200, loop_orbits=0.5)
    look(0.8)
    frames = {}
    for frame in (100, 101, 150, 300):
        scene.frame_set(frame)
        frames[frame] = picture(tmp_path)[..., :3]
    assert (frames[100] == frames[300]).all()
    moved, far = (np.abs(frames[f] - frames[100]).mean() for f in (101, 150))
    assert 0 < moved < 0.2 * far


def test_a_ramp_and_an_image(tmp_path):
    """A ramp is made at once; both are colors from the inner to the outer edge, times g^4 and strength."""
    hole = add_hole(doppler=0.0, gravitational=0.0, strength=3.0)
    disk = hole.bentlight.disk
    look()
    disk.emission = "RAMP"
    assert disk.ramp is not None
    while len(disk.ramp.color_ramp.elements) > 1:
        disk.ramp.color_ramp.elements.remove(disk.ramp.color_ramp.elements[0])
    disk.ramp.color_ramp.elements[0].color = (0.5, 0.25, 0.125, 1.0)
    brightest = picture(tmp_path)[..., :3].max(axis=(0, 1))
    assert brightest == pytest.approx([1.5, 0.75, 0.375], rel=1e-5)
    disk.emission = "IMAGE"
    disk.image = bpy.data.images.new("Disk", 4, 4, float_buffer=True)
    disk.image.pixels.foreach_set(np.tile(np.float32([0.2, 0.4, 0.6, 1.0]), 16))
    assert picture(tmp_path)[..., :3].max(axis=(0, 1)) == pytest.approx([0.6, 1.2, 1.8], rel=1e-5)


def test_an_image_half_transparent_shines_half(tmp_path):
    """Alpha counts once, however the image holds its colors."""
    hole = add_hole(emission="IMAGE", doppler=0.0, gravitational=0.0)
    look()
    hole.bentlight.disk.image = image = bpy.data.images.new("Disk", 4, 4, alpha=True)
    image.pixels.foreach_set(np.tile(np.float32([1, 1, 1, 0.5]), 16))
    assert picture(tmp_path)[..., 0].max() == pytest.approx(128 / 255, rel=1e-5)


def test_opacity_lets_the_sky_through(tmp_path):
    hole = add_hole(emission="POWER_LAW", strength=0.0, opacity=0.25)
    look()
    bpy.context.scene.world.color = (1, 1, 1)
    stage.set_world((1, 1, 1))
    seen = picture(tmp_path)[..., 0]
    assert np.median(seen[(seen > 0.01) & (seen < 0.99)]) == pytest.approx(0.75, abs=1e-5)
    hole.bentlight.disk.enable = False
    assert picture(tmp_path)[..., 0].max() == pytest.approx(1, abs=1e-5)


def test_a_mesh_before_the_hole_hides_all_of_its_disk(tmp_path):
    add_hole(emission="MATERIAL", material=emission_material("bentlight_radius"))
    look(1.4)
    assert picture(tmp_path)[..., 0].max() > 6
    screen = stage.add_square(60.0, (0, -30.0 * np.sin(1.4), 30.0 * np.cos(1.4)), stage.emission((0, 0, 1)))
    screen.rotation_euler = (1.4, 0, 0)
    assert picture(tmp_path)[..., 0].max() == 0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"outer_radius": 5.0}, "must be larger"),
        ({"emission": "IMAGE"}, "no image"),
        ({"emission": "MATERIAL"}, "no material"),
        ({"temperature": float("nan")}, "Temperature"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, settings, message):
    add_hole(**settings)
    look()
    with pytest.raises(RuntimeError, match=message):
        picture(tmp_path)


def test_a_missing_ramp_is_refused(tmp_path):
    add_hole(emission="RAMP").bentlight.disk.ramp = None
    look()
    with pytest.raises(RuntimeError, match="no color ramp"):
        picture(tmp_path)
