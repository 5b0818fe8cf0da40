"""Texture nodes, their coordinates, and normal maps."""

from __future__ import annotations

import numpy as np

from ..ies import ies_table
from ..images import Pixels, has_associated_alpha
from ..sky import Atmosphere, sky_image, sun_radiance
from .compiler import NodeView, Outputs, value_node

# What Cycles shows where an image is wanted and none is chosen.
_NO_IMAGE_COLOR = (1.0, 0.0, 1.0)


@value_node("ShaderNodeTexCoord")
def _texture_coordinate(node: NodeView) -> Outputs:
    if node.node.from_instancer:
        node.warn("'From Instancer' is not supported yet; left out")
    outputs = {name: node.coordinate(name.upper()) for name in ("UV", "Generated", "Normal", "Reflection")}
    target = node.node.object
    outputs["Object"] = node.coordinate("OBJECT") if target is None else _object_coordinate(node, target)
    return outputs


def _object_coordinate(node: NodeView, target: object) -> int:
    """The position in the axes of another object."""
    matrix = np.array(target.matrix_world, np.float64)
    if abs(np.linalg.det(matrix)) < 1e-30:
        return node.constant(0.0)
    columns = np.linalg.inv(matrix)[:3].T
    return node.emit("transform", node.coordinate("POSITION"), *(node.constant(column) for column in columns))


@value_node("ShaderNodeUVMap")
def _uv_map(node: NodeView) -> Outputs:
    if node.node.from_instancer:
        node.warn("'From Instancer' is not supported yet; left out")
    name = node.node.uv_map
    return {"UV": node.attribute("GEOMETRY", name) if name else node.coordinate("UV")}


@value_node("ShaderNodeMapping")
def _mapping(node: NodeView) -> Outputs:
    operands = (node.input(name) for name in ("Vector", "Location", "Rotation", "Scale"))
    return {"Vector": node.emit("mapping", *operands, immediates=(node.node.vector_type,))}


@value_node("ShaderNodeTexChecker")
def _checker(node: NodeView) -> Outputs:
    vector = node.input("Vector", lambda: node.coordinate("GENERATED"))
    color = node.emit("checker", vector, node.input("Color1"), node.input("Color2"), node.input("Scale"))
    return {"Color": color, "Fac": color + 1}


@value_node("ShaderNodeTexImage")
def _image_texture(node: NodeView) -> Outputs:
    settings = node.node
    if settings.image is None:
        node.warn("no image is chosen")
        return {"Color": node.constant(_NO_IMAGE_COLOR), "Alpha": node.constant(1.0)}
    vector = node.input("Vector", lambda: node.coordinate("UV"))
    if settings.projection == "BOX":
        node.warn("box projection is not supported yet; flat is used instead")
    elif settings.projection != "FLAT":
        vector = node.emit("project", vector, immediates=(settings.projection,))
    # Cycles divides by alpha only where the alpha output is used.
    straight = settings.outputs["Alpha"].is_linked and has_associated_alpha(settings.image)
    images, lookup = node.compiler.images, (settings.interpolation, settings.extension, "ON" if straight else "OFF")
    if settings.image.source == "TILED":
        first, numbers = images.tiles_of(settings.image, node.warn)
        table = node.compiler.builder.table(np.array(numbers, np.float32)[:, None].repeat(4, axis=1))
        color = node.emit("image_tiles", vector, immediates=(first, *table, *lookup))
    else:
        index = images.index_of(settings.image, node.warn)
        color = node.emit("image", vector, immediates=(index, *lookup))
    return {"Color": color, "Alpha": color + 1}


@value_node("ShaderNodeTexEnvironment")
def _environment_texture(node: NodeView) -> Outputs:
    settings = node.node
    if settings.image is None:
        node.warn("no image is chosen")
        return {"Color": node.constant(_NO_IMAGE_COLOR)}
    index = node.compiler.images.index_of(settings.image, node.warn)
    immediates = (index, settings.interpolation, settings.projection)
    return {"Color": node.emit("environment", *_directions(node), immediates=immediates)}


def _directions(node: NodeView) -> tuple[int, int, int]:
    """The vector of a texture of the sky, and the same beside the point along both axes."""
    compiler, beside = node.compiler, []
    for axis in "XY":
        with compiler.beside((axis, node.constant(1.0))):
            beside.append(node.input("Vector", lambda: node.coordinate("POSITION")))
    return node.input("Vector", lambda: node.coordinate("POSITION")), *beside


