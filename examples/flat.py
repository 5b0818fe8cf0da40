"""No hole at all: the proof that Bentlight is an ordinary renderer where space is ordinary.

One small studio, any of the supported kinds of material and of light. The picture shows Cycles on the left and
Bentlight on the right; tests/images compares the two for every entry of MATERIALS and LIGHTS by a Z-test.
"""

import argparse
import logging
import math
from pathlib import Path

import bpy
import common
import materials
import numpy as np
import objects
import room_kerr

BOUNCES = 6


def build(material: str = "all", light: str = "area") -> bpy.types.Scene:
    """Makes the studio with one kind of material on a sphere, or with all of them side by side, under one light."""
    scene = common.new_scene(samples=256)
    scene.bentlight.max_bounces = BOUNCES
    match_cycles(scene)
    chosen = list(MATERIALS) if material == "all" else [material]
    columns = 1 if len(chosen) == 1 else math.ceil(math.sqrt(2 * len(chosen)))
    floor = materials.principled("Floor", (0.45, 0.45, 0.45), roughness=1.0, specular_ior_level=0.0)
    objects.quad("Floor", (-6, -4, 0), (12, 0, 0), (0, 10, 0), floor)
    objects.quad("Red wall", (-6, -4, 0), (0, 10, 0), (0, 0, 5), materials.diffuse("Red", (0.7, 0.1, 0.06)))
    objects.quad("Green wall", (6, 6, 0), (0, -10, 0), (0, 0, 5), materials.diffuse("Green", (0.1, 0.5, 0.12)))
    objects.quad("Back wall", (-6, 6, 0), (12, 0, 0), (0, 0, 5), materials.diffuse("Slate", (0.25, 0.28, 0.34)))
    radius = 1.3 if columns == 1 else 2.6 / columns
    for index, name in enumerate(chosen):  # rows have `columns` spheres and one less in turn, which stand in the gaps
        pair, place = divmod(index, 2 * columns - 1)
        behind, column = divmod(place, columns)
        x = (column + behind / 2 - (columns - 1) / 2) * 2.5 * radius
        objects.sphere(name, (x, 2.8 * radius * (2 * pair + behind), radius), radius, MATERIALS[name]())
    LIGHTS[light]()
    objects.camera((0, -7.5, 4.6), (0, 0.95, 0.35), lens_mm=46)
    return scene


def match_cycles(scene: bpy.types.Scene) -> None:
    """Cycles without the shortcuts that change the mean: no clamping, no blurred or missing caustics, equal bounces."""
    cycles = scene.cycles
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(cycles, name, BOUNCES)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_light_tree = False
    cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    scene.world.cycles.sampling_method, scene.world.cycles.sample_map_resolution = "MANUAL", 64  # quick to build


def image_texture() -> bpy.types.Material:
    """The wall tile of the room, on a rough surface."""
    return materials.textured(
        "Tiles", materials.image_from_pixels("Tiles", materials.tile_pattern(64)), (8, 4), roughness=0.6
    )


