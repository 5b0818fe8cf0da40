"""An animation holds no more memory at its end than at its start: what a frame needs is freed with the frame."""

import gc

import bentlight_native
import bpy
import numpy as np
import pytest

from tests.engine import stage
from tests.native.heap import allocated_bytes

FRAMES, SETTLED = 12, 3  # Blender's caches fill during the first frames
GRID = 200  # squares along a side


def waving_grid() -> int:
    """A square that another mesh replaces in every frame; returns the bytes of one such mesh in the core."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=GRID, y_subdivisions=GRID, size=8, location=(0, 0, -4))
    bpy.context.object.modifiers.new("Wave", "WAVE")
    triangles, vertices = 2 * GRID**2, (GRID + 1) ** 2
    return triangles * 3 * 4 + vertices * 3 * 4  # indices and positions alone


def living_scenes() -> set[int]:
    gc.collect()
    return {id(thing) for thing in gc.get_objects() if isinstance(thing, bentlight_native.Scene)}


@pytest.fixture
def film(tmp_path) -> bpy.types.Scene:
    """A tiny film: camera, mass, spin and mesh all move."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 48, 27
    scene.bentlight.samples = 2
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.filepath = str(tmp_path / "frame_")
    stage.set_world((0.5, 0.6, 0.7))
    camera = stage.add_camera((0, 0, 6))
    bpy.ops.bentlight.black_hole_add(mass=0.1, spin=0.1)
    hole = bpy.context.object
    for frame, share in ((1, 0.0), (FRAMES, 1.0)):
        hole.bentlight.mass, hole.bentlight.spin = 0.1 + 0.3 * share, -0.5 + 1.4 * share
        hole.bentlight.keyframe_insert("mass", frame=frame)
        hole.bentlight.keyframe_insert("spin", frame=frame)
        camera.location.x = share
        camera.keyframe_insert("location", frame=frame)
    return scene


def test_a_mesh_that_is_kept_is_counted():
    """What the test below relies on: the heap's count sees the core's meshes, and sees them go."""
    line = np.arange(GRID + 1, dtype=np.float32)
    x, y = np.meshgrid(line, line)
    first = (np.arange(GRID)[:, None] * (GRID + 1) + np.arange(GRID)).ravel()
    triangles = np.concatenate([first[:, None] + [0, 1, GRID + 2], first[:, None] + [0, GRID + 2, GRID + 1]])
    vertices, triangles = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), triangles.astype(np.uint32)
    before = allocated_bytes()
    kept = bentlight_native.Scene()
    kept.add_mesh(vertices, triangles)
    assert allocated_bytes() - before > vertices.nbytes + triangles.nbytes
    del kept
    assert abs(allocated_bytes() - before) < vertices.nbytes / 8


def test_an_animation_does_not_grow(film):
    """Nothing of the size of a frame's mesh, 1.4 MB, is kept from any frame: what is allocated grows by less than an
    eighth of it over all frames together."""
    mesh_bytes = waving_grid()
    before = living_scenes()  # other tests of this process may keep theirs
    sizes = []

    def measure(*_arguments) -> None:
        gc.collect()
        sizes.append(allocated_bytes())

    bpy.app.handlers.render_post.append(measure)
    try:
        with stage.counted_renders() as count:
            bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.render_post.remove(measure)
    assert len(count) == len(sizes) == FRAMES
    assert max(sizes[SETTLED:]) - min(sizes[SETTLED:]) < mesh_bytes / 8
    assert living_scenes() <= before
