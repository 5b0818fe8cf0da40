"""Run by the real Blender in its window, with the extension enabled and an example open: pictures for the guide.

`blender SCENE --python drive_pictures.py -- FOLDER` leaves guide_viewport.png and guide_overlay.png in FOLDER.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driving import area, run, scroll, shot

SAMPLES = 64  # a pixel: grain is hardly seen any more


def steps() -> Iterator[float]:
    scene = bpy.context.scene
    hole = next(obj for obj in scene.objects if obj.bentlight.kind != "NONE")
    for obj in scene.objects:
        obj.select_set(obj == hole)
    bpy.context.view_layer.objects.active = hole
    bpy.context.preferences.view.ui_scale = 0.8
    area("PROPERTIES").spaces[0].context = "OBJECT"
    space = area("VIEW_3D").spaces[0]
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 12
    space.shading.type = "SOLID"
    scene.bentlight.overlay.rays = "CAMERA"
    yield 2
    scroll("PROPERTIES", 40)  # to the panel Spacetime
    yield 2
    shot("guide_overlay")
    scene.bentlight.overlay.rays = "OFF"
    space.overlay.show_overlays = False
    scene.bentlight.preview_samples, scene.render.preview_pixel_size = SAMPLES, "2"
    space.shading.type = "RENDERED"
    samples = watch_samples()
    while not samples or samples[-1] < SAMPLES:
        yield 5
    yield 2
    shot("guide_viewport")


def watch_samples() -> list[int]:
    """Grows with each drawing of Rendered shading, by the samples a pixel that it has."""
    viewport = sys.modules["bl_ext.user_default.bentlight.viewport"].Viewport
    show, samples = viewport._show, []

    def watched(self: object, *arguments: object) -> None:
        show(self, *arguments)
        samples.append(self._preview.samples if self._preview else 0)

    viewport._show = watched
    return samples


run(steps, "pictures")
