"""Materials of the example scenes: small node trees, of the nodes that Bentlight and Cycles both know."""

import bpy
import numpy as np

Color = tuple[float, float, float]


def principled(name: str, color: Color = (0.8, 0.8, 0.8), **inputs: object) -> bpy.types.Material:
    """A Principled BSDF. Inputs go by their names in small letters: roughness=0.2, transmission_weight=1.0."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    names = {socket.name.lower().replace(" ", "_"): socket for socket in shader.inputs}
    for key, value in inputs.items():
        names[key].default_value = value
    return material


def shader(name: str, kind: str, **inputs: object) -> bpy.types.Material:
    """A material of the single shader node ShaderNode<kind>, its inputs set by their names."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    node, output = nodes.new(f"ShaderNode{kind}"), nodes.new("ShaderNodeOutputMaterial")
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    material.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def diffuse(name: str, color: Color) -> bpy.types.Material:
    """A matte surface."""
    return shader(name, "BsdfDiffuse", Color=(*color, 1.0))


def emission(name: str, color: Color = (1.0, 1.0, 1.0), strength: float = 1.0) -> bpy.types.Material:
    """A surface that shines with the radiance color * strength."""
    return shader(name, "Emission", Color=(*color, 1.0), Strength=strength)


def checker(name: str, color1: Color, color2: Color, scale: float, **inputs: object) -> bpy.types.Material:
    """A Principled BSDF whose color is a checker with squares of 1 / scale in object coordinates."""
    material = principled(name, **inputs)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    pattern, coordinates = nodes.new("ShaderNodeTexChecker"), nodes.new("ShaderNodeTexCoord")
    pattern.inputs["Color1"].default_value = (*color1, 1.0)
    pattern.inputs["Color2"].default_value = (*color2, 1.0)
    pattern.inputs["Scale"].default_value = scale
    links.new(coordinates.outputs["UV"], pattern.inputs["Vector"])
    links.new(pattern.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def textured(
    name: str, image: bpy.types.Image, repeat: tuple[float, float] = (1.0, 1.0), **inputs: object
) -> bpy.types.Material:
    """A Principled BSDF whose color is an image, repeated over the surface's UV map."""
    material = principled(name, **inputs)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    texture, mapping = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeMapping")
    coordinates = nodes.new("ShaderNodeTexCoord")
    texture.image = image
    mapping.inputs["Scale"].default_value = (*repeat, 1.0)
    links.new(coordinates.outputs["UV"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def image_from_pixels(name: str, rgb: np.ndarray) -> bpy.types.Image:
    """An image packed into the file. rgb: (height, width, 3), sRGB values from 0 to 1, first row at the bottom."""
    height, width, _ = rgb.shape
    image = bpy.data.images.new(name, width, height)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = rgb
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def float_image(name: str, pixels: np.ndarray) -> bpy.types.Image:
    """An image of linear radiance packed into the file. pixels: (height, width, 4), first row at the bottom."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new(name, width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.pack()
    return image


def tile_pattern(size: int = 256) -> np.ndarray:
    """One glazed wall tile, blue on cream, in the manner of azulejos; repeats without a seam. (size, size, 3) sRGB."""
    cream, blue, sky, ochre, grout = np.array(
        [(0.93, 0.90, 0.82), (0.12, 0.24, 0.55), (0.45, 0.62, 0.80), (0.86, 0.62, 0.20), (0.70, 0.68, 0.64)]
    )
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.abs(np.meshgrid(axis, axis))
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    from_corner = np.hypot(1 - x, 1 - y)
    pixels = np.broadcast_to(cream, (size, size, 3)).copy()
    for inside, color in (
        (from_corner < 0.62, blue),
        (from_corner < 0.52, cream),
        (from_corner < 0.44, sky),
        (from_corner < 0.22, blue),
        (radius < 0.66 + 0.10 * np.cos(8 * angle), blue),
        (radius < 0.52 + 0.08 * np.cos(8 * angle), sky),
        (radius < 0.36 + 0.10 * np.cos(4 * angle), cream),
        (radius < 0.18, ochre),
        (np.maximum(x, y) > 0.97, grout),
    ):
        pixels[inside] = color
    return pixels
