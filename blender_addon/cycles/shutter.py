"""The shutter's time, as Cycles has it: the frame is shown as it is in the middle of each slice, one by one."""

from __future__ import annotations

import math
from collections.abc import Iterator

import bpy

_BEFORE = {"START": 0.0, "CENTER": 0.5, "END": 1.0}  # part of the shutter's time that lies before the frame


def is_open(scene: bpy.types.Scene) -> bool:
    """Whether anything may move within a picture."""
    return scene.render.use_motion_blur and scene.render.motion_blur_shutter > 0


def moments(scene: bpy.types.Scene) -> Iterator[int]:
    """The numbers of all slices, with the scene in that slice's middle; afterwards it is in its frame again.

    A shutter that is never open for long has one slice, the frame as it is."""
    if not is_open(scene):
        yield 0
        return
    render, count = scene.render, scene.bentlight.relay_slices
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        for number in range(count):
            part = (number + 0.5) / count - _BEFORE[render.motion_blur_position]
            time = frame + subframe + render.motion_blur_shutter * part
            scene.frame_set(math.floor(time), subframe=time - math.floor(time))
            yield number
    finally:
        scene.frame_set(frame, subframe=subframe)
