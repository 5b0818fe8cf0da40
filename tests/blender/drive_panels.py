"""Run by the real Blender in its window, with the extension enabled: every panel and the overlay, in every state.

`blender --python drive_panels.py -- FOLDER` leaves screenshots in FOLDER. Exit code 0 and a last line "panels fine" if
all went well; what a panel or the overlay raises while it is drawn is on stderr, as a Traceback. A step is what comes
before a `yield` of the seconds that Blender gets to itself then.
"""

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driving import area, read, run, shot, window

# Least and largest red, green and blue of what the overlay draws, as it is on the screen; nothing else there has them.
HORIZON = ((0.86, 0.2, 0.1), (1.0, 0.34, 0.26))
ORBIT = ((0.0, 0.7, 0.75), (0.5, 1.0, 1.0))  # the last stable one
PHOTONS = ((0.86, 0.67, 0.0), (1.0, 1.0, 0.42))
DISK = ((0.8, 0.36, 0.0), (1.0, 0.58, 0.35))
THROAT = ((0.55, 0.36, 0.87), (0.74, 0.58, 1.0))
RAYS = ((0.59, 0.77, 0.91), (0.84, 0.95, 1.0))
VIEWPORT = (slice(60, 960), slice(90, 740))  # pixels, from the left and from below, without headers
TABS = ("RENDER", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "DATA", "MATERIAL")


def drawn(name: str, color: tuple) -> int:
    """How many pixels of a color a new screenshot of the viewport has."""
    x, y = VIEWPORT
    part = read(shot(name))[y, x]
    return int(((part >= color[0]) & (part <= color[1])).all(axis=-1).sum())


def hole() -> bpy.types.Object:
    """Looked up each time: undoing makes all objects anew."""
    return bpy.context.scene.objects["Hole"]


def open_all_panels() -> None:
    """Those that are closed at first too."""
    ui = sys.modules["bl_ext.user_default.bentlight.ui"]
    ui.unregister()
    for panel in ui.CLASSES:
        panel.bl_options = set(getattr(panel, "bl_options", ())) - {"DEFAULT_CLOSED"}
    ui.register()


def make_scene() -> None:
    """A new file with a floor, a cube, a hole, a lamp and a camera."""
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.context.temp_override(window=window()):
        fill(bpy.context.scene)


def fill(scene: bpy.types.Scene) -> None:
    scene.render.engine = "BENTLIGHT"
    scene.world = bpy.data.worlds.new("World")
    bpy.ops.mesh.primitive_cube_add(size=1, location=(2.5, 1, 0))
    bpy.context.object.data.materials.append(bpy.data.materials.new("Wall"))
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -2.5))
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 4))
    bpy.ops.object.camera_add(location=(0, -9, 1), rotation=(math.radians(85), 0, 0))
    scene.camera = bpy.context.object
    bpy.ops.bentlight.black_hole_add(mass=0.5, location=(0, 0, 0))
    bpy.context.object.name = "Hole"


def look(view: bpy.types.RegionView3D) -> None:
    import mathutils

    view.view_perspective, view.view_distance, view.view_location = "PERSP", 11.0, (0, 0, 0)
    view.view_rotation = mathutils.Euler((math.radians(65), 0, 0.4)).to_quaternion()


def steps() -> Iterator[float]:
    make_scene()
    open_all_panels()
    yield 1
    yield from overlay()
    yield from panels()
    yield from popups()


def overlay() -> Iterator[float]:
    scene, space = bpy.context.scene, area("VIEW_3D").spaces[0]
    look(space.region_3d)
    space.shading.type = "SOLID"
    settings = scene.bentlight.overlay
    settings.rays = "CAMERA"
    yield 1
    for color in (ORBIT, PHOTONS, RAYS):
        assert drawn("overlay_schwarzschild", color) > 200
    settings.rays = "OFF"  # captured ones are nearly as red as the horizon
    space.region_3d.view_distance = 5.0  # a small circle has no name
    yield 0.5
    names = [drawn("overlay_labels", color) for color in (HORIZON, ORBIT, PHOTONS)]
    settings.show_labels = False
    area("VIEW_3D").tag_redraw()
    yield 0.5
    circles = [drawn("overlay_circles", color) for color in (HORIZON, ORBIT, PHOTONS)]
    assert min(circles) > 15, circles  # the horizon is the smallest
    assert min(a - b for a, b in zip(names, circles, strict=True)) > 30, (names, circles)
    settings.show_labels = True
    look(space.region_3d)
    hole().bentlight.spin, hole().bentlight.disk.enable, settings.rays = 0.9, True, "CURSOR"
    hole().bentlight.disk.outer_radius = 8.0
    scene.cursor.location = (-4, -1, 0)
    yield 1
    assert drawn("overlay_kerr", DISK) > 1000
    for shading in ("MATERIAL", "RENDERED", "WIREFRAME", "SOLID"):
        space.shading.type = shading
        yield 1
        assert drawn(f"overlay_{shading.lower()}", PHOTONS) > 500, shading
    settings.rays = "CAMERA"
    with bpy.context.temp_override(window=window()):
        bpy.ops.bentlight.wormhole_add(throat_radius=0.6, location=(-4, 2, 0), exit_location=(5, -3, 0))
    yield 1
    assert drawn("overlay_wormhole", THROAT) > 100
    bpy.ops.ed.undo_push(message="before")
    bpy.data.objects.remove(hole())
    bpy.ops.ed.undo_push(message="after")
    yield 0.5
    with bpy.context.temp_override(window=window()):
        bpy.ops.ed.undo()
    yield 0.5
    hole().hide_set(True)
    yield 0.5
    assert drawn("overlay_hidden", PHOTONS) == 0
    assert drawn("overlay_hidden", HORIZON) < 20  # a captured ray
    hole().hide_set(False)
    bpy.context.view_layer.objects.active = hole()
    hole().select_set(True)
    view = area("VIEW_3D")
    region = next(region for region in view.regions if region.type == "WINDOW")
    for _ in range(2):
        with bpy.context.temp_override(window=window(), area=view, region=region):
            bpy.ops.view3d.localview()
        yield 0.5
    space.region_3d.view_perspective = "CAMERA"
    yield 0.5
    bpy.context.scene.camera.location = hole().location  # why there are no rays is said
    yield 0.5
    assert drawn("overlay_refused", RAYS) == 0
    make_scene()  # a file is loaded
    yield 1
    yield from without_extension()


