"""Run by the real Blender in its window, with the extension enabled and an example open: pictures for the guide.

`blender SCENE --python drive_pictures.py -- FOLDER` leaves guide_viewport.png and guide_overlay.png in FOLDER.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driving import area, run, shot


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
    shot("guide_overlay")
    scene.bentlight.overlay.rays = "OFF"
    space.overlay.show_overlays = False
    space.shading.type = "RENDERED"
    yield 30
    shot("guide_viewport")


run(steps, "pictures")
