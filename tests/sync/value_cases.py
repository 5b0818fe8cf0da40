"""Node trees whose color output is compared with Cycles value by value.

Each case builds nodes into a tree and returns the output socket to look at. `uv(tree)` is the input that varies.
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np

CASES = {}

MATH_OPERATIONS = bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items.keys()
BLEND_TYPES = bpy.types.ShaderNodeMixRGB.bl_rna.properties["blend_type"].enum_items.keys()
EXTENSIONS = ("REPEAT", "EXTEND", "CLIP", "MIRROR")


def case(function):
    """Registers a case by its function's name."""
    CASES[function.__name__] = function
    return function


def empty_tree(datablock):
    """The node tree of a new material or world, without nodes."""
    if datablock.node_tree is None:  # before Blender 5.0
        datablock.use_nodes = True
    datablock.node_tree.nodes.clear()
    return datablock.node_tree


def uv(tree):
    return new(tree, "UVMap").outputs["UV"]


def new(tree, kind, inputs=(), **settings):
    """A node with settings; `inputs`: socket -> value or output socket."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in settings.items():
        setattr(node, name, value)
    for key, value in dict(inputs).items():
        socket = node.inputs[key]
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def parts(tree):
    """u, v and u + 0.3 v as separate numbers."""
    split = new(tree, "SeparateXYZ", {0: uv(tree)})
    third = new(tree, "Math", {0: split.outputs[1], 1: 0.3, 2: split.outputs[0]}, operation="MULTIPLY_ADD")
    return split.outputs[0], split.outputs[1], third.outputs[0]


def color(tree):
    """A color that varies."""
    return new(tree, "CombineColor", dict(enumerate(parts(tree)))).outputs[0]


def _add_math(operation):
    def build(tree):
        return new(tree, "Math", dict(enumerate(parts(tree))), operation=operation).outputs[0]

    CASES[f"math_{operation}"] = build


def _add_blend(blend_type):
    def build_mix(tree):
        other = new(tree, "Mapping", {"Vector": color(tree), "Scale": (0.3, 0.4, 0.5)})
        inputs = {0: parts(tree)[2], 6: color(tree), 7: other.outputs[0]}
        return new(tree, "Mix", inputs, data_type="RGBA", blend_type=blend_type).outputs[2]

    def build_mix_rgb(tree):
        inputs = {0: 0.7, 1: color(tree), 2: (0.2, 0.5, 0.9, 1)}
        return new(tree, "MixRGB", inputs, blend_type=blend_type, use_clamp=True).outputs[0]

    CASES[f"mix_{blend_type}"] = build_mix
    CASES[f"mix_rgb_{blend_type}"] = build_mix_rgb


for name in MATH_OPERATIONS:
    _add_math(name)
for name in BLEND_TYPES:
    _add_blend(name)


@case
def math_clamped(tree):
    return new(tree, "Math", {0: parts(tree)[0], 1: 0.2}, use_clamp=True).outputs[0]


@case
def mix_float(tree):
    a, b, t = parts(tree)
    return new(tree, "Mix", {0: t, 2: a, 3: b}, clamp_factor=False).outputs[0]


@case
def mix_vector(tree):
    inputs = {1: uv(tree), 4: color(tree), 5: (1, 2, 3)}
    return new(tree, "Mix", inputs, data_type="VECTOR", factor_mode="NON_UNIFORM").outputs[1]


@case
def value_and_rgb(tree):
    rgb, value = new(tree, "RGB"), new(tree, "Value")
    rgb.outputs[0].default_value = (0.1, 0.6, 2.5, 1)
    value.outputs[0].default_value = -0.7
    return new(tree, "MixRGB", {0: value.outputs[0], 1: rgb.outputs[0], 2: uv(tree)}, blend_type="ADD").outputs[0]


@case
def color_to_float(tree):
    return new(tree, "Math", {0: color(tree), 1: 0.0}).outputs[0]


@case
def vector_to_float(tree):
    return new(tree, "Math", {0: uv(tree), 1: 0.0}).outputs[0]


@case
def float_to_vector(tree):
    return new(tree, "Mapping", {0: parts(tree)[0]}).outputs[0]


@case
def combine_xyz(tree):
    u, v, w = parts(tree)
    return new(tree, "CombineXYZ", {0: w, 1: u, 2: v}).outputs[0]


@case
def separate_color(tree):
    return new(tree, "SeparateColor", {0: color(tree)}).outputs["Blue"]


def _add_mapping(vector_type):
    def build(tree):
        inputs = {0: color(tree), "Rotation": (0.3, -1.2, 2.0), "Scale": (0.5, -2, 1.5)}
        if vector_type in ("POINT", "TEXTURE"):
            inputs["Location"] = (0.1, 0.2, -0.7)
        return new(tree, "Mapping", inputs, vector_type=vector_type).outputs[0]

    CASES[f"mapping_{vector_type}"] = build


for name in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
    _add_mapping(name)


@case
def mapping_zero_scale(tree):
    return new(tree, "Mapping", {0: color(tree), "Scale": (0, 2, 0)}, vector_type="TEXTURE").outputs[0]


@case
def checker(tree):
    inputs = {0: color(tree), 1: (0.1, 0.5, 0.9, 1), 2: (1, 0, 0.3, 1), "Scale": 3.7}
    return new(tree, "TexChecker", inputs).outputs[0]


@case
def checker_factor(tree):
    return new(tree, "TexChecker", {0: uv(tree), "Scale": 2.3}).outputs["Fac"]


def _add_ramp(interpolation, mode="RGB", hue="NEAR"):
    def build(tree):
        node = new(tree, "ValToRGB", {0: parts(tree)[0]})
        ramp = node.color_ramp
        ramp.color_mode = mode
        if mode == "RGB":
            ramp.interpolation = interpolation
        else:
            ramp.hue_interpolation = hue
        ramp.elements[0].color = (0.9, 0.1, 0.2, 0.3)
        ramp.elements[1].color = (0.1, 0.3, 1.5, 1)
        ramp.elements[1].position = 0.8
        ramp.elements.new(0.33).color = (0.2, 0.8, 0.1, 0.6)
        return new(tree, "MixRGB", {0: node.outputs[1], 2: node.outputs[0]}).outputs[0]

    CASES[f"ramp_{interpolation}_{mode}_{hue}"] = build


for name in ("LINEAR", "CONSTANT", "EASE", "CARDINAL", "B_SPLINE"):
    _add_ramp(name)
_add_ramp("LINEAR", "HSV", "FAR")
_add_ramp("LINEAR", "HSL", "CW")


def noise_image(name, is_float, alpha, space, alpha_mode="STRAIGHT"):
    """A packed image of 7 x 5 random pixels."""
    rng = np.random.default_rng(len(name))
    pixels = rng.random((5, 7, 4), np.float32)
    if not alpha:
        pixels[..., 3] = 1
    image = bpy.data.images.new(name, 7, 5, alpha=alpha, float_buffer=is_float)
    image.colorspace_settings.name = space
    image.alpha_mode = alpha_mode
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    image.reload()  # so that memory holds what the packed file means by its alpha mode
    return image


def _add_image(name, interpolation="Linear", extension="REPEAT", use_alpha=False, projection="FLAT", **settings):
    def build(tree):
        image = noise_image(name, **({"is_float": False, "alpha": False, "space": "sRGB"} | settings))
        vector = uv(tree) if projection == "FLAT" else color(tree)
        kind = {"interpolation": interpolation, "extension": extension, "projection": projection, "image": image}
        node = new(tree, "TexImage", {0: vector}, **kind)
        if not use_alpha:
            return node.outputs[0]
        return new(tree, "MixRGB", {0: node.outputs[1], 2: node.outputs[0]}).outputs[0]

    CASES[f"image_{name}"] = build


for interpolation in ("Linear", "Closest", "Cubic", "Smart"):
    for extension in EXTENSIONS:
        _add_image(f"{interpolation}_{extension}", interpolation, extension)
_add_image("float", is_float=True, space="Linear Rec.709")
_add_image("float_data", is_float=True, space="Non-Color")
_add_image("data", space="Non-Color")
_add_image("linear_bytes", space="Linear Rec.709")
_add_image("sphere", projection="SPHERE")
_add_image("tube", projection="TUBE")
for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
    for is_float in (False, True):
        kind = "float" if is_float else "byte"
        space = "Linear Rec.709" if is_float else "sRGB"
        settings = {"alpha": True, "is_float": is_float, "space": space, "alpha_mode": mode}
        _add_image(f"{kind}_alpha_{mode}", **settings)
        _add_image(f"{kind}_alpha_{mode}_used", use_alpha=True, **settings)


def _add_file(name, file_format, depth, space, alpha=False):
    """An image that was saved to a file of its own and is read from there."""

    def build(tree):
        folder = Path(tempfile.mkdtemp())
        source = noise_image(name, is_float=depth != "8", alpha=alpha, space="sRGB" if depth == "8" else "Non-Color")
        scene = bpy.data.scenes.new("saving")
        scene.view_settings.view_transform = "Raw"
        settings = scene.render.image_settings
        settings.file_format, settings.color_depth, settings.color_mode = file_format, depth, "RGBA" if alpha else "RGB"
        path = folder / f"{name}{scene.render.file_extension}"
        source.save_render(str(path), scene=scene)
        image = bpy.data.images.load(str(path))
        image.colorspace_settings.name = space
        node = new(tree, "TexImage", {0: uv(tree)}, image=image)
        return new(tree, "MixRGB", {0: node.outputs[1], 2: node.outputs[0]}).outputs[0]

    CASES[f"file_{name}"] = build


_add_file("png_8", "PNG", "8", "sRGB")
_add_file("png_8_alpha", "PNG", "8", "sRGB", alpha=True)
_add_file("png_16", "PNG", "16", "sRGB")
_add_file("png_16_alpha", "PNG", "16", "sRGB", alpha=True)
_add_file("png_16_data", "PNG", "16", "Non-Color")
_add_file("exr", "OPEN_EXR", "32", "Linear Rec.709", alpha=True)
_add_file("exr_rec2020", "OPEN_EXR", "32", "Linear Rec.2020")
_add_file("tiff", "TIFF", "8", "sRGB")
_add_file("hdr", "HDR", "32", "Linear Rec.709")


def _add_tiles(name, packed=False, **settings):
    """Tiles 1001, 1002 and 1011 of different sizes, saved to files."""

    def build(tree):
        folder, sizes = Path(tempfile.mkdtemp()), {1001: (5, 4), 1002: (3, 6), 1011: (4, 4)}
        for number, (width, height) in sizes.items():
            tile = bpy.data.images.new(f"{name} {number}", width, height)
            tile.pixels.foreach_set(np.random.default_rng(number).random(4 * width * height).astype(np.float32))
            tile.file_format, tile.filepath_raw = "PNG", str(folder / f"tile.{number}.png")
            tile.save()
            bpy.data.images.remove(tile)
        image = bpy.data.images.load(str(folder / "tile.1001.png"))
        image.source = "TILED"
        image.filepath = str(folder / "tile.<UDIM>.png")
        for number in list(sizes)[1:]:
            image.tiles.new(number)
        if packed:
            image.pack()
        node = new(tree, "TexImage", {0: uv(tree)}, image=image, **settings)
        return new(tree, "MixRGB", {0: node.outputs[1], 2: node.outputs[0]}).outputs[0]

    CASES[f"tiles_{name}"] = build


_add_tiles("files")
_add_tiles("packed", packed=True)
_add_tiles("extended", interpolation="Cubic", extension="EXTEND")


@case
def image_none(tree):
    return new(tree, "TexImage", {0: uv(tree)}).outputs[0]


@case
def group_with_default_and_reroute(tree):
    group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
    group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketColor")
    own = group.interface.new_socket("Own", in_out="INPUT", socket_type="NodeSocketFloat")
    own.default_value = 0.35
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    reroute = group.nodes.new("NodeReroute")
    group.links.new(start.outputs[0], reroute.inputs[0])
    mixed = new(group, "MixRGB", {0: start.outputs[1], 1: reroute.outputs[0], 2: (0.1, 0.2, 0.3, 1)})
    muted = new(group, "MixRGB", {1: mixed.outputs[0]}, mute=True)
    group.links.new(muted.outputs[0], end.inputs[0])
    first, second = new(tree, "Group", node_tree=group), new(tree, "Group", node_tree=group)
    second.inputs[1].default_value = 0.8
    tree.links.new(color(tree), first.inputs[0])
    tree.links.new(first.outputs[0], second.inputs[0])
    return second.outputs[0]


@case
def muted_nodes_that_pass_nothing_on(tree):
    """What gets their links keeps its own value, out of a group too; reroutes that get nothing are as in Cycles."""
    group = bpy.data.node_groups.new("quiet", "ShaderNodeTree")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
    end = group.nodes.new("NodeGroupOutput")
    end.inputs[0].default_value = (0.3, 0.7, 0.1, 1)
    quiet = [new(owner, "RGB", mute=True) for owner in (tree, tree, group)]
    for node in quiet:
        node.outputs[0].default_value = (0.9, 0.1, 0.4, 1)
    group.links.new(quiet[2].outputs[0], end.inputs[0])
    reroute, dangling = tree.nodes.new("NodeReroute"), tree.nodes.new("NodeReroute")
    tree.links.new(quiet[1].outputs[0], reroute.inputs[0])
    shown = color(tree)
    for source in (
        quiet[0].outputs[0],
        reroute.outputs[0],
        dangling.outputs[0],
        new(tree, "Group", node_tree=group).outputs[0],
    ):
        mixed = new(tree, "MixRGB", {0: 0.4, 1: shown, 2: source})
        mixed.inputs[2].default_value = (0.2, 0.5, 0.8, 1)
        shown = mixed.outputs[0]
    return shown


@case
def normal_node(tree):
    node = new(tree, "Normal", {0: color(tree)})
    node.outputs[0].default_value = (0.3, -0.4, 0.7)
    return new(tree, "MixRGB", {0: node.outputs["Dot"], 1: node.outputs["Normal"]}).outputs[0]


def _add_rotation(rotation_type, invert):
    def build(tree):
        inputs = {"Vector": color(tree), "Center": (0.3, 0.1, -0.2), "Axis": (0.4, 0.5, -0.6), "Angle": parts(tree)[2]}
        inputs["Rotation"] = (0.3, -1.2, 2.0)
        node = tree.nodes.new("ShaderNodeVectorRotate")
        node.rotation_type, node.invert = rotation_type, invert
        for socket in node.inputs:
            value = inputs[socket.identifier]
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node.outputs[0]

    CASES[f"vector_rotate_{rotation_type}_{invert}"] = build


for kind in bpy.types.ShaderNodeVectorRotate.bl_rna.properties["rotation_type"].enum_items.keys():  # noqa: SIM118
    for invert in (False, True):
        _add_rotation(kind, invert)


@case
def vector_rotate_without_axis(tree):
    return new(tree, "VectorRotate", {"Vector": color(tree), "Axis": (0, 0, 0), "Angle": 1.0}).outputs[0]


@case
def wavelength(tree):
    place = new(tree, "MapRange", {0: parts(tree)[2], 1: -2.0, 2: 3.0, 3: 381.0, 4: 800.0})
    return new(tree, "Wavelength", {0: place.outputs[0]}).outputs[0]


def _add_info(kind, names):
    for name in names:
        CASES[f"{kind}_{name}"] = lambda tree, name=name: new(tree, kind).outputs[name]


_PARTICLE = ("Index", "Random", "Age", "Lifetime", "Location", "Size", "Velocity", "Angular Velocity")
_add_info("ParticleInfo", _PARTICLE)
_add_info("HairInfo", ("Is Strand", "Intercept", "Length", "Thickness", "Random"))
_add_info("PointInfo", ("Position", "Radius", "Random"))
_add_info("VolumeInfo", ("Color", "Density", "Flame", "Temperature"))
