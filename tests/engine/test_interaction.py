"""What the user sees of a render under way, and how fast it ends when they have seen enough."""

import functools
import gc
import re
import time
import weakref

import bentlight_native
import bpy
import numpy as np
import pytest

from blender_addon import final
from tests.engine import stage

PATIENCE = 0.3  # seconds from the wish to stop to its fulfilment


class Watched:
    """Blender's engine with someone looking on, who may press ESC."""

    def __init__(self, calls: list[tuple], wants_to_stop: list) -> None:
        self.calls, self.wants_to_stop = calls, wants_to_stop
        self.pressed = self.ended = None

    def render(self, render, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
        self.engine, self.blenders = engine, weakref.ref(engine)
        render(self, depsgraph)
        self.ended = time.monotonic()
        del self.engine  # which is Blender's to keep or to let go

    def __getattr__(self, name):
        value = getattr(self.engine, name)
        if name not in ("begin_result", "update_progress", "update_stats", "update_memory_stats"):
            return value

        def told(*args, **named):
            self.calls.append((name, time.monotonic(), args or tuple(named.values())))
            return value(*args, **named)

        return told

    def test_break(self) -> bool:
        if self.pressed is None and any(wants() for wants in self.wants_to_stop):
            self.pressed = time.monotonic()
        return self.pressed is not None

    def seen(self, name: str) -> list[tuple]:
        """The arguments of all calls of one kind."""
        return [arguments for what, _, arguments in self.calls if what == name]


@pytest.fixture
def watched(monkeypatch) -> Watched:
    """All renders are watched; append to `wants_to_stop` what makes the user press ESC."""
    onlooker = Watched([], [])
    monkeypatch.setattr(final, "render", functools.partial(onlooker.render, final.render))
    return onlooker


def long_render() -> None:
    """A white room to shine in without end, of more samples than anyone waits for."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 3))
    stage.set_world((1, 1, 1))
    stage.add_square(8.0)
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 0, 1))
    scene.bentlight.samples, scene.bentlight.use_adaptive_sampling = 1 << 20, False


def test_tiles_progress_remaining_time_and_memory_are_shown(watched, tmp_path):
    long_render()
    bpy.context.scene.bentlight.samples = 256
    stage.render(tmp_path)
    tiles = watched.seen("begin_result")
    assert len(tiles) > 4 and sum(width * height for _, _, width, height in tiles) == 64 * 48
    names = [name for name, _, _ in watched.calls]
    assert "update_progress" in names[names.index("begin_result") : -names[::-1].index("begin_result") - 1]
    fractions = [fraction for (fraction,) in watched.seen("update_progress")]
    assert fractions == sorted(fractions) and fractions[-1] == 1
    assert any(0 < fraction < 1 for fraction in fractions)
    status = [text for _, text in watched.seen("update_stats")]
    assert any(re.fullmatch(r"Remaining \d\d:\d\d\.\d\d \| Mem \d+M \(Peak \d+M\) \| \d+%", text) for text in status)
    assert all(0 < used <= peak for used, peak in watched.seen("update_memory_stats"))


def test_escape_stops_at_once_and_keeps_what_is_done(watched, tmp_path):
    long_render()
    start = time.monotonic()
    watched.wants_to_stop.append(lambda: time.monotonic() > start + 1.0)
    picture = stage.render(tmp_path)["Combined"]
    assert watched.ended - watched.pressed < PATIENCE
    assert watched.seen("begin_result")
    assert (picture[..., 3] > 0).any() and np.isfinite(picture).all()
    assert watched.seen("update_progress")[-1][0] < 1


def big_mesh(size: int) -> bpy.types.Object:
    """A bumpy square of size x size quads."""
    line = np.linspace(-1, 1, size + 1)
    x, y = np.meshgrid(line, line)
    corners = np.stack([x, y, 0.01 * np.sin(99 * x) * np.sin(77 * y)], axis=-1).reshape(-1, 3)
    first = (np.arange(size)[:, None] * (size + 1) + np.arange(size)).ravel()
    quads = first[:, None] + [0, 1, size + 2, size + 1]
    mesh = bpy.data.meshes.new("bumps")
    mesh.vertices.add(len(corners))
    mesh.vertices.foreach_set("co", corners.ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4))
    mesh.update()
    obj = bpy.data.objects.new("bumps", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def test_escape_stops_the_reading_of_the_scene(watched, monkeypatch, tmp_path):
    long_render()
    asked, built = [], []
    watched.wants_to_stop.append(lambda: asked.append(1) or len(asked) == 2)
    monkeypatch.setattr(final, "build_scene", lambda *_: built.append(1))
    assert (stage.render(tmp_path)["Combined"] == 0).all()
    assert len(asked) == 2 and not built
    assert watched.seen("begin_result") == [(0, 0, 1, 1)]


def test_escape_stops_the_building_of_the_scene(watched, monkeypatch, tmp_path):
    """Two million triangles take a second; what is half built is given up."""
    long_render()
    big_mesh(1000)
    begun, results = [], []
    build_scene = final.build_scene

    def build(*arguments):
        begun.append(1)
        results.append(build_scene(*arguments))
        return results[0]

    monkeypatch.setattr(final, "build_scene", build)
    watched.wants_to_stop.append(lambda: bool(begun))
    assert (stage.render(tmp_path)["Combined"] == 0).all()
    assert watched.pressed and not results
    assert watched.seen("begin_result") == [(0, 0, 1, 1)]


@pytest.fixture
def uncollected(monkeypatch):
    """Nothing waits for Python's cycle collector, which would hide what is not let go."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def living_scenes(but: list[bentlight_native.Scene] | None = None) -> list[bentlight_native.Scene]:
    """Native scenes that are there, but those of earlier tests."""
    others = set(map(id, but or []))
    return [each for each in gc.get_objects() if isinstance(each, bentlight_native.Scene) and id(each) not in others]


def when_called(monkeypatch, name: str, number: int = 1, ends=lambda *_: True):
    """Whether one of the steps of a render has begun, for so many times; it goes on when it `ends`."""
    calls, step = [], getattr(final, name)

    def begun(*arguments, **options):
        calls.append(1)
        while not ends(*arguments):
            time.sleep(0.01)
        return step(*arguments, **options)

    monkeypatch.setattr(final, name, begun)
    return lambda: len(calls) >= number


def cancelled_in(step: str, watched: Watched, monkeypatch) -> None:
    """A scene in which the user presses ESC in the midst of a step of the render."""
    long_render()
    scene = bpy.context.scene
    if step == "stars":
        scene.world.bentlight.stars, scene.world.bentlight.star_count = "PROCEDURAL", 20_000
        scene.render.resolution_x = scene.render.resolution_y = 256
        watched.wants_to_stop.append(when_called(monkeypatch, "find_stars"))
    elif step == "building":
        big_mesh(100)
        watched.wants_to_stop.append(when_called(monkeypatch, "build_scene", ends=lambda _, done: done.cancelled))
    elif step == "another moment":
        scene.render.use_motion_blur, scene.bentlight.motion_slices, scene.bentlight.samples = True, 4, 64
        hole = bpy.data.objects["Black Hole"].bentlight
        for frame, mass in ((0, 0.1), (3, 0.2)):
            hole.mass = mass
            hole.keyframe_insert("mass", frame=frame)
        watched.wants_to_stop.append(when_called(monkeypatch, "update_scene", 2))
    else:
        watched.wants_to_stop.append(lambda: len(watched.seen("update_progress")) % 8 == 7)


STEPS = ["building", "stars", "tiles", "another moment"]


@pytest.mark.parametrize("step", STEPS)
def test_escape_lets_the_scene_go_at_once(step, watched, monkeypatch, tmp_path, uncollected):
    """With the end of the render, the engine as well: neither waits for the cycle collector."""
    cancelled_in(step, watched, monkeypatch)
    earlier = living_scenes()
    stage.render(tmp_path)
    assert watched.pressed is not None
    assert watched.blenders() is None
    assert not living_scenes(but=earlier)


@pytest.mark.parametrize("step", STEPS)
def test_escape_with_persistent_data_keeps_one_scene_as_any_render(step, watched, monkeypatch, tmp_path, uncollected):
    """What a cancelled render has is kept for the next, and goes when Persistent Data is switched off."""
    render = bpy.context.scene.render
    render.use_persistent_data = True
    cancelled_in(step, watched, monkeypatch)
    earlier = living_scenes()
    for _ in range(2):
        watched.pressed = None
        stage.render(tmp_path)
        assert watched.pressed is not None
        assert len(living_scenes(but=earlier)) == (step != "building")  # a half-built one is of no use
        assert watched.blenders() is not None
    render.use_persistent_data = False
    watched.pressed = None
    stage.render(tmp_path)
    assert watched.blenders() is None
    assert not living_scenes(but=earlier)
