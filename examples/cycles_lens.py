"""A spinning black hole in Cycles: a courtyard at night, wet stone and neon, every ray of which goes through the lens.

Nothing here is made for Bentlight: the materials are Cycles' own node trees, the light comes from shining tubes and the
stars. *Use in Cycles* adds the lens.
"""

import math

import bpy
import common
import materials
import nodes
import objects

HOLE = (0.0, 0.0, 1.75)
MASS = 0.12
SPIN = 0.9
LENS_RADIUS = 1.7


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene("CYCLES", samples=96)
    scene.view_settings.exposure = 0.6
    nodes.starry_sky((0.10, 0.05, 0.16), (0.004, 0.006, 0.02), 1.0)
    build_courtyard()
    build_neon()
    build_company()
    bpy.ops.bentlight.black_hole_add(mass=MASS, spin=SPIN, location=HOLE)
    hole = bpy.context.object
    hole.rotation_euler = (math.radians(12), math.radians(-8), 0)
    hole.bentlight.lens_radius = LENS_RADIUS
    objects.camera((0.5, -6.6, 1.9), (0, 0, 1.6), lens_mm=34)
    scene.cycles.max_bounces = 6
    bpy.ops.bentlight.cycles_setup()
    return scene


def build_courtyard() -> None:
    """A wet checkered floor and two walls of brick."""
    floor = materials.checker("Floor", (0.34, 0.33, 0.31), (0.05, 0.05, 0.06), 1.2, specular_ior_level=0.6)
    nodes.wet(floor, 0.45, 0.04, 1.1)
    wall = nodes.brick("Brick", (0.36, 0.12, 0.07), (0.22, 0.07, 0.05), (0.30, 0.28, 0.26), 1.6, roughness=0.75)
    objects.quad("Floor", (-6, -8, 0), (12, 0, 0), (0, 12, 0), floor)
    objects.quad("Back wall", (-6, 4, 0), (12, 0, 0), (0, 0, 3.6), wall)
    objects.quad("Left wall", (-4.2, -8, 0), (0, 12, 0), (0, 0, 3.6), wall)
    objects.quad("Right wall", (4.2, 4, 0), (0, -12, 0), (0, 0, 3.6), wall)


def build_neon() -> None:
    """Tubes along the walls, whose straight lines show how space is bent."""
    for name, color, strength, places in (
        ("Cyan", (0.05, 0.75, 1.0), 16, [(0, 3.9, 3.1, 7.6, 0), (0, 3.9, 0.7, 7.6, 0)]),
        ("Rose", (1.0, 0.10, 0.35), 18, [(-4.1, 0, 2.4, 7.0, 90), (-2.6, 3.9, 1.9, 1.7, 0)]),
        ("Amber", (1.0, 0.45, 0.08), 16, [(4.1, 0, 2.4, 7.0, 90), (2.6, 3.9, 1.9, 1.7, 0)]),
    ):
        material = materials.emission(name, color, strength)
        for x, y, z, length, turn_deg in places:
            objects.box(f"{name} tube", (x, y, z), (length, 0.06, 0.06), material, turn_deg)
    lantern = materials.emission("Lantern", (1.0, 0.86, 0.66), 9)
    objects.box("Lantern", (0, -2.5, 4.6), (2.4, 2.4, 0.05), lantern)


def build_company() -> None:
    """Suzanne in gold, columns of marble, and a ball of glass."""
    gold = nodes.hammered(materials.principled("Gold", (1.0, 0.72, 0.29), roughness=0.24, metallic=1.0), 22.0, 0.12)
    marble = nodes.marble("Marble", (0.10, 0.11, 0.13), (0.82, 0.80, 0.76), 2.2, roughness=0.12)
    glass = materials.principled("Glass", (0.95, 1.0, 0.97), roughness=0.0, transmission_weight=1.0, ior=1.45)
    for x in (-2.75, 2.75):
        objects.box("Base", (x, 0.4, 0.4), (0.9, 0.9, 0.8), marble)
    objects.suzanne((-2.75, 0.4, 1.4), 1.3, 25, gold)
    objects.sphere("Marble ball", (2.75, 0.4, 1.35), 0.55, marble)
    objects.sphere("Glass ball", (1.9, -2.4, 0.42), 0.42, glass)


if __name__ == "__main__":
    common.main(build, "cycles_lens.png", "CYCLES")
