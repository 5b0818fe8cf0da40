"""Run by the real Blender in its window, with the extension enabled: what a viewport in Rendered shading is to show.

`blender --python drive_views.py -- FOLDER` leaves screenshots in FOLDER. Exit code 0 and a last line "views fine" if
all went well. Everything is red, green or blue to the last bit: local view, view layers, borders, cameras and sizes are
told by counting pixels. A step is what comes before a `yield` of the seconds that Blender gets to itself then.
"""

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from driving import area, finished, pictures, previews, read, run, shot, window

RED, GREEN, BLUE = np.eye(3)


def emission(color: np.ndarray) -> bpy.types.Material:
    material = bpy.data.materials.new("Emission")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*color, 1)
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def add_cube(name: str, x: float, color: np.ndarray) -> bpy.types.Object:
    """In a collection of its own, of the same name."""
    mesh = bpy.data.meshes.new(name)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(emission(color))
    cube = bpy.data.objects.new(name, mesh)
    cube.location.x = x
    collection = bpy.data.collections.new(name)
    collection.objects.link(cube)
    bpy.context.scene.collection.children.link(collection)
    return cube


def add_camera(name: str, x: float) -> bpy.types.Object:
    camera = bpy.data.objects.new(name, bpy.data.cameras.new(name))
    camera.location, camera.rotation_euler = (x, -10, 0), (math.pi / 2, 0, 0)
    bpy.context.scene.collection.objects.link(camera)
    return camera


def make_scene() -> None:
    """A red and a green cube side by side before a blue sky, and a small hole between them; two view layers."""
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.context.temp_override(window=window()):
        scene = bpy.context.scene
        scene.render.engine = "BENTLIGHT"
        scene.view_settings.view_transform = "Raw"
        scene.bentlight.preview_samples = 2
        scene.world = bpy.data.worlds.new("World")
        scene.world.use_nodes = True
        background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
        background.inputs["Color"].default_value = (*BLUE, 1)
        add_cube("Red", -2.5, RED)
        add_cube("Green", 2.5, GREEN)
        scene.camera, _ = add_camera("Both", 0), add_camera("At Red", -2.5)
        bpy.data.objects["At Red"].data.lens = 120.0
        bpy.ops.bentlight.black_hole_add(mass=0.01, location=(0, 0, 2))
        scene.view_layers.new("Only Red").layer_collection.children["Green"].exclude = True


def region(view: bpy.types.Area) -> bpy.types.Region:
    return next(region for region in view.regions if region.type == "WINDOW")


def seen(name: str, view: bpy.types.Area | None = None) -> np.ndarray:
    """What a viewport shows: (height, width, 3), rows upwards."""
    place = region(view or area("VIEW_3D"))
    return read(shot(f"views_{name}"))[place.y : place.y + place.height, place.x : place.x + place.width]


def part_of(pixels: np.ndarray, color: np.ndarray) -> float:
    """How much of a picture is of a color."""
    return float((abs(pixels - color) < 0.02).all(axis=-1).mean())


def middle(pixels: np.ndarray, color: np.ndarray) -> np.ndarray:
    """Of the pixels that have just this color: row and column."""
    return np.argwhere((abs(pixels - color) < 0.02).all(axis=-1)).mean(axis=0)


def colors(pixels: np.ndarray) -> str:
    """Of red, green and blue those that there is some of."""
    return "".join(name for name, color in zip("RGB", (RED, GREEN, BLUE), strict=True) if part_of(pixels, color) > 0.01)


def steps() -> Iterator[float]:
    make_scene()
    space = area("VIEW_3D").spaces[0]
    space.overlay.show_overlays = space.show_gizmo = False
    with bpy.context.temp_override(window=window(), area=area("VIEW_3D"), region=region(area("VIEW_3D"))):
        space.show_region_header = space.show_region_tool_header = False
        space.show_region_toolbar = space.show_region_ui = False
    look(space.region_3d)
    space.shading.type = "RENDERED"
    yield 0.5
    yield from finished()
    assert colors(seen("free")) == "RGB"
    for step in (local_view, view_layers, border, cameras, sizes):
        yield from step()


def look(view: bpy.types.RegionView3D) -> None:
    import mathutils

    view.view_perspective, view.view_distance, view.view_location = "PERSP", 14.0, (0, 0, 0)
    view.view_rotation = mathutils.Euler((math.pi / 2, 0, 0)).to_quaternion()


