"""The remains of a star that spins fast and feeds on another: a small, very hot, bluish disk, shifted as in nature.

A disk around ten suns is some ten million kelvin hot (Shakura & Sunyaev, Astronomy and Astrophysics 24, 337, 1973).
"""

import bpy

hole = bpy.context.object.bentlight
hole.kind = "BLACK_HOLE"
hole.spin = 0.9
disk = hole.disk
disk.enable = True
disk.inner_edge = "ISCO"
disk.outer_radius = 25.0
disk.softness = 0.5
disk.emission = "PAGE_THORNE"
disk.temperature = 1.0e7
disk.strength = 1.0
disk.opacity = 1.0
disk.doppler = 1.0
disk.gravitational = 1.0
disk.pattern = 0.5
disk.pattern_scale = 3.0
