"""A hole that spins fast before the stars, its disk as films show it: of one brightness on both sides, a golden ring.
Stars are points, that lensing moves and magnifies and does not stretch.

`--natural` sets the sliders Doppler and Gravitational to 1 instead, which is what one would see.
"""

import functools
import math
import sys

import bpy
import common
import materials
import objects

DISTANCE, INCLINATION = 42.0, math.radians(84)
PLANET = (11.0, -8.0, 5.6)  # lit by the disk


def build(is_natural: bool = False) -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene(samples=64, resolution=(960, 540))
    scene.bentlight.max_bounces = 0
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    stars = scene.world.bentlight
    stars.stars = "PROCEDURAL"
    stars.star_count, stars.star_seed, stars.star_brightest, stars.star_slope = 30_000, 4, 0.0, 0.55
    stars.star_strength = 300.0
    scene.render.filter_size = 1.8
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=0.6, location=(0, 0, 0))
    disk = bpy.context.object.bentlight.disk
    disk.enable = True
    disk.outer_radius, disk.softness = 18.0, 0.6
    disk.emission, disk.temperature, disk.exponent = "POWER_LAW", 4500.0, 0.45
    disk.strength, disk.opacity = 8.0 if is_natural else 3.0, 0.95
    disk.doppler = disk.gravitational = float(is_natural)
    disk.pattern, disk.pattern_scale, disk.loop_orbits = 0.7, 2.0, 2.0
    objects.sphere("Planet", PLANET, 1.1, materials.diffuse("Rock", (0.7, 0.62, 0.55)))
    view = objects.camera((0, -DISTANCE * math.sin(INCLINATION), DISTANCE * math.cos(INCLINATION)), (0, 0, 0))
    view.rotation_euler.rotate_axis("Z", math.radians(-8))
    view.data.sensor_fit, view.data.angle = "HORIZONTAL", math.radians(52)
    view.data.clip_end = 1000.0
    return scene


if __name__ == "__main__":
    natural = "--natural" in sys.argv
    if natural:
        sys.argv.remove("--natural")
    common.main(functools.partial(build, natural), "gargantua_natural.png" if natural else "gargantua.png")
