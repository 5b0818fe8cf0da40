"""A world's stars in Cycles: a shader that is added to what the world shows."""

from __future__ import annotations

import math
import os
from pathlib import Path

import bpy

from ..properties_stars import BentlightWorldSettings
from ..report import told
from ..sync.camera import image_size
from ..sync.material import node_tree
from ..sync.nodes.shaders import STARS_MARK
from ..sync.stars import read_stars
from . import files, shaders, star_cells

_RADIUS = 1.1  # of a star's spot, in pixels
_BRIGHTEST = 1e4  # what is stored


def check(scene: bpy.types.Scene) -> None:
    """Raises RenderError for a catalog that is none."""
    read_stars(scene.world)


def update(scene: bpy.types.Scene) -> None:
    """Makes Cycles show the stars of the scene's world as they are now. Changes nothing if it does already.

    Raises RenderError for a catalog that is none.
    """
    world = scene.world
    if world is None or world.bentlight.stars == "OFF" or node_tree(world) is None:
        remove(scene)
        return
    node, key = find(world.node_tree) or _add(world.node_tree), _key(world)
    if node is None:
        return
    if node[STARS_MARK] != key or not Path(_value(node, "Cells", "")).is_file():
        _fill(node, world)
        node[STARS_MARK] = key
    radius = _RADIUS * _pixel_angle(scene)
    shaders.fill_node(node, shaders.compiled("stars"), {"Radius": ("NodeSocketFloat", radius)})


def remove(scene: bpy.types.Scene) -> None:
    """Takes the shader out of the world again."""
    tree = scene.world.node_tree if scene.world else None
    node = find(tree) if tree else None
    if node is None:
        return
    for link in list(node.outputs["BSDF"].links):
        both = link.to_node
        for source in [other.from_socket for other in both.inputs[0].links]:
            for target in [other.to_socket for other in both.outputs[0].links]:
                tree.links.new(source, target)
        tree.nodes.remove(both)
    tree.nodes.remove(node)


def warnings(scene: bpy.types.Scene) -> list[str]:
    """What keeps stars from being seen."""
    world = scene.world
    if world is None or world.bentlight.stars == "OFF":
        return []
    if node_tree(world) is None:
        return [told("World '{}' uses no nodes: its stars are not seen in Cycles", world.name)]
    if find(world.node_tree) is None:
        return [told("World '{}' shows nothing to which stars could be added", world.name)]
    return []


def told_shader(node: bpy.types.Node, pixels: float) -> dict[str, shaders.Socket]:
    """What another node that shows the same stars is to be told, where directions have derivatives over so many pixels
    of the picture."""
    told = {socket.name: (socket.bl_idname, socket.default_value) for socket in node.inputs}
    return told | {"Spread": ("NodeSocketFloat", _RADIUS / pixels)}


def find(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The node that shows stars, if there is one."""
    return next((node for node in tree.nodes if STARS_MARK in node), None)


def _add(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """Adds the shader to what is linked to the world's output; None if nothing is."""
    output = tree.get_output_node("CYCLES")
    if output is None or not output.inputs["Surface"].is_linked:
        return None
    shown = output.inputs["Surface"].links[0].from_socket
    node, both = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeAddShader")
    node.name = node.label = "Bentlight Stars"
    node.location, both.location = output.location, output.location
    node.location.y -= 200
    node[STARS_MARK] = ""
    shaders.fill_node(node, shaders.compiled("stars"), {})
    tree.links.new(shown, both.inputs[0])
    tree.links.new(node.outputs["BSDF"], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    return node


def _value(node: bpy.types.Node, name: str, missing: object) -> object:
    socket = node.inputs.get(name)
    return socket.default_value if socket else missing


def _key(world: bpy.types.World) -> str:
    """Tells whether stars are what they were."""
    settings = world.bentlight
    values = [getattr(settings, name) for name in BentlightWorldSettings.__annotations__]
    values = [tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value for value in values]
    if settings.stars == "CATALOG":
        path = bpy.path.abspath(settings.star_catalog, library=world.library)
        values.append(os.stat(path).st_mtime_ns if os.path.isfile(path) else None)
    return repr(values)


def _fill(node: bpy.types.Node, world: bpy.types.World) -> None:
    """Writes the table, and tells the shader of it."""
    stars = read_stars(world)
    size = star_cells.size_for(len(stars.directions))
    strength = max(float(stars.irradiance.max(initial=0)) / _BRIGHTEST, 1e-30)
    cells = star_cells.star_cells(stars.directions, stars.irradiance / strength, size)
    inputs = {
        "Cells": ("NodeSocketString", str(files.named_by_content("stars", cells))),
        "Size": ("NodeSocketInt", size),
        "Strength": ("NodeSocketFloat", strength),
    }
    shaders.fill_node(node, shaders.compiled("stars"), inputs)


def _pixel_angle(scene: bpy.types.Scene) -> float:
    """About that of a pixel of the scene's camera, or of the one that a relay camera stands for."""
    shown = scene.camera and (scene.camera.bentlight.relay_source or scene.camera)
    camera = shown.data if shown and shown.type == "CAMERA" else None
    angle = camera.angle if camera and camera.type == "PERSP" else 2 * math.pi
    return angle / max(image_size(scene.render))
