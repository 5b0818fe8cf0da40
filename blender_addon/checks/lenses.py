"""What Cycles does not show as it is, through lenses or by the relay camera."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np

from ..cycles import failures, filtered_sky, lens, light_groups, radius, relay, screen, setup, stars
from ..report import RenderError, told
from ..sync import spacetime
from ..sync.scene_data import SpacetimeData
from .finding import Finding
from .spacetimes import INSTANCES_MAX


def settings(scene: bpy.types.Scene) -> tuple:
    """What findings depend on and Blender tells of no change of: settings of Cycles, and what handlers could not do."""
    if scene.render.engine != "CYCLES":
        return ()
    own = scene.cycles.device, setup.gpu_kind(), scene.cycles.shading_system
    overrides = [layer.material_override is None for layer in scene.view_layers]
    return *own, *overrides, *filtered_sky.settings(scene), *light_groups.settings(scene), *failures.of_scene(scene)


def unmade(scene: bpy.types.Scene, known: list[Finding]) -> Iterator[Finding]:
    """What handlers could not do, unless a finding tells it already."""
    for text in failures.of_scene(scene):
        if not any(found.text in text for found in known):
            yield Finding(text, "SCENE", scene.name)


def shaders_unread(scene: bpy.types.Scene) -> Iterator[Finding]:
    """Settings of Cycles with which it takes no notice of our shaders."""
    if not setup.is_set_up(scene) and relay.source_of(scene.camera) is None:
        return
    if not scene.cycles.shading_system:
        text = "Open Shading Language is off in the render properties: Cycles bends no light"
        yield Finding(told(text), "SCENE", scene.name)
    if scene.cycles.device == "GPU" and setup.gpu_kind() != "OPTIX":
        text = "Cycles renders on a graphics card without OptiX, where it bends no light: choose OptiX or the CPU"
        yield Finding(told(text), "SCENE", scene.name)
    if lens.all_of(scene) or (scene.camera and screen.find(scene.camera)):
        for layer in scene.view_layers:
            if layer.material_override:
                text = "View layer '{}' overrides materials, those of lenses too: Cycles bends no light there"
                yield Finding(told(text, layer.name), "SCENE", scene.name)


def left_out(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, depsgraph: bpy.types.Depsgraph, items: list[SpacetimeData]
) -> Iterator[Finding]:
    """What lenses do not show: disks, meshes, lamps and stars. Raises RenderError for lenses that overlap."""
    lenses = lens.find(scene)
    held = [
        radius.with_lens_radius(item, scene.objects[item.name].evaluated_get(depsgraph))
        for item in items
        if item.name in lenses and item.name in scene.objects
    ]
    if not held:
        return
    radii = spacetime.influence_radii(held)
    for item, used in zip(held, radii, strict=True):
        hole = scene.objects[item.name]
        place = hole.evaluated_get(depsgraph).matrix_world.translation
        obstacles = radius.distances(scene, depsgraph, place, within=used, most=INSTANCES_MAX)
        for text in setup.left_out(hole, item, used, obstacles):
            yield Finding(text, "OBJECT", item.name)
    yield from _lost_lamps(view_layer, depsgraph, held, radii)
    for text in stars.warnings(scene):
        yield Finding(text, "WORLD", scene.world.name)


def unfiltered(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> Iterator[Finding]:
    """Skies that neither lenses nor a relay camera filter."""
    if lens.all_of(scene) or relay.source_of(scene.camera) is not None:
        for text in filtered_sky.read(scene, depsgraph)[1]:
            yield Finding(text, "WORLD", scene.world.name)


def ungrouped(scene: bpy.types.Scene) -> Iterator[Finding]:
    """What a relay camera shows in no light group."""
    if relay.source_of(scene.camera) is not None:
        for text in light_groups.warnings(scene):
            yield Finding(text, "SCENE", scene.name)


def _lost_lamps(
    view_layer: bpy.types.ViewLayer, depsgraph: bpy.types.Depsgraph, held: list[SpacetimeData], radii: list[float]
) -> Iterator[Finding]:
    """Lamps inside of lenses: what blocks Cycles' shadow rays blocks all of their light."""
    for obj in view_layer.objects:
        if obj.type != "LIGHT" or obj.data.type == "SUN" or obj.hide_render:
            continue
        place = np.array(obj.evaluated_get(depsgraph).matrix_world.translation)
        for item, used in zip(held, radii, strict=True):
            if np.linalg.norm(place - item.origin) < used:
                text = "'{}' is inside the lens of '{}', and its light does not get out of it in Cycles"
                yield Finding(told(text, obj.name, item.name), "OBJECT", obj.name, (item.name,))


def findings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, depsgraph: bpy.types.Depsgraph, items: list[SpacetimeData]
) -> list[Finding]:
    """All of it; `items` can be rendered."""
    found = [*shaders_unread(scene), *unfiltered(scene, depsgraph), *ungrouped(scene)]
    try:
        return found + list(left_out(scene, view_layer, depsgraph, items))
    except RenderError as error:
        return [*found, Finding(str(error), "OBJECT", items[0].name)]
