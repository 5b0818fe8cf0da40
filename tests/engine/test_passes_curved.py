"""Passes that only curved light has, against closed forms."""

import bpy
import numpy as np
import pytest
from bentlight_native import Scene, Spacetime, disk_isco, trace_rays

from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)

MASS, DISTANCE = 0.2, 10.0
SKY = (0.2, 0.4, 0.6)


def hole_before_the_camera(**settings) -> bpy.types.Object:
    """The camera looks along -z at a hole; all of our passes."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, DISTANCE))
    stage.set_world(SKY)
    bpy.ops.bentlight.black_hole_add(mass=MASS, **settings)
    scene.bentlight.samples, scene.bentlight.pixel_filter = 1, "GAUSSIAN"
    scene.bentlight.photon_ring_samples = 1
    scene.render.filter_size = 0.01
    for name in ("deflection", "frequency_shift", "image_order", "winding", "disk", "fate"):
        setattr(scene.view_layers[0].bentlight, f"use_pass_{name}", True)
    return bpy.context.object


def pixel_centers() -> np.ndarray:
    """(48, 64, 2), in [0, 1]."""
    x, y = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(48) + 0.5) / 48)
    return np.stack([x, y], axis=-1)


def slopes(places: np.ndarray) -> np.ndarray:
    """x / -z and y / -z of places in the picture: a lens of 50 mm, a sensor of 36 mm that is 64 pixels wide."""
    return (places - 0.5) * (36 / 50, 36 / 50 * 48 / 64)


def test_deflection_is_the_identity_without_a_hole(tmp_path):
    stage.add_square(3, (0.5, 0.3, 0))
    hole_before_the_camera().bentlight.kind = "NONE"
    found = stage.render(tmp_path)["Bentlight Deflection"]
    np.testing.assert_allclose(found[..., :2], pixel_centers(), atol=1e-6)
    assert (found[..., 2] == 1).all()


def test_deflection_of_the_sky_is_that_of_the_hole(tmp_path):
    """The map sends a pixel to where a flat picture shows the direction in which trace_rays lets its ray leave."""
    hole_before_the_camera()
    passes = stage.render(tmp_path)
    found, fate = passes["Bentlight Deflection"], passes["Bentlight Fate"][..., 0]
    slope = slopes(pixel_centers()).reshape(-1, 2)
    rays = np.concatenate([slope, -np.ones((len(slope), 1))], axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origins = np.tile([0.0, 0.0, DISTANCE], (len(rays), 1))
    traced = trace_rays(Spacetime.schwarzschild(MASS, "isotropic"), origins, rays, tolerance=1e-9)
    out = traced["direction"].reshape(48, 64, 3)
    ahead = (traced["fate"].reshape(48, 64) == 1) & (out[..., 2] < 0)
    assert np.array_equal(found[..., 2] == 1, ahead) and 0.8 < ahead.mean() < 1
    expected = out[ahead][:, :2] / -out[ahead][:, 2:]
    np.testing.assert_allclose(slopes(found[ahead][:, :2]), expected, rtol=1e-3, atol=1e-3)
    assert (found[fate == 2] == 0).all()


def test_deflection_of_a_wall_leads_to_its_places(tmp_path):
    """Where a flat picture shows the point that the curved ray meets."""
    stage.add_square(60, (0, 0, -10), stage.emission((1, 1, 1)))
    hole_before_the_camera()
    bpy.context.scene.view_layers[0].use_pass_position = True
    passes = stage.render(tmp_path)
    found, place = passes["Bentlight Deflection"], passes["Position"]
    on_wall = (passes["Bentlight Fate"][..., 0] == 4) & (np.hypot(*np.moveaxis(slopes(pixel_centers()), 2, 0)) > 0.2)
    seen = place[on_wall][:, :2] / (DISTANCE - place[on_wall][:, 2:])
    np.testing.assert_allclose(slopes(found[on_wall][:, :2]), seen, atol=4e-4)  # places: of pixels 0.03 wide, magnified
    shift = np.linalg.norm(found[on_wall][:, :2] - pixel_centers()[on_wall], axis=1)
    assert shift.min() > 1e-3, "the wall is moved everywhere"


def test_frequency_of_the_sky_is_that_of_a_resting_camera(tmp_path):
    """Light that falls in gains 1 / lapse: isotropic chart, (1 + M/2r) / (1 - M/2r)."""
    hole_before_the_camera()
    passes = stage.render(tmp_path)
    shift, fate = passes["Bentlight Frequency Shift"][..., 0], passes["Bentlight Fate"][..., 0]
    part = MASS / (2 * DISTANCE)
    np.testing.assert_allclose(shift[fate == 1], (1 + part) / (1 - part), rtol=1e-5)
    assert (shift[fate == 2] == 0).all()


def test_image_order_counts_half_turns(tmp_path):
    """Rays that escape sweep almost pi far from the hole, so order 0, and more than it near the shadow."""
    hole_before_the_camera()
    passes = stage.render(tmp_path)
    order, winding, fate = (passes[f"Bentlight {name}"][..., 0] for name in ("Image Order", "Winding", "Fate"))
    out = fate == 1
    assert np.array_equal(order[out], np.floor(winding[out]))
    assert order[out].min() == 0 and order[out].max() >= 1
    assert (order == np.round(order)).all()


def test_disks_are_alone_in_their_pass_and_shift_light(tmp_path):
    """Face on matter on circular orbits has g = sqrt(1 - 3M/r) to far away, here times 1 / lapse of the camera."""
    hole = hole_before_the_camera()
    hole.bentlight.disk.enable = True
    scene = bpy.context.scene
    scene.view_layers[0].use_pass_emit = scene.view_layers[0].use_pass_position = True
    passes = stage.render(tmp_path)
    disk, place = passes["Bentlight Disk"], passes["Position"]
    assert np.array_equal(disk, passes["Emission" if bpy.app.version >= (5, 0, 0) else "Emit"]) and disk.max() > 0
    stage.add_square(1, (2.5, 1.6, 1), stage.emission((5, 5, 5)))
    hidden = stage.render(tmp_path)
    square = hidden["Position"][..., 2] > 0.5
    assert square.any() and (hidden["Bentlight Disk"][square] == 0).all() and (hidden["Combined"][square] > 0).all()
    drawn = np.maximum(np.linalg.norm(place[..., :2], axis=-1), MASS / 2)  # less where no surface is: r = 2 there
    r = drawn * (1 + MASS / (2 * drawn)) ** 2 / MASS
    lit = (disk.max(axis=-1) > 0) & (r > 2 * disk_isco(0.0))
    part = MASS / (2 * DISTANCE)
    lapse = (1 - part) / (1 + part)
    shift = passes["Bentlight Frequency Shift"][..., 0]
    assert lit.sum() > 50
    # The camera is not infinitely far: light that reaches it leaves the disk with a little angular momentum.
    assert shift[lit].mean() == pytest.approx((np.sqrt(1 - 3 / r[lit]) / lapse).mean(), rel=5e-3)


def test_a_disk_that_reaches_out_of_its_sphere_moves_there_too(tmp_path):
    """Outside space is flat and nothing shifts by gravity, but matter on circular orbits still does by its motion:
    face on g = sqrt((1 - 3M/r) / (1 - 2M/r))."""
    hole = hole_before_the_camera()
    hole.bentlight.disk.enable, hole.bentlight.disk.inner_edge = True, "CUSTOM"
    hole.bentlight.disk.inner_radius, hole.bentlight.sphere_radius = 8.0, 2.0
    bpy.context.scene.view_layers[0].use_pass_position = True
    passes = stage.render(tmp_path)
    drawn = np.linalg.norm(passes["Position"][..., :2], axis=-1)
    r = drawn * (1 + MASS / (2 * np.maximum(drawn, MASS))) ** 2 / MASS
    lit = (passes["Bentlight Disk"].max(axis=-1) > 0) & (drawn > 2.1)
    assert lit.sum() > 50
    expected = np.sqrt((1 - 3 / r[lit]) / (1 - 2 / r[lit]))
    np.testing.assert_allclose(passes["Bentlight Frequency Shift"][..., 0][lit], expected, rtol=1e-3)


def parallel_rays() -> tuple[np.ndarray, np.ndarray]:
    """Starts and directions (3072, 3) of an orthographic camera's rays, 7.2 wide, from z = DISTANCE down."""
    starts = np.full((48, 64, 3), DISTANCE)
    starts[..., :2] = (pixel_centers() - 0.5) * (7.2, 5.4)
    return starts.reshape(-1, 3), np.tile([0.0, 0.0, -1.0], (64 * 48, 1))


