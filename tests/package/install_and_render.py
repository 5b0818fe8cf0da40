"""Run in a process of its own, with an empty user folder: installs the extension's zip as a user does, and renders.

`install_and_render.py ZIP OUTPUT.exr`; exit code 0 when the picture was made by the extension and its own native wheel,
and all that it wrote is where extensions may write: in their own folder of the user's, and in temporary ones. TMPDIR
must not contain either. Nobody may connect to anything, or start programs.
"""

import os
import sys
import tempfile
from importlib.machinery import PathFinder
from pathlib import Path

import bpy
import numpy as np
import OpenEXR

ARCHIVE, OUTPUT = map(Path, sys.argv[1:])
USER = Path(bpy.utils.resource_path("USER"))


class WithoutTheCheckout:
    """Finds bentlight_native where the extension system puts it, not in the virtual environment."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        if name != "bentlight_native":
            return None
        return PathFinder.find_spec(name, [folder for folder in sys.path if Path(folder).is_relative_to(USER)])


class Watch:
    """Collects what Python code does to files and to the world outside of the process (PEP 578)."""

    CHANGES = {"os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod"}
    OUTSIDE = ("socket.", "subprocess.", "os.system", "os.exec", "os.fork", "os.posix_spawn", "os.putenv", "urllib.")

    def __init__(self):
        self.changed, self.outside = set(), []
        sys.dont_write_bytecode = True  # that is Python's own doing
        sys.addaudithook(self.note)

    def note(self, event, arguments):
        if event == "open":
            path, mode, flags = arguments
            if isinstance(path, str | bytes) and (set(mode or "") & set("wax+") or flags & (os.O_WRONLY | os.O_RDWR)):
                self.changed.add(Path(os.fsdecode(path)).absolute())
        elif event in self.CHANGES:
            self.changed.update(
                Path(os.fsdecode(path)).absolute() for path in arguments[:2] if isinstance(path, str | bytes)
            )
        elif event.startswith(self.OUTSIDE):
            self.outside.append((event, arguments))


def render_passes():
    """Renders a cube behind a black hole; the channels of the multilayer file, by name."""
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 4, 0))
    bpy.ops.bentlight.black_hole_add(mass=0.2, spin=0.0, location=(0, 0, 0))
    bpy.ops.object.camera_add(location=(0, -8, 0), rotation=(1.5707963, 0, 0))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("World")
    scene.render.engine = "BENTLIGHT"
    scene.view_layers[0].bentlight.use_pass_fate = True  # proves who rendered
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    if hasattr(scene.render.image_settings, "media_type"):  # Blender 5.0 and up
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.filepath = str(OUTPUT)
    scene.bentlight.samples = 2
    bpy.ops.render.render(write_still=True)
    channels = {}
    with OpenEXR.File(str(OUTPUT), separate_channels=True) as file:
        for part in file.parts:
            channels |= {name: channel.pixels for name, channel in part.channels.items()}
    return channels


sys.meta_path.insert(0, WithoutTheCheckout)
bpy.ops.extensions.package_install_files(filepath=str(ARCHIVE), repo="user_default", enable_on_install=True)
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.preferences.addon_enable(module="bl_ext.user_default.bentlight")
watch = Watch()  # installing is Blender's own doing
passes = render_passes()
import bentlight_native  # noqa: E402  only now can it be the extension's own

assert Path(bentlight_native.__file__).is_relative_to(USER), bentlight_native.__file__
(fate,) = (pixels for name, pixels in passes.items() if "Bentlight Fate" in name)
assert fate.shape == (24, 32)
assert len(np.unique(fate)) > 1, "some rays hit the cube, some escape"

scene = bpy.context.scene
assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
made = [path for path in USER.rglob("*.exr") if path.parent.name == "tables"]
assert len(made) == 2 and "bentlight" in made[0].parts, made
scene.render.engine, scene.cycles.samples = "CYCLES", 2
scene.world.color = (1, 1, 1)
bpy.ops.render.render(write_still=True)
with OpenEXR.File(str(OUTPUT), separate_channels=True) as file:
    channels = {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}
(red,) = (pixels for name, pixels in channels.items() if name.endswith("Combined.R"))
assert red[12, 16] == 0 and red[0, 0] > 0, "the hole is black in Cycles too"

scene.render.engine = "CYCLES"
scene.cycles.shading_system = True
assert bpy.ops.bentlight.relay_setup() == {"FINISHED"}
bpy.ops.render.render(write_still=True)

own = Path(bpy.utils.extension_path_user("bl_ext.user_default.bentlight"))
allowed = (own, Path(tempfile.gettempdir()), Path(bpy.app.tempdir))
assert any(path.parent.name == "tables" and path.is_relative_to(own) for path in watch.changed), (
    "the watch sees nothing"
)
elsewhere = {path for path in watch.changed if not any(map(path.is_relative_to, allowed))}
assert not (elsewhere := elsewhere - set(own.parents)), elsewhere
assert not watch.outside, watch.outside