def local_view() -> Iterator[float]:
    """It has what was selected alone, where the user looks; leaving it brings back the rest."""
    view = area("VIEW_3D")
    for name in ("Red", "Green"):
        for obj in bpy.context.scene.objects:
            obj.select_set(obj.name == name)
        for expected in (name[0] + "B", "RGB"):
            with bpy.context.temp_override(window=window(), area=view, region=region(view)):
                bpy.ops.view3d.localview(frame_selected=False)
            yield from finished()
            assert colors(seen(f"local_{expected}")) == expected


def view_layers() -> Iterator[float]:
    layers = bpy.context.scene.view_layers
    for layer, expected in (("Only Red", "RB"), (layers[0].name, "RGB")):
        window().view_layer = layers[layer]
        yield from finished()
        assert colors(seen(f"layer_{expected}")) == expected


def border() -> Iterator[float]:
    """Within it is the same picture, and around it nothing: in a free view, and in a camera's."""
    view = area("VIEW_3D")
    space, render = view.spaces[0], bpy.context.scene.render
    for perspective in ("PERSP", "CAMERA"):
        space.region_3d.view_perspective = perspective
        yield from finished()
        whole = seen(f"border_{perspective}_off")
        owner, names = (space, "render_border") if perspective == "PERSP" else (render, "border")
        for name, value in (("min_x", 0.5), ("max_x", 0.9), ("min_y", 0.25), ("max_y", 0.75)):
            setattr(owner, f"{names}_{name}", value)
        switch = "use_render_border" if perspective == "PERSP" else "use_border"
        setattr(owner, switch, True)
        yield from finished()
        cut = seen(f"border_{perspective}")
        (((width, height), *_),) = pictures()
        assert width < 0.52 * whole.shape[1] and height < 0.52 * whole.shape[0]
        assert (colors(cut), colors(whole)) == ("GB", "RGB")
        rows, columns = np.nonzero((abs(cut - GREEN) < 0.02).all(axis=-1) | (abs(cut - BLUE) < 0.02).all(axis=-1))
        assert (np.ptp(columns) + 1, np.ptp(rows) + 1) == (width, height)
        assert len(rows) > 0.99 * width * height, "nothing but the picture is within the border"
        part = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
        np.testing.assert_allclose(middle(cut[part], GREEN), middle(whole[part], GREEN), atol=1.0)
        setattr(owner, switch, False)
    yield from finished()
    assert colors(seen("border_gone")) == "RGB"


def cameras() -> Iterator[float]:
    """The scene's, or one that the viewport has for itself."""
    space = area("VIEW_3D").spaces[0]
    space.region_3d.view_perspective = "CAMERA"
    for local, expected in ((True, "RB"), (False, "RGB")):
        space.use_local_camera = local
        if local:  # otherwise Blender would take it for the scene's
            space.camera = bpy.data.objects["At Red"]
        yield from finished()
        assert colors(seen(f"camera_{expected}")) == expected


def sizes() -> Iterator[float]:
    """Pictures are as large as their viewports, also where one becomes two, and one again."""
    view = area("VIEW_3D")
    view.spaces[0].region_3d.view_perspective = "PERSP"
    yield from finished()
    before = expect_sizes()
    for direction in ("VERTICAL", "HORIZONTAL"):
        with bpy.context.temp_override(window=window(), area=area("VIEW_3D"), region=region(area("VIEW_3D"))):
            bpy.ops.screen.area_split(direction=direction, factor=0.6)
        yield 1
        for each in viewports():
            each.spaces[0].shading.type = "RENDERED"  # Blender makes new ones solid
        yield 1
        yield from finished()
        assert len(previews()) == 2 and expect_sizes() != before
        for each in viewports():
            assert "B" in colors(seen(f"split_{direction.lower()}_{each.x}_{each.y}", each))
        other = min(viewports(), key=lambda each: each.width * each.height)
        with bpy.context.temp_override(window=window(), area=other, region=region(other)):
            bpy.ops.screen.area_close()
        yield 1
        yield from finished()
        assert len(previews()) == 1, "a viewport that is gone still renders"
        assert expect_sizes() == before


def viewports() -> list[bpy.types.Area]:
    return [each for each in window().screen.areas if each.type == "VIEW_3D"]


def expect_sizes() -> list[tuple[int, int]]:
    """Of all viewports, which must be those of their pictures."""
    shown = sorted(drawn.size for drawn in pictures())
    there = sorted((region(each).width, region(each).height) for each in viewports())
    assert shown == there
    return there


run(steps, "views")
