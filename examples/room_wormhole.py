"""A wormhole joins a library at night and a garden by day: two places of one scene, a hundred units apart.

The mouth in the library looks like a glass ball that holds the garden. It is no picture: daylight really falls through
it onto the books, and Suzanne, who stands in the garden, could see the library in the other mouth.
"""

import math

import bpy
import common
import materials
import numpy as np
import objects

THROAT_RADIUS = 0.9
LIBRARY_MOUTH = (0.0, 0.0, 1.7)
GARDEN = np.array((0.0, 120.0, 0.0))


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene(samples=160)
    scene.bentlight.max_bounces = 8
    scene.view_settings.exposure = 0.4  # a long look into a dim room
    build_library()
    build_garden()
    build_sky()
    bpy.ops.bentlight.wormhole_add(
        throat_radius=THROAT_RADIUS, location=LIBRARY_MOUTH, exit_location=tuple(GARDEN + np.array((0, 0, 1.9)))
    )
    objects.camera((0.9, -4.3, 1.75), (0.1, 0.0, 1.6), lens_mm=28)
    return scene


def build_library() -> None:
    """A closed room with books on three walls and two warm lamps, dim enough to see the daylight from the mouth."""
    wood = materials.principled("Wood", (0.16, 0.07, 0.03), roughness=0.35)
    wall = materials.principled("Wall", (0.35, 0.30, 0.24), roughness=0.8)
    carpet = materials.checker("Carpet", (0.36, 0.05, 0.04), (0.20, 0.03, 0.05), 1.0, roughness=0.9)
    objects.quad("Floor", (-3.5, -5, 0), (7, 0, 0), (0, 8, 0), carpet)
    objects.quad("Ceiling", (-3.5, 3, 3.6), (7, 0, 0), (0, -8, 0), wall)
    objects.quad("Back wall", (-3.5, 3, 0), (7, 0, 0), (0, 0, 3.6), wall)
    objects.quad("Front wall", (3.5, -5, 0), (-7, 0, 0), (0, 0, 3.6), wall)
    objects.quad("Left wall", (-3.5, -5, 0), (0, 8, 0), (0, 0, 3.6), wall)
    objects.quad("Right wall", (3.5, 3, 0), (0, -8, 0), (0, 0, 3.6), wall)
    covers = [
        materials.principled(f"Cover {i}", color, roughness=0.5)
        for i, color in enumerate(
            [
                (0.45, 0.06, 0.04),
                (0.05, 0.12, 0.32),
                (0.06, 0.22, 0.10),
                (0.62, 0.42, 0.14),
                (0.70, 0.62, 0.48),
                (0.20, 0.05, 0.16),
            ]
        )
    ]
    random = np.random.default_rng(3)
    build_shelves("Back", (-3.3, 2.98, 0.1), 6.6, 0, wood, covers, random)
    build_shelves("Left", (-3.48, -4.5, 0.1), 7.2, 90, wood, covers, random)
    build_shelves("Right", (3.48, 2.7, 0.1), 7.2, -90, wood, covers, random)
    objects.area_light("Left lamp", (-1.7, -1, 3.55), (-1.7, -1, 0), (1.8, 4.0), 65, (1.0, 0.72, 0.42))
    objects.area_light("Right lamp", (1.7, -1, 3.55), (1.7, -1, 0), (1.8, 4.0), 65, (1.0, 0.72, 0.42))


