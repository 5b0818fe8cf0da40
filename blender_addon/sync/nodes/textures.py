"""Texture nodes, their coordinates, and normal maps."""

from __future__ import annotations

import numpy as np

from ..images import has_associated_alpha
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
    _only_active_uv_map(node)
    return {"UV": node.coordinate("UV")}


def _only_active_uv_map(node: NodeView) -> None:
    if node.node.uv_map:
        node.warn(f"the UV map '{node.node.uv_map}' by name is not supported yet; the one active in render is used")


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
    index = node.compiler.images.index_of(settings.image, node.warn)
    immediates = (index, settings.interpolation, settings.extension, "ON" if straight else "OFF")
    color = node.emit("image", vector, immediates=immediates)
    return {"Color": color, "Alpha": color + 1}


@value_node("ShaderNodeTexEnvironment")
def _environment_texture(node: NodeView) -> Outputs:
    settings = node.node
    if settings.image is None:
        node.warn("no image is chosen")
        return {"Color": node.constant(_NO_IMAGE_COLOR)}
    vector = node.input("Vector", lambda: node.coordinate("POSITION"))
    index = node.compiler.images.index_of(settings.image, node.warn)
    immediates = (index, settings.interpolation, settings.projection)
    return {"Color": node.emit("environment", vector, immediates=immediates)}


@value_node("ShaderNodeNormalMap")
def _normal_map(node: NodeView) -> Outputs:
    _only_active_uv_map(node)
    return {
        "Normal": node.emit("normal_map", node.input("Strength"), node.input("Color"), immediates=(node.node.space,))
    }
