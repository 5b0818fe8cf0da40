"""A small black hole without spin or disk, to be put among furniture: objects near it keep their shape."""

import bpy

hole = bpy.context.object.bentlight
hole.kind = "BLACK_HOLE"
hole.mass = 0.1
hole.spin = 0.0
hole.chart = "ISOTROPIC"
hole.disk.enable = False
