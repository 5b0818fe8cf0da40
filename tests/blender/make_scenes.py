"""Run by the real Blender, with the extension enabled: writes the scenes that check_application.py renders.

`blender -b --python make_scenes.py -- FOLDER` writes good.blend (three frames, a cube moving behind a black hole) and
bad.blend (its camera is inside the horizon).
"""

import sys
from pathlib import Path

import bpy


def make_scene() -> bpy.types.Scene:
    """A cube that moves behind a black hole, seen by a camera, 64 x 48 pixels, multilayer EXR."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.bentlight")
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add(size=2, location=(-1, 4, 0))
    cube = bpy.context.object
    cube.keyframe_insert("location", frame=1)
    cube.location.x = 1
    cube.keyframe_insert("location", frame=3)
    bpy.ops.bentlight.black_hole_add(mass=0.2, spin=0.0, location=(0, 0, 0))
    bpy.ops.object.camera_add(location=(0, -8, 0), rotation=(1.5707963, 0, 0))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("World")
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.engine = "BENTLIGHT"
    scene.view_layers[0].bentlight.use_pass_fate = True  # proves who rendered
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    if hasattr(scene.render.image_settings, "media_type"):  # Blender 5.0 and up
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.bentlight.samples = 4
    return scene


def main() -> None:
    """Writes both files."""
    folder = Path(sys.argv[sys.argv.index("--") + 1])
    scene = make_scene()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "good.blend"))
    scene.camera.location = (0, 0, 0.01)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "bad.blend"))


main()
