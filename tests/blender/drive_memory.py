"""Run by the real Blender in its window, with the extension enabled and a scene open: a viewport's memory over edits.

`LD_PRELOAD=libstdc++.so.6:libc.so.6 blender SCENE --window-geometry 0 0 640 480 --python drive_memory.py -- FOLDER`:
the C library tells what is allocated, while TBB's allocator, which Blender brings, tells nothing; and in a small window
edits are drawn quickly. Exit code 0 and a last line "memory fine" if all went well, before it what was measured.
"""

import ctypes
import math
import os
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from statistics import median

import bpy
from mathutils import Euler

sys.path.insert(0, str(Path(__file__).parent))
from driving import area, cube, edited, finished, hole, run, window
from heap import allocated_bytes

EDITS, EACH = 1000, 50  # memory is measured after each so many
SETTLED = 200  # Blender's caches, and the allocator's, fill at first
COMPARED = 5  # measurements, of which the middle one counts: Blender now and then holds a MiB for a moment
RESIDENT_GROWTH, HEAP_GROWTH = 4.0, 1.0  # MiB after the first ones, as in tests/engine/test_viewport_edits.py


def move(number: int) -> None:
    cube().location.x = math.sin(0.1 * number)


def weigh(number: int) -> None:
    hole().bentlight.mass = 0.2 + 0.1 * math.sin(0.1 * number)
    hole().update_tag()


def look(number: int) -> None:
    area("VIEW_3D").spaces[0].region_3d.view_rotation = Euler((math.pi / 2, 0, 0.01 * number)).to_quaternion()


def undo(number: int) -> None:
    """Takes a move back; all is new to a viewport then."""
    bpy.ops.ed.undo_push(message="before")
    move(number)
    bpy.ops.ed.undo_push(message="moved")
    with bpy.context.temp_override(window=window(), area=area("VIEW_3D")):
        bpy.ops.ed.undo()


KINDS = (move, weigh, look, undo)


def resident() -> float:
    """MiB, without what is free."""
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / 2**20


def bounded(name: str, memory: list[float], growth: float) -> None:
    print(f"{name}, in MiB:", *(f"{value:.2f}" for value in memory), flush=True)
    settled = memory[SETTLED // EACH :]
    grown = median(settled[-COMPARED:]) - median(settled[:COMPARED])
    assert grown < growth, f"{name} grows by {grown:.2f} MiB"


def open_view() -> None:
    """Rendered shading of the middle of the view: an edit costs little then but what a viewport does for it."""
    space = area("VIEW_3D").spaces[0]
    view = space.region_3d
    view.view_perspective, view.view_distance, view.view_location = "PERSP", 8.0, (0, 0, 0)
    space.use_render_border = True
    space.render_border_min_x = space.render_border_min_y = 0.4
    space.render_border_max_x = space.render_border_max_y = 0.6
    space.shading.type = "RENDERED"
    bpy.context.scene.bentlight.preview_samples = 1


def steps() -> Iterator[float]:
    """Memory is compared only while the last sample is shown: a finer picture in the making has buffers of its own."""
    open_view()
    yield 3
    bpy.context.scene.update_tag()
    yield from finished()
    held, heap = [], []
    for number in range(1, EDITS + 1):
        yield from edited(partial(KINDS[number % len(KINDS)], number))
        if number % EACH == 0:
            yield from finished()
            held.append(resident())
            heap.append(allocated_bytes() / 2**20)
    assert min(heap) > 100, "Blender does not allocate by the C library"
    bounded("resident memory", held, RESIDENT_GROWTH)
    bounded("the heap", heap, HEAP_GROWTH)


run(steps, "memory")
