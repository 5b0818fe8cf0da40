"""Run by the real Blender in its window, with the extension enabled and a scene open: files are loaded meanwhile.

`blender SCENE --python drive_loading.py -- FOLDER` loads other files while a viewport renders, and while F12 does,
which may have been stopped just before. Exit code 0 and a last line "loading fine" if Blender lives, and nothing
goes on. A step is what comes before a `yield` of the seconds that Blender gets to itself then.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driving import F12, OUT, area, finished, press, previews, run

BUSY = str(OUT / "busy.blend")  # renders without end


def load_empty() -> None:
    bpy.ops.wm.read_homefile(use_empty=True)


def load_startup() -> None:
    bpy.ops.wm.read_homefile()


def load_busy() -> None:
    bpy.ops.wm.open_mainfile(filepath=BUSY)


def is_rendering() -> bool:
    return bpy.app.is_job_running("RENDER")


def steps() -> Iterator[float]:
    bpy.context.preferences.view.render_display_type = "AREA"
    scene = bpy.context.scene
    scene.bentlight.preview_samples, scene.bentlight.samples = 0, 1 << 16
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    area("VIEW_3D").spaces[0].region_3d.view_perspective = "CAMERA"
    bpy.ops.wm.save_as_mainfile(filepath=BUSY)
    yield from while_a_viewport_renders()
    yield from while_f12_renders()
    yield from begin()
    bpy.context.scene.bentlight.preview_samples = 2
    bpy.context.scene.update_tag()
    yield from finished()
    Path(BUSY).unlink()


def begin() -> Iterator[float]:
    """A viewport renders: Blender loads none in Rendered shading."""
    load_busy()
    yield 0.2
    area("VIEW_3D").spaces[0].shading.type = "RENDERED"
    yield from until(previews, "no viewport renders")


def while_a_viewport_renders() -> Iterator[float]:
    """At once, in its first pictures, and later."""
    for load in (load_busy, load_startup, load_empty):
        for pause in (0.0, 0.1, 0.7):
            yield from begin()
            yield pause
            load()
            yield from until(lambda: not previews(), "one that is gone still renders")


def while_f12_renders() -> Iterator[float]:
    """Straight away, or after Escape."""
    for load in (load_busy, load_startup, load_empty):
        for escapes in (False, True):
            load_busy()
            yield 0.5
            press("VIEW_3D", F12)
            yield from until(is_rendering, "F12 does not render")
            yield 0.5
            if escapes:
                press("IMAGE_EDITOR", "Escape")
                yield 0.0
            start = time.monotonic()
            load()
            assert time.monotonic() < start + 5, "loading waits for the render"
            yield 0.5
            assert not is_rendering(), "a render goes on in another file"
    load_busy()
    bpy.context.scene.bentlight.samples = 1
    yield 0.5
    press("VIEW_3D", F12)
    yield from until(is_rendering, "F12 does not render after all that")
    yield from until(lambda: not is_rendering(), "nor does it end")


def until(is_so, otherwise: str, seconds: float = 20.0) -> Iterator[float]:
    """Waits for something that is to become so."""
    end = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < end, otherwise
        yield 0.05


run(steps, "loading")