def test_deflection_of_parallel_rays(tmp_path):
    """A flat picture shows a place of the wall where it is; the sky, all of which it sees in each pixel, nowhere."""
    stage.add_square(60, (0, 0, -5), stage.emission((1, 1, 1)))
    hole_before_the_camera()
    camera = bpy.context.scene.camera.data
    camera.type, camera.ortho_scale = "ORTHO", 7.2
    passes = stage.render(tmp_path)
    found, fate = passes["Bentlight Deflection"], passes["Bentlight Fate"][..., 0]
    space = Scene()
    square = np.array([[-30, -30, -5], [30, -30, -5], [30, 30, -5], [-30, 30, -5]], np.float32)
    space.add_instance(space.add_mesh(square, np.array([[0, 1, 2], [0, 2, 3]], np.uint32)), np.eye(4))
    space.set_spacetime(Spacetime.schwarzschild(MASS, "isotropic"), np.eye(4))
    space.commit()
    hits = space.intersect(*parallel_rays(), 1e-5)
    on_wall = (hits["fate"] == 4).reshape(48, 64)
    assert np.array_equal(found[..., 2] == 1, on_wall) and 0.8 < on_wall.mean() < 1
    expected = hits["position"].reshape(48, 64, 3)[on_wall][:, :2] / (7.2, 5.4) + 0.5
    np.testing.assert_allclose(found[on_wall][:, :2], expected, atol=1e-4)
    assert np.linalg.norm(expected - pixel_centers()[on_wall], axis=1).min() > 0.01, "the wall is moved everywhere"
    bpy.data.objects.remove(bpy.data.objects["Square"])
    passes = stage.render(tmp_path)
    assert not passes["Bentlight Deflection"].any()
    assert ((passes["Bentlight Fate"][..., 0] == 1) | (fate == 2)).all()


