"""Caustics: one small lamp, glass, a golden ring, and a black hole that hangs over the table among them.

What the glass gathers falls onto the table as bright figures, and so does what the ring reflects. Paths that start at
the camera can only stumble upon a lamp this small through glass, so that light is followed from the lamp as well: past
the hole it bends like any other, and draws out the figures behind it.
"""

import math

import bpy
import common
import materials
import objects

MASS = 0.022
CENTER = (0.4, 0.12, 0.34)
LAMP = (-2.0, 1.7, 1.5)


def ring(name: str, center: objects.Vector, radius: float, thickness: float, material: bpy.types.Material) -> None:
    """A smooth band that stands on its edge, upright like a napkin ring."""
    sides, profile = 128, ((-0.5, 0.9), (-0.35, 1), (0.35, 1), (0.5, 0.9), (0.5, 0.85), (-0.5, 0.85))
    vertices, faces = [], []
    for i in range(sides):
        turn = 2 * math.pi * i / sides
        for height, part in profile:
            r = radius * part
            vertices.append((r * math.cos(turn), r * math.sin(turn), height * thickness))
    n = len(profile)
    for i in range(sides):
        for k in range(n):
            a, b = i * n + k, (i + 1) % sides * n + k
            c, d = (i + 1) % sides * n + (k + 1) % n, i * n + (k + 1) % n
            faces.append((a, b, c, d))
    band = objects.add_mesh(name, vertices, faces, material)
    band.location = center
    for polygon in band.data.polygons:
        polygon.use_smooth = True


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene(samples=24)
    table = materials.principled("Table", (0.62, 0.56, 0.48), roughness=0.8)
    wall = materials.principled("Wall", (0.16, 0.20, 0.24), roughness=0.9)
    clear = materials.shader("Glass", "BsdfGlass", Color=(0.98, 1.0, 0.99, 1.0), Roughness=0.0, IOR=1.5)
    amber = materials.shader("Amber", "BsdfGlass", Color=(1.0, 0.62, 0.18, 1.0), Roughness=0.0, IOR=1.55)
    gold = materials.principled("Gold", (1.0, 0.72, 0.29), metallic=1.0, roughness=0.08)
    objects.quad("Table", (-4, -4, 0), (8, 0, 0), (0, 6, 0), table)
    objects.quad("Wall", (-4, 2, 0), (8, 0, 0), (0, 0, 4), wall)
    objects.suzanne((-0.38, 0.02, 0.27), 0.56, 14, clear)
    objects.sphere("Ball", (0.12, -0.45, 0.16), 0.16, amber)
    ring("Ring", (0.72, -0.52, 0.09), 0.2, 0.18, gold)
    objects.area_light("Lamp", LAMP, (0.1, -0.1, 0.1), (0.05, 0.05), 130, (1.0, 0.93, 0.82), "DISK")
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=CENTER)
    objects.set_world((0.010, 0.013, 0.018))
    objects.camera((0.28, -2.25, 1.2), (0.17, -0.27, 0.12), lens_mm=41)
    scene.bentlight.integrator = "BIDIRECTIONAL"
    scene.bentlight.max_bounces = 8
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    return scene


if __name__ == "__main__":
    common.main(build, "caustic_glass.png")
