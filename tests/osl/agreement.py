"""One scene rendered three ways: by the engine, by Cycles through a lens, and by Cycles' relay camera.

All three bend light in the same sphere around the hole and take the same camera rays, so that their pictures can be
compared with each other, and with the core's own rays as the truth. Lengths are in the hole's own units, in which the
critical impact parameter is near 1; the hole itself is turned and scaled in the scene.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import bpy
import common
import mathutils
import numpy as np
import objects
import pytest
import rendering
from bentlight_native import FATES, Scene, Spacetime

from blender_addon.sync import spacetime

ESCAPED = FATES.index("escaped")
MASS, THROAT, SPHERE = 0.2, 1.0, 2.4
SPINS = {"schwarzschild": 0.0, "kerr 0.6": 0.6, "kerr 0.9": 0.9, "kerr 0.998": 0.998, "ellis": None}
WAYS = ("engine", "lens", "relay")
_SCALE = 1.5  # of the hole in the scene


Trace = Callable[[np.ndarray, np.ndarray], np.ndarray]  # starts and directions to directions in the sky


class Place(NamedTuple):
    """Where the camera stands, at azimuth -90 degrees, and looks."""

    radius: float | None  # areal; None: 1.2 times that of the horizon or throat
    polar_deg: float  # from the axis
    turned_deg: float  # from toward the center, eastward
    view_deg: float  # the picture's width


PLACES = {
    "far": Place(8.0, 80.0, 0.0, 40.0),
    "near": Place(1.2, 80.0, 40.0, 90.0),
    "axis": Place(5.0, 1.2, 0.0, 60.0),
    "horizon": Place(None, 60.0, 150.0, 90.0),
    "mouth": Place(None, 60.0, 60.0, 90.0),
}
CASES = [
    pytest.param(name, place, id=f"{name}-{place}")
    for name, spin in SPINS.items()
    for place in ("far", "near", "axis", "mouth" if spin is None else "horizon")
]


def new_scene(width: int = 48, height: int = 27) -> bpy.types.Scene:
    """An empty scene; what is black in its pictures is lost."""
    scene = common.new_scene("CYCLES", samples=1, resolution=(width, height))
    scene.view_settings.view_transform = "Raw"
    scene.bentlight.max_bounces = scene.cycles.max_bounces = 0
    scene.bentlight.photon_ring_samples = 1
    return scene


def point_samples(scene: bpy.types.Scene) -> None:
    """One ray a pixel: in its very middle, where Cycles has its first sample, or within a hundredth of a pixel."""
    scene.cycles.pixel_filter_type, scene.bentlight.pixel_filter = "BOX", "GAUSSIAN"
    scene.render.filter_size = 0.003  # a third of the filter's reach
    scene.bentlight.relay_parts = 1


def box_samples(scene: bpy.types.Scene) -> None:
    """Rays all over each pixel, which is their mean; without Cycles' first sample, the same for all seeds."""
    scene.cycles.pixel_filter_type = scene.bentlight.pixel_filter = "BOX"
    scene.cycles.use_sample_subset, scene.cycles.sample_offset, scene.cycles.sample_subset_length = True, 1, 10000


def show_directions(scene: bpy.types.Scene) -> None:
    """The world's color is its direction, a unit vector."""
    scene.world.cycles.sampling_method = "NONE"
    tree = scene.world.node_tree
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], tree.nodes["Background"].inputs["Color"])


def add_hole(name: str, sphere: float = SPHERE, exit_at: float = 3e4) -> list[bpy.types.Object]:
    """A hole at the origin; for a wormhole also the other mouth: about `exit_at` away, turned, of another size.
    sphere: 0 is as far as the engine can."""
    if SPINS[name] is None:
        bpy.ops.bentlight.wormhole_add(
            throat_radius=THROAT, location=(0, 0, 0), exit_location=exit_at * np.array((0.9, 0.3, 0.3))
        )
        holes = [obj for obj in bpy.context.scene.objects if obj.bentlight.kind == "WORMHOLE"]
        holes.sort(key=lambda obj: obj.location.length)
        holes[1].rotation_euler, holes[1].scale = (0.3, 0.5, 1.2), (2 * _SCALE,) * 3
        holes[1].bentlight.throat_radius, holes[1].bentlight.sphere_radius = THROAT / 2, sphere / 2
    else:
        bpy.ops.bentlight.black_hole_add(mass=MASS, spin=SPINS[name], location=(0, 0, 0))
        holes = [bpy.context.object]
    holes[0].scale, holes[0].rotation_euler = (_SCALE,) * 3, (0.5, 0.3, 0.2)
    holes[0].bentlight.sphere_radius = sphere
    bpy.context.view_layer.update()
    return holes


def space_of(name: str) -> Spacetime:
    """For the core, in the hole's own units."""
    spin = SPINS[name]
    if spin is None:
        return Spacetime.ellis(THROAT)
    return Spacetime.kerr(MASS, spin * MASS) if spin else Spacetime.schwarzschild(MASS)