def equirectangular(places: np.ndarray) -> np.ndarray:
    """Directions of places in a picture of all of the sky; -z is in its middle."""
    east, north = (places[..., 0] - 0.5) * 2 * np.pi, (places[..., 1] - 0.5) * np.pi
    return np.stack([np.cos(north) * np.sin(east), np.sin(north), -np.cos(north) * np.cos(east)], axis=-1)


def equidistant(places: np.ndarray) -> np.ndarray:
    """Directions of places in the picture of a fisheye of 240 degrees, whose circle is stretched to its four edges.
    (Places outside of it get some direction too.)"""
    across = (places - 0.5) * 2
    radius = np.linalg.norm(across, axis=-1, keepdims=True)
    away = radius * np.radians(120)
    return np.concatenate([across / np.maximum(radius, 1e-9) * np.sin(away), -np.cos(away)], axis=-1)


PANORAMAS = {
    "EQUIRECTANGULAR": (equirectangular, {}),
    "FISHEYE_EQUIDISTANT": (equidistant, {"fisheye_fov": 4 * np.pi / 3}),
}


@pytest.mark.parametrize("kind", PANORAMAS)
def test_deflection_of_panoramas(kind, tmp_path):
    """The map leads to where the lens' own formula has the direction in which trace_rays lets the ray leave."""
    direction_of, settings = PANORAMAS[kind]
    hole_before_the_camera()
    camera = bpy.context.scene.camera.data
    camera.type, camera.panorama_type = "PANO", kind
    for name, value in settings.items():
        setattr(camera, name, value)
    found = stage.render(tmp_path)["Bentlight Deflection"]
    rays = direction_of(pixel_centers()).reshape(-1, 3)
    origins = np.tile([0.0, 0.0, DISTANCE], (len(rays), 1))
    traced = trace_rays(Spacetime.schwarzschild(MASS, "isotropic"), origins, rays, tolerance=1e-9)
    out, seen = traced["direction"].reshape(48, 64, 3), found[..., 2] == 1
    escapes = traced["fate"].reshape(48, 64) == 1
    if kind == "EQUIRECTANGULAR":
        assert np.array_equal(seen, escapes)
    else:  # the picture's corners have no rays, and what comes from behind is not in the picture
        inside = np.linalg.norm(pixel_centers() - 0.5, axis=-1) <= 0.5
        assert np.array_equal(seen, inside & escapes & (out[..., 2] <= 0.5))
    assert seen.mean() > 0.5
    np.testing.assert_allclose(direction_of(found[seen][:, :2].astype(float)), out[seen], atol=2e-6)
    assert np.linalg.norm(found[seen][:, :2] - pixel_centers()[seen], axis=1).max() > 0.05


def test_deflection_of_a_wormhole_ends_at_its_throat(tmp_path):
    """Rays with an impact parameter below the throat's radius come out elsewhere, where no flat picture sees anything;
    the others, if not behind the camera, where the core's rays do.
    In the sphere's chart r = R + throat^2 / 4R; beyond it they are straight."""
    throat, sphere = 1.0, 3.0
    hole_before_the_camera().bentlight.kind = "NONE"
    bpy.ops.bentlight.wormhole_add(throat_radius=throat, location=(0, 0, 0), exit_location=(0, 500, 0))
    for obj in bpy.context.scene.objects:
        if obj.bentlight.kind == "WORMHOLE":
            obj.bentlight.sphere_radius = sphere
    found = stage.render(tmp_path)["Bentlight Deflection"].reshape(-1, 3)
    slope = slopes(pixel_centers()).reshape(-1, 2)
    rays = np.concatenate([slope, -np.ones((len(slope), 1))], axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    impact = DISTANCE * np.sqrt(1 - rays[:, 2] ** 2)
    space, far = Scene(), np.eye(4)
    far[1, 3] = 500.0
    mouth = Spacetime.ellis(throat)
    space.set_spacetime_objects([(mouth, np.eye(4), sphere, 1), (mouth, far, sphere, 0)])
    space.commit()
    out = space.intersect(np.tile([0.0, 0.0, DISTANCE], (len(rays), 1)), rays, 1e-9)["direction"]
    bent = np.linalg.norm(out - rays, axis=1)
    through = impact * (1 + (throat / (2 * sphere)) ** 2) < throat
    seen = ~through & (out[:, 2] < 0)
    assert np.array_equal(found[:, 2] == 1, seen) and through.sum() > 100 and (~through & ~seen).sum() > 10
    assert np.array_equal(bent[seen] > 1e-9, impact[seen] < sphere) and bent[seen].max() > 0.5
    np.testing.assert_allclose(slopes(found[seen][:, :2]), out[seen][:, :2] / -out[seen][:, 2:], rtol=1e-3, atol=1e-3)