# Kinds of the Sky Texture that are computed as they are meant; the others get the same atmosphere.
_SINGLE_SCATTERING = ("SINGLE_SCATTERING", "NISHITA")


@value_node("ShaderNodeTexSky")
def _sky_texture(node: NodeView) -> Outputs:
    settings = node.node
    if settings.sky_type not in _SINGLE_SCATTERING:
        node.warn("the sky {} is not supported yet; single scattering in clear air is used instead", settings.sky_type)
    if settings.sky_type in ("PREETHAM", "HOSEK_WILKIE"):
        direction = np.array(settings.sun_direction) / np.linalg.norm(settings.sun_direction)
        air, elevation, azimuth = (0.0, 1.0, 1.0, 1.0), np.arcsin(direction[2]), np.arctan2(direction[1], direction[0])
        has_disk = False
    else:
        haze = getattr(settings, "aerosol_density", None)  # "dust" before Blender 5.0
        haze = settings.dust_density if haze is None else haze
        air = (settings.altitude, settings.air_density, haze, settings.ozone_density)
        elevation, azimuth = settings.sun_elevation, np.pi / 2 - settings.sun_rotation
        has_disk = settings.sun_disc
    atmosphere = Atmosphere(float(elevation), *air)
    images = node.compiler.images
    index = images.index_of_made((atmosphere, azimuth), lambda: Pixels(sky_image(atmosphere, azimuth), srgb=False))
    vector, *beside = _directions(node)
    sky = node.emit("environment", vector, *beside, immediates=(index, "Linear", "EQUIRECTANGULAR"))
    if not has_disk:
        return {"Color": sky}
    planar = np.cos(elevation)
    sun = node.constant((planar * np.cos(azimuth), planar * np.sin(azimuth), np.sin(elevation)))
    radiance = sun_radiance(atmosphere, settings.sun_size) * settings.sun_intensity
    disk = node.emit("sun_disk", vector, sun, node.constant(settings.sun_size / 2))
    disk = node.emit("multiply", disk, node.constant(radiance))
    return {"Color": node.emit("blend", node.constant(1.0), sky, disk, immediates=("ADD",))}


@value_node("ShaderNodeTexIES")
def _ies(node: NodeView) -> Outputs:
    """By the direction to the viewer if no vector is linked."""
    strength = node.input("Strength")
    try:
        table = node.compiler.builder.table(ies_table(node.node))
    except ValueError as error:
        node.warn("{}; it shines evenly, as in Cycles", error)
        return {"Fac": node.emit("multiply", strength, node.constant(100.0))}

    def incoming() -> int:
        return node.emit("change_space", node.coordinate("INCOMING"), immediates=("VECTOR", "WORLD", "OBJECT"))

    sent = node.emit("ies", node.input("Vector", incoming), immediates=table)
    return {"Fac": node.emit("multiply", strength, sent)}


@value_node("ShaderNodeBump")
def _bump(node: NodeView) -> Outputs:
    compiler = node.compiler
    with compiler.beside(None):  # a bump within the height of another is one of the point itself
        normal = node.normal()
        if not node.socket("Height").is_linked:
            return {"Normal": normal}
        width = node.constant(0.1) if node.socket("Filter Width") is None else node.input("Filter Width")
        strength, distance, heights = node.input("Strength"), node.input("Distance"), [node.input("Height")]
    for axis in "XY":
        with compiler.beside((axis, width)):
            heights.append(node.input("Height"))
    switch = "ON" if node.node.invert else "OFF"
    return {"Normal": node.emit("bump", strength, distance, *heights, width, normal, immediates=(switch,))}


@value_node("ShaderNodeNormalMap")
def _normal_map(node: NodeView) -> Outputs:
    if node.node.space == "TANGENT":
        tangent = node.attribute("TANGENT", node.node.uv_map)
        return {
            "Normal": node.emit("normal_map_along", node.input("Strength"), node.input("Color"), tangent, tangent + 2)
        }
    return {
        "Normal": node.emit("normal_map", node.input("Strength"), node.input("Color"), immediates=(node.node.space,))
    }
