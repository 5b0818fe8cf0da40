"""The screen of a relay camera, for pictures in which something moves, accretion disks shine or images of the sky are
filtered: a square right before it with the shader that knows each ray's moment, what it has gathered and how it spreads
(osl/relay_screen.osl). Only camera rays see it."""

from __future__ import annotations

import bpy
import mathutils

from . import filtered_sky, light_groups, shaders

_SHADER = "relay_screen"
_NEAR = 1e-4  # of the screen's side: how far it is before the camera
_CORNERS = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))  # the image with more around it than a pixel filter sees
_KINDS = {int: "NodeSocketInt", float: "NodeSocketFloat", str: "NodeSocketString"}
_PARAMETERS = ("Maps", "Width", "Height", "Margin", "Band", "Parts", "Slices", "Disks", "Far", "SkyFilter")


def find(relay: bpy.types.Object) -> bpy.types.Object | None:
    """The screen of a relay camera, if it has one."""
    return next((child for child in relay.children if child.bentlight.made_for_cycles == "SCREEN"), None)


def show(
    relay: bpy.types.Object,
    parameters: dict[str, int | float | str],
    side: float,
    sky: filtered_sky.Sky | None,
    group: str,
) -> None:
    """Puts the screen before a relay camera; `side`: scene units; `sky`: what it filters; `group`: its light group."""
    screen = find(relay) or _build(relay)
    distance = _NEAR * side
    screen.matrix_basis = mathutils.Matrix.LocRotScale((0, 0, -distance), None, (side, side, side))
    inputs = {name: (_KINDS[type(parameters[name])], parameters[name]) for name in _PARAMETERS}
    inputs["Distance"] = ("NodeSocketFloat", distance)
    shaders.fill(screen.data.materials[0], _SHADER, inputs, filtered_sky.SOCKETS)
    filtered_sky.update(screen.data.materials[0], sky)
    light_groups.put(screen, group)


def hide(relay: bpy.types.Object) -> None:
    """Takes it away."""
    screen = find(relay)
    if screen is not None:
        filtered_sky.clear(screen.data.materials[0])
        shaders.remove(screen)


def _build(relay: bpy.types.Object) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(f"{relay.name} Screen")
    mesh.from_pydata(_CORNERS, [], [(0, 1, 2, 3)])
    mesh.materials.append(shaders.new_material(mesh.name, _SHADER, filtered_sky.SOCKETS))
    screen = bpy.data.objects.new(mesh.name, mesh)
    screen.bentlight.made_for_cycles = "SCREEN"
    screen.parent = relay
    screen.display_type, screen.hide_select = "WIRE", True
    for kind in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(screen, f"visible_{kind}", False)
    (relay.users_collection or (bpy.context.scene.collection,))[0].objects.link(screen)
    return screen
