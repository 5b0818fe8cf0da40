"""One mouth of a wormhole; the other one is made if there is none."""

import bpy

hole = bpy.context.object.bentlight
hole.disk.enable = False
hole.kind = "WORMHOLE"
if hole.exit is None:
    bpy.ops.bentlight.exit_add()