def add_squares(material: bpy.types.Material, color: tuple, scale: float) -> bpy.types.Node:
    """A checker on UVs, black and `color`, for other nodes to use."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    squares, coordinates = nodes.new("ShaderNodeTexChecker"), nodes.new("ShaderNodeTexCoord")
    squares.inputs["Color1"].default_value, squares.inputs["Color2"].default_value = (0, 0, 0, 1), color
    squares.inputs["Scale"].default_value = scale
    links.new(coordinates.outputs["UV"], squares.inputs["Vector"])
    return squares


def transparent_mix() -> bpy.types.Material:
    """A checker decides between a diffuse surface and none."""
    material = materials.diffuse("Lattice", (0.8, 0.6, 0.1))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    mix, hole = (nodes.new(f"ShaderNode{kind}") for kind in ("MixShader", "BsdfTransparent"))
    squares, output = add_squares(material, (1, 1, 1, 1), 12.0), nodes["Material Output"]
    links.new(squares.outputs["Color"], mix.inputs[0])
    links.new(nodes["Diffuse BSDF"].outputs[0], mix.inputs[1])
    links.new(hole.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])
    return material


def color_ramp() -> bpy.types.Material:
    """A ramp over the angle around the sphere, through Separate-free nodes: checker, math and ramp."""
    material = materials.checker("Ramp", (0.1, 0.1, 0.1), (0.8, 0.8, 0.8), 10.0, roughness=0.7)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    ramp, math_node = nodes.new("ShaderNodeValToRGB"), nodes.new("ShaderNodeMath")
    math_node.operation = "POWER"
    math_node.inputs[1].default_value = 0.5
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.05, 0.1, 0.6, 1), (0.9, 0.5, 0.1, 1)
    links.new(nodes["Checker Texture"].outputs["Fac"], math_node.inputs[0])
    links.new(math_node.outputs[0], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def add_shader() -> bpy.types.Material:
    """Add Shader: a matte surface that shines a little, more where a checker is white."""
    material = materials.diffuse("Embers", (0.15, 0.1, 0.3))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    total, light = (nodes.new(f"ShaderNode{kind}") for kind in ("AddShader", "Emission"))
    squares, output = add_squares(material, (1, 0.35, 0.1, 1), 16.0), nodes["Material Output"]
    links.new(squares.outputs["Color"], light.inputs["Color"])
    links.new(nodes["Diffuse BSDF"].outputs[0], total.inputs[0])
    links.new(light.outputs[0], total.inputs[1])
    links.new(total.outputs[0], output.inputs["Surface"])
    return material


def normal_map() -> bpy.types.Material:
    """Hammered lacquer: round dimples in tangent space, repeated over the UV map."""
    axis = np.linspace(-1, 1, 64, endpoint=False) + 1 / 64
    x, y = np.meshgrid(axis, axis)
    steep = 1.5 * np.clip(1 - np.hypot(x, y), 0, None)  # the slope is steep * (x, y): none at the rim and at the bottom
    normals = np.stack([steep * x, steep * y, np.ones_like(x)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    image = materials.image_from_pixels("Dimples", 0.5 + 0.5 * normals)
    image.colorspace_settings.name = "Non-Color"
    material = materials.textured("Hammered", image, (12, 6), roughness=0.3)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    bend, lacquer = nodes.new("ShaderNodeNormalMap"), nodes["Principled BSDF"]
    links.remove(lacquer.inputs["Base Color"].links[0])
    lacquer.inputs["Base Color"].default_value = (0.1, 0.4, 0.35, 1)
    links.new(nodes["Image Texture"].outputs["Color"], bend.inputs["Color"])
    links.new(bend.outputs["Normal"], lacquer.inputs["Normal"])
    return material


MATERIALS = {
    "diffuse": lambda: materials.diffuse("Diffuse", (0.7, 0.35, 0.2)),
    "diffuse_rough": lambda: materials.shader("Rough diffuse", "BsdfDiffuse", Color=(0.7, 0.35, 0.2, 1), Roughness=0.8),
    "glossy": lambda: materials.shader("Glossy", "BsdfAnisotropic", Color=(0.8, 0.8, 0.8, 1), Roughness=0.2),
    "mirror": lambda: materials.shader("Mirror", "BsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0),
    "glass": lambda: materials.shader("Glass", "BsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.5),
    "glass_rough": lambda: materials.shader("Rough glass", "BsdfGlass", Color=(0.9, 1, 0.9, 1), Roughness=0.3, IOR=1.5),
    "principled": lambda: materials.principled("Plastic", (0.1, 0.3, 0.7), roughness=0.4),
    "principled_smooth": lambda: materials.principled("Enamel", (0.6, 0.05, 0.05), roughness=0.05, ior=1.6),
    "principled_metal": lambda: materials.principled("Metal", (0.9, 0.6, 0.3), roughness=0.5, metallic=1.0),
    "principled_glass": lambda: materials.principled("Clear", (1, 1, 1), roughness=0.1, transmission_weight=1.0),
    "principled_half_metal": lambda: materials.principled("Half metal", (0.3, 0.7, 0.5), roughness=0.3, metallic=0.5),
    "principled_half_glass": lambda: materials.principled(
        "Half glass", (0.9, 0.7, 0.9), roughness=0.2, transmission_weight=0.5
    ),
    "principled_alpha": lambda: materials.principled("Veil", (0.2, 0.7, 0.3), roughness=0.6, alpha=0.5),
    "principled_emission": lambda: materials.principled(
        "Glow", (0.2, 0.2, 0.2), emission_color=(1.0, 0.4, 0.1, 1), emission_strength=1.5
    ),
    "emission": lambda: materials.emission("Lamp", (0.3, 0.6, 1.0), 2.0),
    "transparent_mix": transparent_mix,
    "image_texture": image_texture,
    "color_ramp": color_ramp,
    "add_shader": add_shader,
    "normal_map": normal_map,
}


def emissive_mesh() -> None:
    """A mesh panel that shines on both sides."""
    objects.quad("Panel", (-2.5, -1.5, 5), (0, 4, 0), (5, 0, 0), materials.emission("Panel", (1, 0.9, 0.8), 3.0))


def sun(angle_deg: float = 40.0) -> None:
    """A sun so wide that paths find it by chance."""
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy, light.angle = 3.0, math.radians(angle_deg)
    objects.look_at(objects.place(bpy.data.objects.new("Sun", light), location=(-3, -2, 6)), (0, 1, 0))


def environment() -> None:
    """An image around everything, brighter on one side, with a color in every direction."""
    height, width = 32, 64
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    pixels = np.stack([1 + np.cos(2 * np.pi * u), 0.5 + v, 1 + np.sin(2 * np.pi * u), np.ones_like(u)], axis=-1)
    objects.set_world_image(materials.float_image("Surroundings", pixels))


LIGHTS = {
    "area": lambda: objects.area_light("Area", (0, 0, 5), (0, 0, 0), (5, 4), 400),
    "area_disk": lambda: objects.area_light("Disk", (-2, -2, 5), (0, 1, 0), (4, 4), 400, shape="DISK"),
    "sun": sun,
    "emissive_mesh": emissive_mesh,
    "world": lambda: objects.set_world((0.6, 0.8, 1.0), 1.0),
    "environment": environment,
}


def main() -> None:
    """Renders the studio by both engines and puts the pictures side by side."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=common.OUTPUT / "flat.png")
    parser.add_argument("--light", choices=LIGHTS, default="area")
    parser.add_argument("--samples", type=common.positive, default=256)
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    pictures = []
    for engine in ("CYCLES", "BENTLIGHT"):
        scene = build(light=args.light)
        scene.render.engine = engine
        scene.bentlight.samples = scene.cycles.samples = args.samples
        common.add_denoiser(scene)
        pictures.append(common.render(scene, args.output.resolve().with_name(f"flat_{engine.lower()}.png")))
    room_kerr.contact_sheet(pictures, args.output.resolve(), columns=2)
    common.log.info("%s", args.output)


if __name__ == "__main__":
    main()
