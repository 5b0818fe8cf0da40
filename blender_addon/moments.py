"""The scene of a final render in each moment of the time that its shutter is open."""

from __future__ import annotations

import math
from collections.abc import Callable

import bentlight_native
import bpy

from .report import Reporter
from .sync.memory import Memory
from .sync.scene_data import SceneData
from .sync.shutter import Shutter, is_open
from .sync.slices import Slice, slices, within
from .sync.standing import standing, still_objects

Read = Callable[[Reporter, Memory], SceneData | None]


class Moments:
    """Moves Blender's scene and reads it. What was evaluated before a move is of no use after it.

    Every moment is read as a whole, but for meshes and images that have not changed. Objects whose motion blur is
    switched off stand as in the frame.

    number: of the frame. frame: the scene in the frame's own time, None before it was read. camera: the frame's,
    through which all moments are seen, whatever Blender's markers say. slices: the samples by moment, in the order in
    which they are taken; none if nothing may move. times: of all moments of the whole picture, in frames.
    """

    def __init__(
        self, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, read: Read, memory: Memory
    ) -> None:
        """read: the scene as it is now, None if the user gave up. memory: of what has not changed since it was read."""
        self._engine, self._depsgraph, self._read = engine, depsgraph, read
        self._memory = memory
        self._has_moved = False
        self.number, self._subframe = depsgraph.scene.frame_current, depsgraph.scene.frame_subframe
        self.frame: SceneData | None = None
        self.camera: bpy.types.Object | None = None
        self.slices: list[Slice] = []
        self.times: list[float] = []

    def begin(
        self, reporter: Reporter, whole: bentlight_native.RenderSettings, part: bentlight_native.RenderSettings
    ) -> SceneData | None:
        """The scene of the first moment of a part of the whole picture's samples; of the frame if nothing may move."""
        scene, view_layer = self._depsgraph.scene, self._depsgraph.view_layer
        camera = self._engine.camera_override or scene.camera
        self.camera = camera and camera.original
        self.frame = self._read(reporter, self._memory)
        if self.frame is None or self._engine.is_preview or not (is_open(scene) and view_layer.use_motion_blur):
            return self.frame
        self._shutter = Shutter(scene)
        every = slices(whole.sample_count, scene.bentlight.motion_slices, whole.seed)
        self.times = [self._shutter.frame_of_light(each.light) for each in every]
        self.slices = within(every, part.first_sample, part.sample_count)
        return self.move(0)

    def move(self, moment: int) -> SceneData | None:
        """The scene of another moment."""
        frame = self._shutter.frame_of_light(self.slices[moment].light)
        found = self._read_at(frame)
        still = still_objects(bpy.data.objects)
        if found is None or not any(still):
            return found
        return standing(found, self.frame, still, self.camera.name)

    def read_neighbors(self) -> list[SceneData] | None:
        """The scene a frame before and a frame after; None if the user gave up. Blender's scene moves back."""
        here, found = self.number + self._subframe, []
        try:
            for frame in (here - 1, here + 1):
                found.append(self._read_at(frame))
                if found[-1] is None:
                    return None
        finally:
            self.end()
        return found

    def _read_at(self, frame: float) -> SceneData | None:
        self._has_moved = True
        self._engine.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
        self._memory.forget(self._depsgraph.updates)
        return self._read(Reporter(lambda level, text: None), self._memory)

    def end(self) -> None:
        """Moves Blender's scene back to its frame. May be called again."""
        if self._has_moved:
            self._has_moved = False
            self._engine.frame_set(self.number, subframe=self._subframe)
            self._memory.forget(self._depsgraph.updates)
