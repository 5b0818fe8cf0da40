"""A viewport that stays open while its scene is edited again and again: nothing is left of what was."""

import gc

import bentlight_native
import bpy
import numpy as np
import pytest

from blender_addon import memory
from blender_addon.sync.scene_data import SceneData
from tests.engine import stage
from tests.engine.windowless import Windowless
from tests.native.heap import allocated_bytes

EDITS, SETTLED = 1000, 300  # Blender's caches, and the allocator's, fill at first
RESIDENT_GROWTH, HEAP_GROWTH = 4.0, 1.0  # MiB after the first ones, the former with what allocators keep for later


@pytest.fixture
def viewport():
    shown = Windowless()
    yield shown
    shown.close()


@pytest.fixture
def scene() -> bpy.types.Scene:
    """Some of everything that edits touch, in a picture of a few pixels."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.bentlight.preview_samples = 12, 9, 1
    stage.add_camera((0, 0, 8))
    stage.set_world((0.1, 0.2, 0.3))
    stage.add_square(4.0, (0, 0, -1), stage.emission((0.5, 0.4, 0.3)), "Floor")
    bpy.ops.mesh.primitive_uv_sphere_add(location=(-1.5, 0, 0), segments=24, ring_count=16)
    stage.add_light("POINT", (0, 3, 3), energy=500, shadow_soft_size=0.0)
    bpy.ops.bentlight.black_hole_add(mass=0.1, location=(0, 1, 1))
    return scene


def hole() -> bpy.types.Object:
    """Looked up each time, as all others: undoing makes objects anew."""
    return next(obj for obj in bpy.data.objects if obj.bentlight.kind == "BLACK_HOLE")


def move(rng) -> None:
    bpy.data.objects["Sphere"].location = rng.uniform(-2, 2, 3)


def sculpt(rng) -> None:
    mesh = bpy.data.objects["Sphere"].data
    places = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", places)
    places = places.reshape(-1, 3)
    places *= np.float32(rng.uniform(0.9, 1.1)) / np.linalg.norm(places, axis=1, keepdims=True)
    mesh.vertices.foreach_set("co", places.reshape(-1))
    mesh.update()


def shade(rng) -> None:
    emission = next(n for n in bpy.data.materials["Emission"].node_tree.nodes if n.type == "EMISSION")
    emission.inputs["Strength"].default_value = rng.uniform(0.1, 2)


def weigh(rng) -> None:
    hole().bentlight.mass = rng.uniform(0.05, 0.2)
    hole().update_tag()


def spin(rng) -> None:
    hole().bentlight.spin = rng.uniform(0.0, 0.9)
    hole().update_tag()


def shine(rng) -> None:
    bpy.data.lights["Point"].energy = rng.uniform(100, 900)


def look(rng) -> None:
    bpy.context.scene.camera.location = (*rng.uniform(-1, 1, 2), 8)


def add_or_delete(rng) -> None:
    """The same object comes and goes, with its mesh."""
    old = bpy.data.meshes.get("Fan")
    if old:
        bpy.data.objects.remove(bpy.data.objects["Fan"])
        bpy.data.meshes.remove(old)
    else:
        stage.add_mesh("Fan", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], rng.uniform(-2, 2, 3))


def undo(rng) -> None:
    """Takes a move back; all is new to a viewport then."""
    bpy.ops.ed.undo_push(message="before")
    move(rng)
    bpy.ops.ed.undo_push(message="moved")
    bpy.ops.ed.undo()


MADE = bentlight_native.Scene, SceneData  # for a viewport, one of each at a time
KINDS = (move, sculpt, shade, weigh, spin, shine, look, add_or_delete, undo)


def living(kind: type) -> int:
    return sum(isinstance(thing, kind) for thing in gc.get_objects())


def test_memory_does_not_grow_over_a_thousand_edits(scene, viewport):
    """Each is read, made in the native scene and rendered; at the end the picture is that of a new viewport."""
    rng, resident, heap = np.random.default_rng(5), [], []
    gc.collect()
    before = [living(kind) for kind in MADE]  # by other tests
    viewport.draw()
    viewport.wait()
    for number in range(EDITS):
        KINDS[number % len(KINDS)](rng)
        bpy.context.view_layer.update()
        viewport.draw()
        viewport.wait()
        resident.append(memory.used_and_peak()[0])
        heap.append(allocated_bytes() / 2**20)
    assert max(resident[SETTLED:]) < max(resident[:SETTLED]) + RESIDENT_GROWTH
    assert np.median(heap[-100:]) < np.median(heap[SETTLED - 100 : SETTLED]) + HEAP_GROWTH
    fresh, pictures = Windowless(), []
    look(rng)
    for shown in (viewport, fresh):
        shown.draw()
        pictures.append(shown.wait(lambda picture: picture.samples == 1).pixels)
    fresh.close()
    np.testing.assert_array_equal(*pictures)
    del fresh, shown
    gc.collect()
    assert all(living(kind) <= old + 1 for kind, old in zip(MADE, before, strict=True))
