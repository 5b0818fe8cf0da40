"""Use in Cycles: what the button does to a scene, what takes it back, and what keeps it as the holes are."""

from __future__ import annotations

import json
import math

import bpy

from ..report import RenderError, told
from ..sync import spacetime
from ..sync.scene_data import SpacetimeData
from . import disk, disk_material, filtered_sky, lens, light_groups, radius, stars, tables


def is_set_up(scene: bpy.types.Scene) -> bool:
    """Whether the scene has been made ready for Cycles."""
    return bool(scene.bentlight.cycles_before)


def setup(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> tuple[list[str], list[str]]:
    """Gives every hole a lens and Cycles the settings it needs; may be repeated. Returns what it did, and warnings.

    Raises RenderError as a render would, and then has changed nothing.
    """
    holes = _holes(scene, depsgraph)
    if not any(holes):
        raise RenderError("There is no black hole or wormhole in this scene")
    items = [lens.read(hole, depsgraph) for hole in holes]
    spacetime.check(items)
    stars.check(scene)
    chosen, warnings = _choose_radii(scene, depsgraph, holes, items)
    tables.check()
    for item in items:
        tables.ensured("ellis" if item.kind == "WORMHOLE" else "schwarzschild")
    lens.remove_orphans(scene)
    existing = lens.find(scene)
    for hole in holes:
        if hole.name not in existing:
            lens.build(hole)
    for name, obj in existing.items():
        if name not in {hole.name for hole in holes}:
            lens.remove(obj)
    for hole, own in chosen.items():
        hole.bentlight.lens_radius = own
        hole.bentlight.lens_is_automatic = True
    depsgraph.update()
    done = [told("lenses: {}", len(holes)), *_settings(scene, len(holes))]
    update(scene, depsgraph)
    return done, warnings + stars.warnings(scene) + filtered_sky.read(scene, depsgraph)[1]


def _holes(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object]:
    """In the order of their names, as rendered."""
    found = [obj for obj in scene.objects if obj.bentlight.kind != "NONE" and not obj.hide_render]
    return sorted((obj for obj in found if _has_effect(lens.read(obj, depsgraph))), key=lambda obj: obj.name)


def complete(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> list[str]:
    """Gives lenses to holes that are new, and takes away those of holes that are gone. Returns warnings.

    Raises RenderError where holes are not as they must be.
    """
    if any(_holes(scene, depsgraph)):
        return setup(scene, depsgraph)[1]
    lens.remove_orphans(scene)
    return []


def is_complete(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether every hole that renders has its lens, and every lens its hole."""
    existing = lens.find(scene)
    return "" not in existing and all(hole.name in existing for hole in _holes(scene, depsgraph))


def _has_effect(item: SpacetimeData) -> bool:
    return item.kind != "BLACK_HOLE" or item.mass > 0


def _choose_radii(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, holes: list[bpy.types.Object], items: list[SpacetimeData]
) -> tuple[dict[bpy.types.Object, float], list[str]]:
    """Radii for holes that have none, in their own units; and who is inside whose sphere."""
    with_own = [radius.with_lens_radius(item, hole) for item, hole in zip(items, holes, strict=True)]
    chosen, warnings = {}, []
    for hole, item, influence in zip(holes, with_own, spacetime.influence_radii(with_own), strict=True):
        obstacles = radius.distances(scene, depsgraph, hole.evaluated_get(depsgraph).matrix_world.translation)
        used = influence
        if not item.sphere_radius:
            used = radius.automatic(item, influence, obstacles, disk.reach(hole, item))
            chosen[hole] = used / item.scale
        warnings += left_out(hole, item, used, obstacles)
    return chosen, warnings


def left_out(hole: bpy.types.Object, item: SpacetimeData, used: float, obstacles: dict[str, float]) -> list[str]:
    """What a lens of the world radius `used` does not show as it is; obstacles: see radius.distances."""
    warnings = disk.warnings(hole)
    if disk.reach(hole, item) > used:
        text = "The disk of '{}' reaches out of its lens (radius {:.4g}) and ends there"
        warnings.append(told(text, hole.name, used))
    inside = sorted(name for name, distance in obstacles.items() if name and distance < used)
    if inside:
        text = (
            "Inside the lens of '{}' (radius {:.4g}), and not seen bent: {}. "
            "Render with Bentlight, or make the lens smaller"
        )
        warnings.append(told(text, hole.name, used, ", ".join(inside)))
    return warnings


def _settings(scene: bpy.types.Scene, lenses: int) -> list[str]:
    """Sets what Cycles needs, remembers what was, and says what changed."""
    cycles = scene.cycles
    wanted = {"shading_system": True}
    before = json.loads(scene.bentlight.cycles_before or "{}")
    own, given = before.get("transparent_max_bounces", [cycles.transparent_max_bounces] * 2)
    # every leg of a path may cross every lens
    needed = min(1024, own + (cycles.max_bounces + 1) * lenses)
    if cycles.transparent_max_bounces == given:  # not the user's choice since
        wanted["transparent_max_bounces"] = needed
    if cycles.device == "GPU" and gpu_kind() != "OPTIX":
        wanted["device"] = "CPU"
    said = {
        "shading_system": told("Open Shading Language on"),
        "transparent_max_bounces": told("transparent bounces: {}", needed),
        "device": told("device set to CPU (Open Shading Language runs on CPUs and with OptiX only)"),
    }
    done = []
    for name, value in wanted.items():
        old = getattr(cycles, name)
        if old != value:
            setattr(cycles, name, value)
            before[name] = (before[name][0] if name in before else old, value)
            done.append(said[name])
    scene.bentlight.cycles_before = json.dumps(before)
    return done


def gpu_kind() -> str:
    """Which of the kinds of graphics devices Cycles is to use, by the preferences; "NONE" for none of them."""
    addon = bpy.context.preferences.addons.get("cycles")
    return addon.preferences.compute_device_type if addon else "NONE"


def clear(scene: bpy.types.Scene) -> list[str]:
    """Takes back what setup did; settings that the user has changed since stay. Returns what it did."""
    lenses = lens.all_of(scene)
    for obj in lenses:
        if obj.parent:
            _forget_radius(obj.parent.bentlight)
        lens.remove(obj)
    for name, (old, new) in json.loads(scene.bentlight.cycles_before or "{}").items():
        if getattr(scene.cycles, name) == new:
            setattr(scene.cycles, name, old)
    scene.bentlight.property_unset("cycles_before")
    stars.remove(scene)
    return [told("lenses removed: {}, settings of Cycles as they were", len(lenses))]


def _forget_radius(settings: bpy.types.PropertyGroup) -> None:
    """Unless it is the user's own."""
    if settings.lens_is_automatic:
        settings.property_unset("lens_radius")
        settings.property_unset("lens_is_automatic")


def update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Makes every lens what its hole is in this frame, stars, and missing tables. Writes only what has changed.

    Raises RenderError where holes are not as they must be.
    """
    stars.update(scene)
    lenses = {name: obj for name, obj in lens.find(scene).items() if name}
    items, shown = [], set()
    for name, obj in lenses.items():
        hole = obj.parent
        item = radius.with_lens_radius(lens.read(hole, depsgraph), hole.evaluated_get(depsgraph))
        visible = item.kind != "NONE" and _has_effect(item) and not hole.evaluated_get(depsgraph).hide_render
        if obj.hide_render == visible:
            obj.hide_render = not visible
        if visible:
            items.append(item)
            shown.add(name)
    spacetime.check(items)
    found = {item.name: (item, used) for item, used in zip(items, spacetime.influence_radii(items), strict=True)}
    sky, _warnings = filtered_sky.read(scene, depsgraph)
    for name, (item, used) in found.items():
        if not math.isfinite(used):
            raise RenderError("'{}' has no lens radius: press Use in Cycles", name)
        hole = lenses[name].parent.evaluated_get(depsgraph)
        light = disk.sockets(hole, item, scene.frame_current_final)
        light["Gravitational"] = ("NodeSocketFloat", scene.bentlight.gravitational)
        light["SkyFilter"] = ("NodeSocketFloat", filtered_sky.pixels(scene) if sky else 0.0)
        lens.update(
            lenses[name], item, used, found.get(item.exit) if item.exit else None, light, radius.soft_edge(hole)
        )
        light_groups.put(lenses[name], light_groups.of_lens(scene, lenses[name].parent))
        filtered_sky.update(lenses[name].data.materials[0], sky)
        own = disk.material(hole)
        disk_material.update(lenses[name].data.materials[0], own and own.evaluated_get(depsgraph))