def popups() -> Iterator[float]:
    """The switches of the overlay, presets and menus, as they open at the mouse; one over the other."""
    bpy.context.preferences.view.ui_scale = 1.0
    view = area("PROPERTIES")
    view.type = "VIEW_3D"
    select("Hole")
    yield 0.5
    for operator, name in (
        ("call_panel", "VIEW3D_PT_overlay"),
        ("call_panel", "BENTLIGHT_PT_spacetime_presets"),
        ("call_menu", "BENTLIGHT_MT_spacetime"),
        ("call_menu", "VIEW3D_MT_add"),
    ):
        first = window()
        first.cursor_warp(500, 300)
        yield 0.3
        with bpy.context.temp_override(window=first, area=view, region=view.regions[-1]):
            getattr(bpy.ops.wm, operator)("INVOKE_DEFAULT", name=name)
        yield 0.7
        shot(f"popup_{name.lower()}")


def without_extension() -> Iterator[float]:
    """Taken away and brought back while the overlay is drawn."""
    name = "bl_ext.user_default.bentlight"
    for do in ("disable", "enable"):
        getattr(bpy.ops.preferences, f"addon_{do}")(module=name)
        area("VIEW_3D").tag_redraw()
        yield 0.7
        count = drawn(f"overlay_{do}d", ORBIT)
        assert count > 200 if do == "enable" else count == 0, (do, count)
    open_all_panels()
    bpy.context.scene.render.engine = "BENTLIGHT"
    yield 0.5


def panels() -> Iterator[float]:
    editor = area("VIEW_3D")
    editor.type = "PROPERTIES"
    bpy.context.preferences.view.ui_scale = 0.6  # more of them on a screenshot
    scene = bpy.context.scene
    for engine in ("BENTLIGHT", "CYCLES"):
        scene.render.engine = engine
        for state, change in STATES.items():
            change()
            for tab in TABS:
                try:
                    editor.spaces[0].context = tab
                except TypeError:  # this object has none
                    continue
                yield 0.3
                if state in {"new", "full", "warned"}:
                    shot(f"panel_{engine.lower()}_{state}_{tab.lower()}")


def select(name: str) -> None:
    bpy.context.view_layer.objects.active = bpy.context.scene.objects[name]


def make_full() -> None:
    """All that adds to panels."""
    select("Hole")
    scene, settings = bpy.context.scene, hole().bentlight
    settings.spin, settings.disk.enable, settings.disk.inner_edge = 0.7, True, "CUSTOM"
    scene.bentlight.accuracy = "CUSTOM"
    scene.world.bentlight.stars = "PROCEDURAL"


def make_mouth() -> None:
    hole().bentlight.kind = "WORMHOLE"
    hole().bentlight.exit = None


def make_impossible() -> None:
    hole().bentlight.kind = "BLACK_HOLE"
    hole().scale = (0, 0, 0)
    bpy.context.scene.world = None


def set_emission(kind: str) -> None:
    hole().scale = (1, 1, 1)
    hole().bentlight.disk.emission = kind


def make_warned() -> None:
    """Whatever panels warn of."""
    scene = bpy.context.scene
    cube = scene.objects["Cube"]
    cube.location = (0, 0, 0)
    nodes = cube.active_material.node_tree.nodes
    if "Bevel" not in nodes:
        bevel = nodes.new("ShaderNodeBevel")
        surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
        cube.active_material.node_tree.links.new(bevel.outputs[0], surface.inputs["Normal"])
    scene.camera.location = (0, -0.4, 0)
    select("Cube")


STATES = {
    "new": lambda: select("Hole"),
    "full": make_full,
    **{kind: lambda kind=kind: set_emission(kind) for kind in ("POWER_LAW", "RAMP", "IMAGE", "MATERIAL")},
    "cube": lambda: select("Cube"),
    "warned": make_warned,
    "camera": lambda: select("Camera"),
    "lamp": lambda: select("Point"),
    "mouth": lambda: (select("Hole"), make_mouth()),
    "impossible": make_impossible,
    "nothing": lambda: setattr(bpy.context.view_layer.objects, "active", None),
    "back": lambda: (set_emission("PAGE_THORNE"), setattr(bpy.context.scene, "world", bpy.data.worlds[0])),
}


run(steps, "panels")
