"""Directions in the sky by the engine, the lens and the relay camera, against the core's rays, pixel by pixel.

No pixel is left out: what may be wrong with a ray grows as the ray itself magnifies errors of its start, which it does
without bound toward the shadow's edge. Limits are of errors before this magnification.
"""

import agreement
import bpy
import numpy as np
import pytest
from bentlight_native import FATES, trace_rays

from blender_addon.sync import left_out, spacetime

MOST, MEAN_SQUARE = 1e-6, 2e-7  # radians; the engine is asked for the former, float32 makes the latter of all three


def sky(name: str, place: str, sphere: float) -> tuple[bpy.types.Scene, list[bpy.types.Object]]:
    """A world that shows directions, one ray a pixel."""
    scene = agreement.new_scene()
    agreement.point_samples(scene)
    agreement.show_directions(scene)
    scene.bentlight.tolerance = MOST
    holes = agreement.add_hole(name, sphere)
    agreement.add_camera(name, agreement.PLACES[place], holes[0])
    return scene, holes


def unbounded(name: str, holes: list[bpy.types.Object]) -> agreement.Trace:
    """Rays through space that is bent out to infinity."""
    space, scale = agreement.space_of(name), holes[0].matrix_world.median_scale
    here, there = (np.array(hole.matrix_world.to_3x3().normalized()) for hole in (holes[0], holes[-1]))
    origin = np.array(holes[0].matrix_world.translation)

    def trace(starts, ahead):
        rays = trace_rays(space, (starts - origin) @ here / scale, ahead @ here, 1e-10)
        near, far = (rays["fate"][:, None] == FATES.index(fate) for fate in ("escaped", "escaped on the far side"))
        beyond = rays["direction"] * (1, -1, 1) @ there.T
        return np.where(near, rays["direction"] @ here.T, np.where(far, beyond, np.nan))

    return trace


def compare(
    scene: bpy.types.Scene, way: str, holes: list[bpy.types.Object], trace: agreement.Trace
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions as shown and as traced, (pixels, 3), NaN where lost; and how much each ray magnifies errors."""
    ahead = agreement.camera_rays(scene, way, holes)
    shown = agreement.pictures(scene, way)[0].reshape(-1, 3)
    shown[np.linalg.norm(shown, axis=1) < 0.5] = np.nan
    start = np.tile(np.array(scene.camera.matrix_world.translation), (len(ahead), 1))
    size = agreement.SPHERE * holes[0].matrix_world.median_scale
    return shown, trace(start, ahead), agreement.magnification(trace, start, ahead, size)


def check(shown: np.ndarray, truth: np.ndarray, magnified: np.ndarray) -> None:
    """Rays are lost as in truth, unless next to nothing decides it, and end where they truly do."""
    clear = np.isfinite(magnified)
    assert clear.mean() > 0.998
    lost = np.isnan(truth[:, 0])
    assert (np.isnan(shown[:, 0]) == lost)[clear].all(), "the shadow is another"
    error = np.linalg.norm(shown - truth, axis=1)[clear & ~lost] / magnified[clear & ~lost]
    assert len(error) > len(shown) / 8
    assert np.sqrt(np.mean(error**2)) < MEAN_SQUARE
    assert error.max() < MOST


@pytest.mark.parametrize(("name", "place"), agreement.CASES)
def test_every_pixel_sees_where_the_core_does(name, place):
    """Through the same sphere of influence; near the hole the camera is inside of it."""
    scene, holes = sky(name, place, agreement.SPHERE)

    def trace(starts, ahead):
        return agreement.seen(agreement.by_core(holes, starts, ahead))

    for way in agreement.WAYS:
        check(*compare(scene, way, holes, trace))


@pytest.mark.parametrize("place", ["far", "near"])
@pytest.mark.parametrize("name", agreement.SPINS)
def test_space_that_is_bent_everywhere(name, place):
    """By the engine and the relay; around mouths half-way to each other, which leaves out next to nothing."""
    scene, holes = sky(name, place, 0.0)
    for way in ("engine", "relay"):
        check(*compare(scene, way, holes, unbounded(name, holes)))


@pytest.mark.parametrize("place", ["far", "near"])
@pytest.mark.parametrize("name", agreement.SPINS)
def test_a_lens_leaves_out_what_the_panel_says(name, place):
    """Of every ray that sees the sky in both spaces; and those that just pass by a lens show that it is no less."""
    scene, holes = sky(name, place, agreement.SPHERE)
    shown, truth, magnified = compare(scene, "lens", holes, unbounded(name, holes))
    item = spacetime.read_spacetime(holes[0], holes[0].matrix_world)
    radius = agreement.SPHERE * item.scale
    stated = left_out.missing_bending(item, radius)
    error = np.linalg.norm(shown - truth, axis=1)
    assert np.isfinite(error).mean() > 1 / 8
    assert np.nanmax(error / magnified) < stated
    if place == "far":
        center = item.origin - scene.camera.matrix_world.translation
        closest = np.linalg.norm(np.cross(agreement.camera_rays(scene, "lens", holes), center), axis=1)
        assert 0.85 * stated < error[closest > radius].max() < stated
