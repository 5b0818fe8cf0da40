"""What drivers of Blender's true window share: screenshots, keys, and steps that leave Blender time in between.

A driver ends with `run(steps, "NAME")`: `steps` is a generator function, and a step is what comes before
a `yield` of the seconds that Blender gets to itself then. Exit code 0 and a last line "NAME fine" if all went well.
"""

import os
import subprocess
import sys
import threading
import time
import traceback
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import bpy
import numpy as np

OUT = Path(sys.argv[sys.argv.index("--") + 1])
F3, F12 = "69", "96"  # keys' codes: by their names xdotool sends them together with Alt


def window() -> bpy.types.Window:
    """The first one, which is the only one."""
    return bpy.context.window_manager.windows[0]


def area(kind: str) -> bpy.types.Area | None:
    """The largest one of a kind, if there is any."""
    found = [area for area in window().screen.areas if area.type == kind]
    return max(found, key=lambda area: area.width * area.height, default=None)


def box(area: bpy.types.Area) -> tuple[int, int, int, int]:
    """x, y, width, height on a screenshot, y from its top."""
    return area.x, window().height - area.y - area.height, area.width, area.height


def shot(name: str) -> Path:
    """Takes a screenshot; returns its file."""
    path = OUT / f"{name}.png"
    subprocess.check_call(["scrot", "-o", str(path)])
    return path


def read(path: Path) -> np.ndarray:
    """A screenshot: (height, width, 3) float32, rows upwards. While Blender 5.2 renders it would hang."""
    image = bpy.data.images.load(str(path))
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(image.size[1], image.size[0], 4)[..., :3]
    bpy.data.images.remove(image)
    return pixels


def cube() -> bpy.types.Object:
    """That of good.blend, as `make_scenes.py` writes it. Looked up each time: undoing makes all objects anew."""
    return next(obj for obj in bpy.context.scene.objects if obj.type == "MESH")


def hole() -> bpy.types.Object:
    """As well."""
    return next(obj for obj in bpy.context.scene.objects if obj.bentlight.kind == "BLACK_HOLE")


def module(name: str) -> ModuleType:
    """One of the extension's."""
    return sys.modules[f"bl_ext.user_default.bentlight.{name}"]


def previews() -> list[threading.Thread]:
    """What runs for viewports, one for each: it must end with them."""
    name = module("progressive").THREAD_NAME
    return [thread for thread in threading.enumerate() if thread.name == name]


class Drawn(NamedTuple):
    """The last picture that a viewport has drawn; nothing that would keep the viewport alive."""

    size: tuple[int, int]  # width, height
    samples: int
    wanted: int  # samples
    wish: weakref.ref
    wishes: int  # of which something was drawn so far
    is_newest: bool  # nothing else was wished for before this was drawn


_drawn: weakref.WeakKeyDictionary = weakref.WeakKeyDictionary()  # by viewport
_wished: weakref.WeakKeyDictionary = weakref.WeakKeyDictionary()  # the newest wish of each that renders for a viewport


def _watch() -> None:
    """Lets viewports tell from now on what they wish for and draw."""
    viewport, progressive = module("viewport").Viewport, module("progressive").Progressive
    if hasattr(viewport, "watched"):
        return
    show, render = viewport._show, progressive.render
    viewport.watched = True

    def wished(self, wish) -> None:
        _wished[self] = weakref.ref(wish)
        render(self, wish)

    def watched(self, *args) -> None:
        show(self, *args)
        made, old = self._preview, _drawn.get(self)
        if made is not None:
            wishes = (old.wishes if old else 0) + (old is None or old.wish() is not made.wish)
            size, wanted = made.pixels.shape[1::-1], made.wish.settings.sample_count
            newest = _wished.get(self._progressive)
            is_newest = newest is None or newest() is made.wish
            _drawn[self] = Drawn(size, made.samples, wanted, weakref.ref(made.wish), wishes, is_newest)

    viewport._show, progressive.render = watched, wished


def pictures() -> list[Drawn]:
    """What the living viewports have drawn last."""
    _watch()
    return list(_drawn.values())


def edited(edit: Callable[[], None], seconds: float = 10.0) -> Iterator[float]:
    """Makes an edit, and waits until the only viewport has drawn something of the scene as it is now."""
    (old,) = pictures()
    edit()
    until = time.monotonic() + seconds
    while (new := pictures()[0]).wishes == old.wishes or not new.is_newest:
        assert time.monotonic() < until, "an edit is never drawn"
        yield 0.0


def finished(seconds: float = 30.0) -> Iterator[float]:
    """Waits until all viewports show the last sample of what is there now."""
    pictures()
    yield 0.3
    until = time.monotonic() + seconds
    while not pictures() or not all(drawn.is_newest and drawn.samples >= drawn.wanted for drawn in pictures()):
        assert time.monotonic() < until, f"no viewport shows its last sample: {pictures()}"
        yield 0.1
    yield 0.1


def point_at(kind: str) -> None:
    """Moves the mouse over the middle of the area of a kind."""
    x, y, width, height = box(area(kind))
    subprocess.check_call(["xdotool", "mousemove", str(x + width // 2), str(y + height // 2)])
    time.sleep(0.1)


def press(kind: str, *keys: str) -> None:
    """Presses keys, one after the other, over the area of a kind."""
    point_at(kind)
    subprocess.check_call(["xdotool", "key", *keys])


def scroll(kind: str, clicks: int) -> None:
    """Turns the mouse's wheel, to see what is farther down in the area of a kind."""
    point_at(kind)
    subprocess.check_call(["xdotool", "click", "--repeat", str(clicks), "--delay", "20", "5"])


def write(text: str) -> None:
    """Types, where the keyboard's focus is."""
    subprocess.check_call(["xdotool", "type", "--delay", "60", text])


def run(steps: Callable[[], Iterator[float]], name: str) -> None:
    """Lets Blender go through the steps as soon as its window is up, and end with an exit code."""
    plan = steps()

    def drive() -> float | None:
        try:
            return next(plan)
        except StopIteration:
            print(f"{name} fine", flush=True)
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(4)

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(drive, first_interval=max(1.0, 3.0 - time.process_time()), persistent=True)
