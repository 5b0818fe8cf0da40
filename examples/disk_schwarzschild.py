"""A hot disk around a black hole without spin, as Luminet drew it in 1979, in color: the side that comes towards you is
brighter and bluer, the far side is bent up over the hole, its underside down below, and a thin ring follows the shadow.
"""

import math

import bpy
import common
import objects

INCLINATION = math.radians(80)  # from the axis
DISTANCE = 60.0


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    return hole_with_disk(spin=0.0, inclination=INCLINATION)


def hole_with_disk(spin: float, inclination: float, outer: float = 20.0) -> bpy.types.Scene:
    """A hole of mass 1 and its disk, seen from afar, in empty space."""
    scene = common.new_scene(samples=64)
    scene.bentlight.max_bounces = 0
    scene.view_settings.view_transform, scene.view_settings.exposure = "AgX", 0.0
    bpy.ops.bentlight.black_hole_add(mass=1.0, spin=spin, location=(0, 0, 0))
    disk = bpy.context.object.bentlight.disk
    disk.enable = True
    disk.outer_radius = outer
    disk.temperature = 5000.0
    disk.strength = 2.0
    disk.pattern = 0.3
    view = objects.camera((0, -DISTANCE * math.sin(inclination), DISTANCE * math.cos(inclination)), (0, 0, 0))
    view.data.sensor_fit, view.data.angle = "HORIZONTAL", math.radians(45)
    view.data.clip_end = 1000.0
    return scene


if __name__ == "__main__":
    common.main(build, "disk_schwarzschild.png")
