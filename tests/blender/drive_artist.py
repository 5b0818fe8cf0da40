"""Run by the real Blender in its window, with no extension: what artists do, from installing the zip to removing it.

`blender --python drive_artist.py -- FOLDER ZIP LENSES.blend` leaves screenshots in FOLDER. Menus and keys are
those of users. LENSES.blend is a scene that some Blender has set up for Cycles.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import traces
from driving import F3, F12, OUT, area, box, press, read, run, shot, write

ZIP, LENSES = sys.argv[sys.argv.index("--") + 2 :]
MODULE = "bl_ext.user_default.bentlight"


def hole() -> bpy.types.Object:
    """Looked up each time: files are loaded in between."""
    return bpy.context.scene.objects["Black Hole"]


def lenses() -> set[str]:
    return {obj.name for obj in bpy.context.scene.objects if obj.type == "MESH" and "Lens" in obj.name}


def is_rendering() -> bool:
    return bpy.app.is_job_running("RENDER")


def steps() -> Iterator[float]:
    bpy.context.preferences.view.render_display_type = "AREA"
    bpy.ops.wm.save_userpref()
    before, files = traces.in_blender(), traces.files()
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    yield 1
    assert traces.in_blender() != before, "traces are found where there are some"
    yield from add_from_the_menu()
    bpy.ops.bentlight.spacetime_preset_add(name="Mine")
    yield from render_and_wait()
    yield from render_and_stop()
    yield from set_up_cycles()
    yield from save_and_reload()
    yield from open_lenses()
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield 1
    assert not (left := traces.in_blender() - before), f"disabled, and yet there is {sorted(left)}"
    bpy.ops.preferences.addon_enable(module=MODULE)
    yield 1
    index = next(i for i, repo in enumerate(bpy.context.preferences.extensions.repos) if repo.module == "user_default")
    bpy.ops.extensions.package_uninstall(repo_index=index, pkg_id="bentlight")
    yield 1
    assert not (left := traces.in_blender() - before), f"removed, and yet there is {sorted(left)}"
    bpy.ops.wm.save_userpref()
    left = {name.removeprefix("scripts/presets/bentlight") for name in traces.files() - files}
    assert left == {"", "/spacetime/Mine.py"}, f"not the user's preset alone: {sorted(left)}"
    yield from open_without()


def add_from_the_menu() -> Iterator[float]:
    bpy.context.scene.render.engine = "BENTLIGHT"
    press("VIEW_3D", "shift+a")
    yield 1
    shot("artist_add_menu")
    write("Black Hole")
    yield 1
    press("VIEW_3D", "Return")
    yield 1
    assert hole().bentlight.kind == "BLACK_HOLE"
    assert bpy.context.object == hole()
    hole().location, hole().bentlight.mass = (0.5, -2, 1), 0.2
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.5, 0.8, 1)
    area("VIEW_3D").spaces[0].shading.type = "RENDERED"
    area("VIEW_3D").spaces[0].region_3d.view_perspective = "CAMERA"
    yield 3
    shot("artist_rendered_viewport")
    area("VIEW_3D").spaces[0].shading.type = "SOLID"
    yield 0.5


def render_and_wait() -> Iterator[float]:
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    scene.bentlight.samples = 8
    press("VIEW_3D", F12)
    shots, until = [], time.monotonic() + 100
    while not is_rendering():
        assert time.monotonic() < until, "F12 does not render"
        yield 0.05
    while is_rendering():
        assert time.monotonic() < until, "rendering takes too long"
        if area("IMAGE_EDITOR"):
            shots.append(shot(f"artist_f12_{len(shots):02}"))
        yield 0.3
    yield 1
    place = box(area("IMAGE_EDITOR"))
    done = middle(shot("artist_f12_done"), place)
    parts = [float((abs(middle(path, place) - done) < 0.02).mean()) for path in shots]
    for path in shots[: -len(shots) // 2] + shots[-len(shots) // 2 + 1 :]:
        path.unlink()  # one of them shows how it grows
    print("part of the picture that is there:", [round(part, 2) for part in parts], flush=True)
    grown = [part for part in parts if parts[0] + 0.05 < part < 0.95]
    assert len(set(grown)) >= 2, f"no tiles appear before the end: {parts}"


def middle(path: Path, place: tuple[int, int, int, int]) -> np.ndarray:
    """The brightness of the middle of an area, (height, width), on a screenshot."""
    x, y, width, height = place
    x, y, width, height = x + width // 4, y + height // 4, width // 2, height // 2
    return read(path)[::-1].mean(axis=2)[y : y + height, x : x + width]


def render_and_stop() -> Iterator[float]:
    press("IMAGE_EDITOR", "Escape")
    yield 1
    assert area("VIEW_3D"), "back to the scene"
    bpy.context.scene.bentlight.samples = 4096
    press("VIEW_3D", F12)
    yield 3
    assert is_rendering()
    press("IMAGE_EDITOR", "Escape")
    start = time.monotonic()
    while is_rendering():
        assert time.monotonic() < start + 5, "ESC does not stop the render"
        yield 0.05
    print(f"stopped after {time.monotonic() - start:.2f} s", flush=True)
    yield 0.5
    shot("artist_escape")
    press("IMAGE_EDITOR", "Escape")
    yield 1
    assert area("VIEW_3D")


def set_up_cycles() -> Iterator[float]:
    bpy.context.scene.render.engine = "CYCLES"
    properties = area("PROPERTIES").spaces[0]
    properties.context = "RENDER"
    press("VIEW_3D", F3)
    yield 1
    write("in Cycles")
    yield 1
    shot("artist_search")
    press("VIEW_3D", "Return")
    yield 2
    shot("artist_cycles")
    has_osl = __import__("_cycles").with_osl  # Debian's Blender has not: there nothing may change
    assert bool(bpy.context.scene.bentlight.cycles_before) == has_osl
    assert bool(lenses()) == has_osl
    press("PROPERTIES", "Escape")  # closes the message
    yield 0.5


def save_and_reload() -> Iterator[float]:
    bpy.context.scene.bentlight.samples = 77
    hole().bentlight.spin = 0.5
    yield 0.5
    names = {obj.name for obj in bpy.context.scene.objects}
    path = str(OUT / "artist.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile()
    yield 1
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 2
    assert {obj.name for obj in bpy.context.scene.objects} == names
    assert bpy.context.scene.bentlight.samples == 77
    assert (hole().bentlight.kind, round(hole().bentlight.spin, 6)) == ("BLACK_HOLE", 0.5)
    shot("artist_reloaded")


def open_lenses() -> Iterator[float]:
    """A file with lenses, which another Blender has made, is saved and opened again; then they are taken back."""
    path = str(OUT / "lenses.blend")
    for source in (LENSES, path):
        bpy.ops.wm.open_mainfile(filepath=source)
        yield 2
        assert bpy.context.scene.render.engine == "CYCLES"
        assert lenses(), "the lenses are there"
        assert bpy.context.scene.bentlight.cycles_before
        bpy.ops.wm.save_as_mainfile(filepath=path)
    area("PROPERTIES").spaces[0].context = "RENDER"
    yield 1
    shot("artist_lenses")
    press("VIEW_3D", F3)
    yield 1
    write("Remove from Cycles")
    yield 1
    press("VIEW_3D", "Return")
    yield 1
    assert not lenses() and not bpy.context.scene.bentlight.cycles_before
    Path(path).unlink()


def open_without() -> Iterator[float]:
    path = OUT / "artist.blend"
    bpy.ops.wm.open_mainfile(filepath=str(path))
    yield 2
    assert "Black Hole" in bpy.context.scene.objects
    shot("artist_removed")
    path.unlink()


run(steps, "artist")
