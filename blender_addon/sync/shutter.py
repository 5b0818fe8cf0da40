"""The time that the shutter is open, as Cycles has it."""

from __future__ import annotations

import bpy
import numpy as np

_BEFORE = {"START": 0.0, "CENTER": 0.5, "END": 1.0}  # part of the shutter's time that lies before the frame
_CURVE_STEPS = 256  # of its table


def is_open(scene: bpy.types.Scene) -> bool:
    """Whether anything may move within a picture."""
    return scene.render.use_motion_blur and scene.render.motion_blur_shutter > 0


class Shutter:
    """The shutter of a scene in the frame that it is in."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        render = scene.render
        self._length = render.motion_blur_shutter
        self._start = scene.frame_current + scene.frame_subframe - self._length * _BEFORE[render.motion_blur_position]
        curve = render.motion_blur_shutter_curve
        curve.initialize()
        self._parts = np.linspace(0.0, 1.0, _CURVE_STEPS)
        opening = np.abs([curve.evaluate(curve.curves[0], part) for part in self._parts])
        passed = np.concatenate([[0.0], np.cumsum(opening[1:] + opening[:-1])])
        self._passed = passed / passed[-1] if passed[-1] > 0 else self._parts

    def frame(self, part: float) -> float:
        """The frame, with a fraction, after a part in [0, 1] of the shutter's time."""
        return self._start + self._length * part

    def frame_of_light(self, light: float) -> float:
        """The frame by when a part in [0, 1] of all light has come in, by the shutter's curve."""
        return self.frame(float(np.interp(light, self._passed, self._parts)))
