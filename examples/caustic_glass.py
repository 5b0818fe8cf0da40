"""Caustics: one small lamp, what crystal, glass and gold make of its light, and a black hole in front of it.

The lamp stands low behind the table, outside of the picture. A ball of glass gathers light one and a half radii behind
its center, here just above the table; each facet of the crystal throws a patch of its own, the ring a bow. Paths that
start at the camera can only stumble upon a lamp this small through glass, so that light is followed from the lamp as
well: past the hole it bends like any other, and so do the camera's rays, which see the bright figures drawn around it.
"""

import math

import bpy
import common
import materials
import objects

MASS = 0.013
CENTER = (0.31, -0.76, 0.35)
LAMP = (-0.85, 1.95, 1.2)


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


def crystal(name: str, center: objects.Vector, radius: float, material: bpy.types.Material) -> None:
    """A ball of 80 flat facets."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=radius, location=center, rotation=(0.3, 0.2, 0.5))
    bpy.context.object.name = name
    objects.place(bpy.context.object, material)


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene(samples=96)
    table = materials.principled("Table", (0.72, 0.68, 0.61), roughness=0.9)
    clear = materials.shader("Glass", "BsdfGlass", Color=(0.98, 1.0, 0.99, 1.0), Roughness=0.1, IOR=1.5)
    amber = materials.shader("Amber", "BsdfGlass", Color=(1.0, 0.70, 0.28, 1.0), Roughness=0.1, IOR=1.5)
    gold = materials.principled("Gold", (1.0, 0.72, 0.29), metallic=1.0, roughness=0.25)
    objects.quad("Table", (-6, -4, 0), (12, 0, 0), (0, 10, 0), table)
    crystal("Crystal", (-0.44, 0.02, 0.20), 0.21, clear)
    objects.sphere("Ball", (0.11, 0.08, 0.19), 0.19, amber)
    ring("Ring", (0.66, -0.12, 0.08), 0.23, 0.16, gold)
    lamp = objects.area_light("Lamp", LAMP, (0.1, -0.1, 0.1), (0.07, 0.07), 60, (1.0, 0.93, 0.82), "DISK")
    lamp.visible_camera = False  # around the hole it would be seen, too bright for any picture
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=CENTER)
    objects.set_world((0.020, 0.026, 0.036))
    objects.camera((0.13, -2.1, 1.75), (0.10, -0.22, 0.02), lens_mm=44)
    scene.bentlight.integrator = "BIDIRECTIONAL"
    scene.bentlight.max_bounces = 8
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    return scene


if __name__ == "__main__":
    common.main(build, "caustic_glass.png")
