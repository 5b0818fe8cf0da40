"""A wormhole in Cycles: from a gallery of brick and marble one looks through a bronze gate into a green valley by day.

The two mouths are eighty units apart in one scene, each with a lens that *Use in Cycles* adds. Everything passes: the
daylight falls from the mouth onto the gallery's floor, and the gallery can be seen from the valley.
"""

import math

import bpy
import common
import materials
import nodes
import numpy as np
import objects

THROAT_RADIUS = 1.1
GALLERY_MOUTH = (0.0, 0.0, 1.55)
VALLEY = np.array((0.0, 80.0, 0.0))
LENS_RADIUS = 1.5


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene("CYCLES", samples=128)
    scene.view_settings.exposure = 0.3
    build_gallery()
    build_valley()
    build_day()
    bpy.ops.bentlight.wormhole_add(
        throat_radius=THROAT_RADIUS, location=GALLERY_MOUTH, exit_location=tuple(VALLEY + np.array((0, 0, 2.2)))
    )
    for mouth in (bpy.context.object, bpy.context.object.bentlight.exit):
        mouth.bentlight.lens_radius = LENS_RADIUS
    objects.camera((1.9, -4.9, 1.25), (0.1, 0.0, 1.62), lens_mm=28)
    scene.cycles.max_bounces = 8
    bpy.ops.bentlight.cycles_setup()
    return scene


def build_gallery() -> None:
    """A closed room, dim enough for the daylight from the mouth to be seen on its floor."""
    floor = materials.checker("Gallery floor", (0.30, 0.24, 0.18), (0.12, 0.08, 0.06), 1.0)
    nodes.wet(floor, 0.35, 0.10, 1.4)
    wall = nodes.brick("Gallery wall", (0.42, 0.17, 0.10), (0.30, 0.11, 0.07), (0.42, 0.38, 0.33), 1.5, roughness=0.8)
    plaster = materials.principled("Plaster", (0.5, 0.45, 0.38), roughness=0.9)
    marble = nodes.marble("Gallery marble", (0.30, 0.30, 0.33), (0.86, 0.84, 0.80), 1.8, roughness=0.2)
    warm = materials.emission("Warm light", (1.0, 0.62, 0.34), 9.0)
    objects.quad("Floor", (-4, -6, 0), (8, 0, 0), (0, 10, 0), floor)
    objects.quad("Ceiling", (-4, 4, 4), (8, 0, 0), (0, -10, 0), plaster)
    objects.quad("Back", (-4, 4, 0), (8, 0, 0), (0, 0, 4), wall)
    objects.quad("Front", (4, -6, 0), (-8, 0, 0), (0, 0, 4), wall)
    objects.quad("Left", (-4, -6, 0), (0, 10, 0), (0, 0, 4), wall)
    objects.quad("Right", (4, 4, 0), (0, -10, 0), (0, 0, 4), wall)
    for x in (-3.2, 3.2):
        objects.box("Lamp", (x, 0, 3.95), (0.25, 7, 0.05), warm)
        for y in (-1.5, 1.8):
            bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.3, depth=3.4, location=(x, y, 1.9))
            bpy.ops.object.shade_smooth_by_angle()
            objects.place(bpy.context.object, marble)
            objects.box("Foot", (x, y, 0.1), (0.8, 0.8, 0.2), marble)
            objects.box("Capital", (x, y, 3.7), (0.8, 0.8, 0.25), marble)
    bronze = nodes.hammered(materials.principled("Gate", (0.80, 0.46, 0.22), roughness=0.22, metallic=1.0), 14.0, 0.12)
    bpy.ops.mesh.primitive_torus_add(
        major_radius=1.72,
        minor_radius=0.09,
        major_segments=160,
        minor_segments=32,
        location=GALLERY_MOUTH,
        rotation=(math.pi / 2, 0, 0),
    )
    bpy.ops.object.shade_smooth()
    objects.place(bpy.context.object, bronze)


def build_valley() -> None:
    """Hills of grass, a path of stones, and Suzanne in bronze before the mouth."""
    grass = nodes.marble("Grass", (0.03, 0.11, 0.015), (0.22, 0.34, 0.05), 0.9, roughness=0.9)
    bark = materials.principled("Bark", (0.16, 0.09, 0.05), roughness=0.9)
    leaves = nodes.marble("Leaves", (0.04, 0.12, 0.02), (0.32, 0.36, 0.05), 2.0, roughness=0.8)
    bronze = nodes.hammered(materials.principled("Bronze", (0.85, 0.50, 0.24), roughness=0.2, metallic=1.0), 18.0, 0.15)
    count, size = 120, 90.0
    axis = (np.arange(count) / (count - 1) - 0.5) * size
    x, y = np.meshgrid(axis, axis)
    distance = np.hypot(x, y)
    hills = 0.9 * np.sin(0.21 * x + 1) * np.sin(0.17 * y) + 0.006 * np.maximum(distance - 8, 0) ** 2
    height = np.where(distance < 6, 0, hills * np.clip((distance - 6) / 8, 0, 1))
    vertices = np.stack([x, y, height], axis=-1).reshape(-1, 3)
    index = np.arange(count * count).reshape(count, count)
    faces = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1).reshape(-1, 4)
    ground = objects.add_mesh("Valley", vertices, faces.tolist(), grass)
    ground.location = VALLEY
    ground.data.shade_smooth()
    random = np.random.default_rng(4)
    for i in range(18):
        angle, far = 2 * math.pi * (i + random.uniform(0, 0.7)) / 18, random.uniform(6.5, 14)
        x, y, _ = VALLEY + np.array((far * math.cos(angle), far * math.sin(angle), 0))
        bpy.ops.mesh.primitive_cylinder_add(vertices=16, radius=0.25, depth=5, location=(x, y, 1.5))
        objects.place(bpy.context.object, bark)
        objects.sphere("Crown", (x, y, 4.6), random.uniform(1.3, 2.0), leaves)
    objects.suzanne(tuple(VALLEY + np.array((0.2, 2.7, 2.1))), 2.2, 0, bronze)


def build_day() -> None:
    """A blue sky that pales toward the horizon; its sun is a soft glow, which paths find without a lamp."""
    height, width = 256, 512
    elevation = (np.arange(height) + 0.5)[:, None] / height * math.pi - math.pi / 2
    azimuth = (0.5 - (np.arange(width) + 0.5)[None, :] / width) * 2 * math.pi
    cosines = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    direction = np.stack(np.broadcast_arrays(*cosines), axis=-1)
    up = np.clip(np.sin(elevation), 0, 1)[..., None]
    sky = np.array((1.0, 0.92, 0.80)) * (1 - up) ** 5 + np.array((0.15, 0.38, 0.95)) * (1 - (1 - up) ** 5)
    sun = np.array((-0.5, -0.35, 0.79))
    glow = np.clip(direction @ (sun / np.linalg.norm(sun)), 0, 1)[..., None] ** 40
    sky = 1.7 * sky + np.array((1.0, 0.86, 0.64)) * 40 * glow
    pixels = np.concatenate([sky, np.ones((height, width, 1))], axis=-1)
    objects.set_world_image(materials.float_image("Day", pixels))


if __name__ == "__main__":
    common.main(build, "wormhole_cycles.png", "CYCLES")
