"""Run by the real Blender in its window, with the extension enabled and a scene open: what artists do to a viewport.

`blender SCENE --python drive_viewport.py -- FOLDER` leaves screenshots in FOLDER. Exit code 0 and a last line "viewport
fine" if all went well. A step is what comes before a `yield` of the seconds that Blender gets to itself then.
"""

import math
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driving import area, cube, edited, finished, hole, previews, run, shot, window


def move(x: float) -> None:
    cube().location.x = x


def look(angle: float) -> None:
    import mathutils

    view = area("VIEW_3D").spaces[0].region_3d
    view.view_rotation = mathutils.Euler((math.pi / 2, 0, angle)).to_quaternion()


def steps() -> Iterator[float]:
    space = area("VIEW_3D").spaces[0]
    view = space.region_3d
    view.view_perspective = "CAMERA"
    space.shading.type = "RENDERED"
    yield 4
    assert len(previews()) == 1
    shot("viewport_camera")
    view.view_perspective, view.view_distance, view.view_location = "PERSP", 8.0, (0, 0, 0)
    for i in range(10):
        look(0.1 * i)
        yield 0.1
    yield 2
    shot("viewport_free")
    hole().bentlight.mass = 0.4
    hole().update_tag()
    yield 1
    bpy.ops.ed.undo_push(message="before")
    cube().location.x += 0.5
    bpy.ops.ed.undo_push(message="after")
    yield 0.5
    with bpy.context.temp_override(window=window(), area=area("VIEW_3D")):
        bpy.ops.ed.undo()
        yield 0.5
        bpy.ops.ed.redo()
    yield 0.5
    for engine in ("CYCLES", "BENTLIGHT", "BLENDER_WORKBENCH", "BENTLIGHT"):
        bpy.context.scene.render.engine = engine
        yield 0.7
    assert len(previews()) == 1, "a viewport that is gone still renders"
    bpy.context.scene.bentlight.preview_samples = 1
    bpy.context.scene.update_tag()
    yield from finished()
    for i in range(5):
        yield from edited(partial(move, 0.1 * i))
    bpy.context.scene.camera.location = hole().location  # an error is shown, and nothing hangs
    view.view_perspective = "CAMERA"
    yield 1
    bpy.data.objects.remove(hole())
    bpy.data.objects.remove(bpy.context.scene.camera)
    yield 1
    space.shading.type = "SOLID"
    yield 1
    assert not previews()


run(steps, "viewport")
