"""A black hole in the middle of an ordinary room.

The hole has the mass M = 0.1: its horizon is a sphere of radius M/2 = 0.05 around the room's middle, smaller than an
orange. What you see as the black disk is its shadow, ten times wider, because every ray that comes closer than the
photon sphere falls in. The wall behind forms an Einstein ring around it, and stones float within 3 M of the horizon.
"""

import math

import bpy
import common
import materials
import mathutils
import numpy as np
import objects

MASS = 0.1
CENTER = (0.0, 0.0, 1.65)


def build(spin: float = 0.0, stones: bool = True) -> bpy.types.Scene:
    """Makes the scene in the current file and returns it. spin: a/M of the hole; stones: whether some float there."""
    scene = common.new_scene(samples=64)
    scene.bentlight.max_bounces = 8
    build_room()
    build_furniture()
    bpy.ops.bentlight.black_hole_add(mass=MASS, spin=spin, location=CENTER)
    bpy.context.object.name = "Black hole"
    if stones:
        build_stones(MASS, horizon_radius(MASS, spin))
    objects.camera((0.3, -5.3, 2.0), (0.05, 0.0, 1.42), lens_mm=30)
    return scene


def build_room() -> None:
    """A closed room, 7 wide, 9 deep, 3.6 high, with one big lamp under the ceiling and a window behind the camera."""
    tiles = materials.image_from_pixels("Tiles", materials.tile_pattern())
    wall = materials.textured("Tiled wall", tiles, (1.25, 1.25), roughness=0.35)
    plaster = materials.principled("Plaster", (0.80, 0.77, 0.72), roughness=0.9)
    red = materials.principled("Red plaster", (0.60, 0.13, 0.08), roughness=0.9)
    green = materials.principled("Green plaster", (0.12, 0.36, 0.20), roughness=0.9)
    floor = materials.checker("Floor", (0.55, 0.50, 0.44), (0.16, 0.13, 0.11), 2.0, roughness=0.25)
    objects.quad("Back wall", (-3.5, 3.2, 0), (7, 0, 0), (0, 0, 3.6), wall)
    objects.quad("Front wall", (3.5, -5.8, 0), (-7, 0, 0), (0, 0, 3.6), plaster)
    objects.quad("Left wall", (-3.5, -5.8, 0), (0, 9, 0), (0, 0, 3.6), red)
    objects.quad("Right wall", (3.5, 3.2, 0), (0, -9, 0), (0, 0, 3.6), green)
    objects.quad("Floor", (-3.5, -5.8, 0), (7, 0, 0), (0, 9, 0), floor)
    objects.quad("Ceiling", (-3.5, 3.2, 3.6), (7, 0, 0), (0, -9, 0), plaster)
    objects.area_light("Ceiling lamp", (0, 0.2, 3.58), (0, 0.2, 0), (4.2, 3.6), 230, (1.0, 0.93, 0.82))
    objects.area_light("Window", (0, -5.78, 2.0), (0, 0, 2.0), (4.0, 2.0), 70, (0.75, 0.87, 1.0))


def build_furniture() -> None:
    """Suzanne, a glass and a metal sphere, on plinths around the hole."""
    stone = materials.principled("Stone", (0.72, 0.70, 0.66), roughness=0.8)
    clay = materials.principled("Glazed clay", (0.85, 0.30, 0.06), roughness=0.3)
    glass = materials.principled("Glass", (1, 1, 1), roughness=0.0, transmission_weight=1.0, ior=1.5)
    brass = materials.principled("Brass", (0.90, 0.66, 0.28), roughness=0.12, metallic=1.0)
    objects.box("Left plinth", (-1.75, 0.9, 0.40), (0.9, 0.9, 0.8), stone, 12)
    objects.suzanne((-1.75, 0.9, 1.28), 1.15, 22, clay)
    objects.box("Right plinth", (1.85, 1.2, 0.40), (0.9, 0.9, 0.8), stone, -14)
    objects.sphere("Brass sphere", (1.85, 1.2, 1.25), 0.45, brass)
    objects.sphere("Glass sphere", (1.05, -0.7, 0.45), 0.45, glass)
    objects.box(
        "Cube",
        (-0.95, -0.9, 0.25),
        (0.5, 0.5, 0.5),
        materials.principled("Blue", (0.06, 0.16, 0.48), roughness=0.4),
        35,
    )


def horizon_radius(mass: float, spin: float) -> float:
    """How large the horizon is drawn in the scene, at its equator."""
    return mass / 2 if spin == 0 else mass * math.hypot(1 + math.sqrt(1 - spin**2), spin)


def build_stones(mass: float, horizon: float, count: int = 240) -> None:
    """A tilted ring of tetrahedra as one mesh, from 1 M above the horizon to 6 M, in reproducible disorder."""
    random = np.random.default_rng(7)
    tetrahedron = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / math.sqrt(3)
    tilt = np.array(mathutils.Euler((math.radians(14), math.radians(-18), 0)).to_matrix())
    vertices, faces = [], []
    for i in range(count):
        angle = 2.4 * i  # the golden angle spreads them evenly
        radius = horizon + mass * (1.0 + 5.0 * i / count)
        place = tilt @ (radius * math.cos(angle), radius * math.sin(angle), mass * random.normal(0, 0.1))
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        turn *= np.sign(np.linalg.det(turn))
        vertices.extend(tetrahedron @ turn.T * mass * random.uniform(0.12, 0.30) + place + CENTER)
        faces.extend((4 * i + a, 4 * i + b, 4 * i + c) for a, b, c in ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)))
    stones = objects.add_mesh("Stones", vertices, faces)
    stones.data.materials.append(materials.principled("Pale stone", (0.75, 0.68, 0.56), roughness=0.7))
    stones.data.materials.append(materials.principled("Amber stone", (0.90, 0.30, 0.04), roughness=0.35))
    amber = np.repeat(np.arange(count) % 3 > 0, 4)
    stones.data.polygons.foreach_set("material_index", amber.astype(np.int32))


if __name__ == "__main__":
    common.main(build, "room_schwarzschild.png")
