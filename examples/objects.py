"""Objects, lights, the world and the camera of the example scenes: ordinary Blender data, made in one line each."""

import math
from collections.abc import Sequence

import bpy
import mathutils
import numpy as np
from materials import Color

Vector = Sequence[float]


def add_mesh(
    name: str,
    vertices: Sequence[Vector],
    faces: Sequence[tuple[int, ...]],
    material: bpy.types.Material | None = None,
    uvs: Sequence[Vector] | None = None,
) -> bpy.types.Object:
    """A mesh object from vertex positions and faces; uvs holds one pair a face corner."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(v) for v in vertices], [], faces)
    if uvs is not None:
        mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", np.asarray(uvs, np.float32).ravel())
    return place(bpy.data.objects.new(name, mesh), material)


def place(
    thing: bpy.types.Object, material: bpy.types.Material | None = None, location: Vector | None = None
) -> bpy.types.Object:
    """Puts an object into the scene."""
    if thing.name not in bpy.context.collection.objects:
        bpy.context.collection.objects.link(thing)
    if location is not None:
        thing.location = location
    if material is not None:
        thing.data.materials.clear()
        thing.data.materials.append(material)
    return thing


def quad(name: str, origin: Vector, u: Vector, v: Vector, material: bpy.types.Material) -> bpy.types.Object:
    """The parallelogram at origin with the edges u and v; its UVs count scene units; it faces along u x v."""
    origin, u, v = (np.asarray(vector, float) for vector in (origin, u, v))
    width, height = np.linalg.norm(u), np.linalg.norm(v)
    return add_mesh(
        name,
        [origin, origin + u, origin + u + v, origin + v],
        [(0, 1, 2, 3)],
        material,
        uvs=[(0, 0), (width, 0), (width, height), (0, height)],
    )


def box(
    name: str, center: Vector, size: Vector, material: bpy.types.Material, turn_deg: float = 0.0
) -> bpy.types.Object:
    """A box around its center, turned about the vertical."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=center, scale=size, rotation=(0, 0, math.radians(turn_deg)))
    bpy.context.object.name = name
    return place(bpy.context.object, material)


def sphere(name: str, center: Vector, radius: float, material: bpy.types.Material) -> bpy.types.Object:
    """A smooth sphere."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius, location=center)
    bpy.context.object.name = name
    bpy.ops.object.shade_smooth()
    return place(bpy.context.object, material)


def suzanne(center: Vector, size: float, turn_deg: float, material: bpy.types.Material) -> bpy.types.Object:
    """Blender's monkey, smoothed by a subdivision modifier."""
    bpy.ops.mesh.primitive_monkey_add(
        size=size, location=center, rotation=(math.radians(-8), 0, math.radians(turn_deg))
    )
    monkey = bpy.context.object
    monkey.name = "Suzanne"
    monkey.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    bpy.ops.object.shade_smooth()
    return place(monkey, material)


def look_at(thing: bpy.types.Object, target: Vector) -> None:
    """Turns a camera or lamp so that it points to the target, the picture's top upward."""
    direction = mathutils.Vector(target) - thing.location
    thing.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()


def camera(location: Vector, target: Vector, lens_mm: float = 35.0) -> bpy.types.Object:
    """Adds the scene's camera."""
    thing = place(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")), location=location)
    thing.data.lens = lens_mm
    thing.data.clip_start = 0.01
    look_at(thing, target)
    bpy.context.scene.camera = thing
    return thing


def area_light(
    name: str,
    location: Vector,
    target: Vector,
    size: tuple[float, float],
    watts: float,
    color: Color = (1.0, 1.0, 1.0),
    shape: str = "RECTANGLE",
) -> bpy.types.Object:
    """An area light, size = (width, height). Large lights make clean pictures."""
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.size_y = shape, *size
    light.energy, light.color = watts, color
    thing = place(bpy.data.objects.new(name, light), location=location)
    look_at(thing, target)
    return thing


def set_world(color: Color, strength: float = 1.0) -> None:
    """Light of one color from every direction."""
    world = bpy.context.scene.world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength


def set_world_image(image: bpy.types.Image) -> None:
    """Light from an equirectangular image of all directions."""
    tree = bpy.context.scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 1.0
