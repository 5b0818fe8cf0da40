"""A black hole that spins, with a golden disk of one brightness all around, as films show it."""

import bpy

hole = bpy.context.object.bentlight
hole.kind = "BLACK_HOLE"
hole.spin = 0.6
disk = hole.disk
disk.enable = True
disk.inner_edge = "ISCO"
disk.outer_radius = 18.0
disk.softness = 0.6
disk.emission = "POWER_LAW"
disk.temperature = 4500.0
disk.exponent = 0.45
disk.strength = 3.0
disk.opacity = 0.95
disk.doppler = 0.0
disk.gravitational = 0.0
disk.pattern = 0.7
disk.pattern_scale = 2.0