def build_shelves(
    name: str,
    corner: objects.Vector,
    length: float,
    turn_deg: float,
    wood: bpy.types.Material,
    covers: list[bpy.types.Material],
    random: np.random.Generator,
) -> None:
    """Seven shelves full of books as one mesh; they run along +x and stand toward -y before they are turned."""
    boxes = []  # (low corner, high corner, material index)
    for level in range(7):
        bottom = level * 0.48
        boxes.append(((0, -0.30, bottom - 0.03), (length, 0, bottom), 0))
        x = 0.02
        while x < length - 0.1:
            width, height = random.uniform(0.04, 0.11), random.uniform(0.28, 0.42)
            if random.random() > 0.06:  # some books are out
                boxes.append(
                    (
                        (x, -random.uniform(0.22, 0.27), bottom),
                        (x + width - 0.006, 0, bottom + height),
                        1 + int(random.integers(len(covers))),
                    )
                )
            x += width
    corners = np.array([[(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]], float).reshape(8, 3)
    sides = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    vertices = np.concatenate([low + corners * np.subtract(high, low) for low, high, _ in boxes])
    faces = [tuple(8 * i + c for c in side) for i in range(len(boxes)) for side in sides]
    shelves = objects.add_mesh(f"{name} shelves", vertices, faces)
    for material in (wood, *covers):
        shelves.data.materials.append(material)
    shelves.data.polygons.foreach_set("material_index", np.repeat([box[2] for box in boxes], 6).astype(np.int32))
    shelves.location, shelves.rotation_euler = corner, (0, 0, math.radians(turn_deg))


def build_garden() -> None:
    """A terrace with columns and cypresses around the other mouth; Suzanne looks into it."""
    sand = materials.checker("Terrace", (0.56, 0.46, 0.34), (0.40, 0.31, 0.22), 0.5, roughness=0.8)
    grass = materials.principled("Grass", (0.10, 0.22, 0.04), roughness=0.9)
    marble = materials.principled("Marble", (0.85, 0.83, 0.80), roughness=0.4)
    cypress = materials.principled("Cypress", (0.03, 0.10, 0.03), roughness=0.9)
    bronze = materials.principled("Bronze", (0.80, 0.45, 0.20), roughness=0.25, metallic=1.0)
    x, y, _ = GARDEN
    objects.quad("Grass", (x - 45, y - 45, -0.02), (90, 0, 0), (0, 90, 0), grass)
    objects.quad("Terrace", (x - 8, y - 8, 0), (16, 0, 0), (0, 16, 0), sand)
    for i in range(12):
        angle = 2 * math.pi * (i + 0.5) / 12
        foot = (x + 5.5 * math.cos(angle), y + 5.5 * math.sin(angle))
        bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=0.28, depth=3.6, location=(*foot, 1.8))
        objects.place(bpy.context.object, marble)
        objects.box("Capital", (*foot, 3.7), (0.8, 0.8, 0.2), marble, math.degrees(angle))
    random = np.random.default_rng(11)
    for i in range(26):
        angle, distance = 2 * math.pi * i / 26, random.uniform(9, 20)
        height = random.uniform(4, 7)
        bpy.ops.mesh.primitive_cone_add(
            vertices=24,
            radius1=0.18 * height,
            depth=height,
            location=(x + distance * math.cos(angle), y + distance * math.sin(angle), height / 2),
        )
        objects.place(bpy.context.object, cypress)
    objects.box("Pedestal", (x, y + 2.1, 0.5), (1.1, 1.1, 1.0), marble)
    objects.suzanne((x, y + 2.1, 1.9), 1.9, 0, bronze)


def build_sky() -> None:
    """A summer sky as an equirectangular image; its sun is soft and wide, so that paths find it by chance."""
    height, width = 256, 512
    elevation = (np.arange(height) + 0.5)[:, None] / height * math.pi - math.pi / 2
    azimuth = (0.5 - (np.arange(width) + 0.5)[None, :] / width) * 2 * math.pi  # +x in the middle, +y a quarter left
    direction = np.stack(
        np.broadcast_arrays(
            np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
        ),
        axis=-1,
    )
    up = np.clip(np.sin(elevation), 0, 1)[..., None]
    sky = np.array((0.9, 0.95, 1.0)) * (1 - up) ** 4 + np.array((0.12, 0.34, 0.95)) * (1 - (1 - up) ** 4)
    sun = np.array((-0.55, -0.45, 0.70)) / np.linalg.norm((-0.55, -0.45, 0.70))
    cosine = np.clip(direction @ sun, 0, 1)[..., None]
    sky = 1.2 * sky + np.array((1.0, 0.85, 0.6)) * (22.0 * cosine**50 + 0.6 * cosine**6)
    sky = np.where(elevation[..., None] < 0, np.array((0.25, 0.22, 0.18)), sky)
    pixels = np.concatenate([sky, np.ones((height, width, 1))], axis=-1)
    objects.set_world_image(materials.float_image("Sky", pixels))


if __name__ == "__main__":
    common.main(build, "room_wormhole.png")
