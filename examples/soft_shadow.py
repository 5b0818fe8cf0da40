"""Shadows that a black hole bends: one lamp, a lattice, and a wall behind the hole.

The lamp stands to the left of the camera. Its light goes through the lattice, past the hole, and onto the wall on the
right. There the hole is a lens: opposite the lamp, light that passes it on all sides meets in one bright spot as wide
as the lamp's image, and the straight bars of the lattice throw shadows that bow around it, twice: by light that passes
the hole on the near side, and on the far side. A wider lamp blurs them as it would straight shadows.
"""

import bpy
import common
import materials
import mathutils
import objects

MASS = 0.05
CENTER = mathutils.Vector((0.0, 0.0, 1.4))
LAMP = mathutils.Vector((-3.4, -3.4, 2.3))
WALL = 3.0  # y
BARS = 9


def build_lattice(bars: bpy.types.Material) -> None:
    """Crossed bars, square to the light, half-way between lamp and hole."""
    middle = LAMP.lerp(CENTER, 0.45)
    turn = (CENTER - LAMP).to_track_quat("Z", "Y").to_matrix().to_4x4()
    for k in range(BARS):
        shift = (k - (BARS - 1) / 2) * 0.16
        for size, place in (((0.022, 1.4, 0.022), (shift, 0, 0)), ((1.4, 0.022, 0.022), (0, shift, 0))):
            bpy.ops.mesh.primitive_cube_add(size=1)
            bar = objects.place(bpy.context.object, bars)
            bar.name = "Bar"
            bar.matrix_world = (
                mathutils.Matrix.Translation(middle)
                @ turn
                @ mathutils.Matrix.Translation(place)
                @ mathutils.Matrix.Diagonal((*size, 1))
            )


def build(lamp_radius: float = 0.03) -> bpy.types.Scene:
    """Makes the scene in the current file and returns it. lamp_radius: of the one lamp."""
    scene = common.new_scene(samples=96)
    plaster = materials.principled("Plaster", (0.82, 0.78, 0.70), roughness=0.9)
    floor = materials.principled("Floor", (0.45, 0.42, 0.38), roughness=0.4)
    steel = materials.principled("Steel", (0.25, 0.25, 0.28), roughness=0.5)
    clay = materials.principled("Clay", (0.65, 0.22, 0.10), roughness=0.5)
    objects.quad("Wall", (-8, WALL, 0), (16, 0, 0), (0, 0, 8), plaster)
    objects.quad("Floor", (-8, -8, 0), (16, 0, 0), (0, 11, 0), floor)
    build_lattice(steel)
    for x, y, radius in ((-1.5, 1.6, 0.45), (1.7, 0.7, 0.3), (0.4, -0.9, 0.22)):
        objects.sphere("Ball", (x, y, radius), radius, clay)
    light = bpy.data.lights.new("Lamp", "POINT")
    light.energy, light.shadow_soft_size, light.color = 1500, lamp_radius, (1.0, 0.92, 0.8)
    objects.place(bpy.data.objects.new("Lamp", light), location=LAMP)
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=CENTER)
    objects.set_world((0.012, 0.016, 0.024))
    objects.camera((1.1, -5.6, 1.9), (1.1, 0.0, 1.2), lens_mm=32)
    scene.bentlight.max_bounces = 4
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    return scene


if __name__ == "__main__":
    common.main(build, "soft_shadow.png")
