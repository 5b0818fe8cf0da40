"""The library of room_wormhole.py at night: all of its light falls through the wormhole, from one bulb in the garden.

The bulb is as small as bulbs are, and no ray of the library that is scattered by chance finds it. Aimed ones do: the
sharp shadows of the shelves on the walls point away from the mouth, and around its edge the light comes twice, by
either side of the throat.
"""

import bpy
import common
import numpy as np
import objects
import room_wormhole

BULB_RADIUS = 0.05


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = room_wormhole.build()
    for name in ("Left lamp", "Right lamp"):
        bpy.data.objects.remove(bpy.data.objects[name])
    scene.world = None
    bulb = bpy.data.lights.new("Bulb", "POINT")
    bulb.energy, bulb.shadow_soft_size, bulb.color = 2000, BULB_RADIUS, (1.0, 0.86, 0.66)
    objects.place(bpy.data.objects.new("Bulb", bulb), location=tuple(room_wormhole.GARDEN + np.array((1.2, -1.4, 3.4))))
    return scene


if __name__ == "__main__":
    common.main(build, "wormhole_lamp.png")