def chart_point(name: str, place: Place) -> np.ndarray:
    """A camera's place as the chart draws it, in the hole's own units."""
    spin = SPINS[name]
    a = MASS * (spin or 0.0)
    horizon = THROAT if spin is None else MASS + math.sqrt(MASS**2 - a**2)
    r = R = place.radius or 1.2 * horizon
    if spin is None:
        R = (r + math.sqrt(r**2 - THROAT**2)) / 2
    elif spin == 0:
        R = (r - MASS + math.sqrt(r**2 - 2 * MASS * r)) / 2
    polar = math.radians(place.polar_deg)
    return np.array([0.0, -math.hypot(R, a) * math.sin(polar), R * math.cos(polar)])


def add_camera(name: str, place: Place, hole: bpy.types.Object) -> bpy.types.Object:
    """The scene's camera at a place."""
    point, turned = mathutils.Vector(chart_point(name, place)), math.radians(place.turned_deg)
    ahead = math.sin(turned) * mathutils.Vector((1, 0, 0)) - math.cos(turned) * point.normalized()
    camera = objects.camera(hole.matrix_world @ point, hole.matrix_world @ (point + ahead))
    camera.data.sensor_fit, camera.data.angle = "HORIZONTAL", math.radians(place.view_deg)
    camera.data.clip_start = 1e-3
    bpy.context.view_layer.update()
    return camera


def pictures(scene: bpy.types.Scene, way: str, seeds: int = 1, samples: int = 1) -> np.ndarray:
    """(seeds, height, width, 3), linear; leaves the scene as it was. With the relay, what scatters goes by the lens."""
    engine = "BENTLIGHT" if way == "engine" else "CYCLES"
    scene.render.engine = engine
    lenses = way != "engine" and any(obj.bentlight.kind != "NONE" and not obj.hide_render for obj in scene.objects)
    if lenses:
        assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    if way == "relay":
        assert bpy.ops.bentlight.relay_setup(bake=False) == {"FINISHED"}
    found = np.stack([rendering.render(scene, engine, seed, samples) for seed in range(seeds)])
    if way == "relay":
        assert bpy.ops.bentlight.relay_clear() == {"FINISHED"}
    if lenses:
        assert bpy.ops.bentlight.cycles_clear() == {"FINISHED"}
    return found


def camera_rays(scene: bpy.types.Scene, way: str, holes: list[bpy.types.Object]) -> np.ndarray:
    """(pixels, 3): the directions that camera rays start in, from a picture of directions without the holes."""
    for hole in holes:
        hole.hide_render = True
    found = pictures(scene, way)[0].reshape(-1, 3)
    for hole in holes:
        hole.hide_render = False
    return found


def by_core(holes: list[bpy.types.Object], starts: np.ndarray, ahead: np.ndarray) -> dict[str, np.ndarray]:
    """Rays from `starts`, (3,) or (n, 3), through the holes' spheres by the core, far more exactly than by shaders."""
    placed = []
    for hole in holes:
        item = spacetime.read_spacetime(hole, hole.matrix_world)
        if item.kind == "WORMHOLE":
            space, leads_to = Spacetime.ellis(item.throat_radius), holes.index(hole.bentlight.exit)
        elif item.spin:
            space, leads_to = Spacetime.kerr(item.mass, item.spin * item.mass), -1
        else:
            chart = {"ISOTROPIC": "isotropic", "OBLATE": "areal"}[item.chart]
            space, leads_to = Spacetime.schwarzschild(item.mass, chart), -1
        placed.append((space, item.world_from_spacetime, item.sphere_radius * item.scale, leads_to))
    core = Scene()
    core.set_spacetime_objects(placed)
    core.commit()
    starts = np.ascontiguousarray(np.broadcast_to(np.array(starts, float), ahead.shape))
    return core.intersect(starts, ahead, 1e-9, angular_tolerance=1e-10)


def seen(rays: dict[str, np.ndarray]) -> np.ndarray:
    """Directions in the sky, NaN where a ray is lost."""
    return np.where((rays["fate"] == ESCAPED)[:, None], rays["direction"], np.nan)


def magnification(trace: Trace, starts: np.ndarray, ahead: np.ndarray, size: float) -> np.ndarray:
    """How many times farther off rays may end than they start: (n,), infinite where next to nothing decides their fate.

    The derivatives of where they end, by their direction and, in parts of `size`, by their start: Frobenius norms.
    """
    shift = 1e-7
    base, turned, moved = trace(starts, ahead), np.zeros(len(ahead)), np.zeros(len(ahead))
    for axis in shift * np.eye(3):
        turned += np.sum((trace(starts, ahead + axis) - base) ** 2, axis=1)
        moved += np.sum((trace(starts + size * axis, ahead) - base) ** 2, axis=1)
    total = (np.sqrt(turned) + np.sqrt(moved)) / shift
    return np.where(np.isnan(total), np.where(np.isnan(base[:, 0]), 1.0, np.inf), total)


def only_shader(name: str, kind: str, color: tuple[float, float, float]) -> bpy.types.Material:
    """A material of one shader node, of this type and color."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):  # where they are optional
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*color, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material
