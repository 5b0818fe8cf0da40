"""The viewport in Rendered shading: what is on the screen, what of it has changed, and drawing it."""

from __future__ import annotations

import contextlib
import weakref
from dataclasses import replace
from typing import NamedTuple

import bentlight_native
import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from .final import render_settings
from .progressive import Preview, Progressive, Wish
from .report import RenderError, Reporter, told
from .sync.camera import View, camera_frame, framed, read_camera, read_free_view
from .sync.change import same, update_scene
from .sync.memory import Memory
from .sync.native import build_scene
from .sync.objects import read_scene
from .sync.scene_data import CameraData, SceneData

_ENDLESS = 1 << 24  # samples
_PIXEL_SIZES = {"AUTO": 1, "1": 1, "2": 2, "4": 4, "8": 8}


class _Frame(NamedTuple):
    """Where in the region the picture is, in pixels, and the camera that takes it."""

    x: int
    y: int
    camera: CameraData


class Viewport:
    """One viewport with the Bentlight engine; called from Blender's main thread only.

    The engine is handed over in each call, and otherwise held weakly: Blender ends a viewport by dropping it.
    """

    def __init__(self, engine: bpy.types.RenderEngine, threads: int) -> None:
        held = weakref.ref(engine)

        def redraw() -> None:
            alive = held()
            if alive is not None:
                with contextlib.suppress(ReferenceError):  # dropped just now
                    alive.tag_redraw()

        self._progressive = Progressive(threads, redraw)
        self._native: bentlight_native.Scene | None = None  # as the next, touched by the progressive's thread alone
        self._data: SceneData | None = None  # what the native scene shows
        self._wanted: SceneData | None = None  # what it is to show
        self._memory = Memory()
        self._is_stale = True  # the scene has changed since it was read
        self._shown: tuple | None = None  # frame, settings and local view of the last wish
        self._preview: Preview | None = None  # what the texture holds
        self._texture: gpu.types.GPUTexture | None = None

    def close(self) -> None:
        """Stops all work, and lets go of the last picture, whose wish knows this viewport."""
        self._progressive.close()
        self._preview = self._texture = None

    def update(self, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
        """Something in the scene has changed."""
        self._memory.forget(depsgraph.updates)
        self._is_stale = True
        engine.tag_redraw()

    def draw(self, engine: bpy.types.RenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Wishes for a picture of what is there now, and shows the newest that there is."""
        try:
            frame = _frame(context, depsgraph)
            self._wish(engine, context, depsgraph, frame)
        except RenderError as error:
            engine.update_stats("Bentlight", str(error))
            return
        self._show(engine, depsgraph.scene_eval, frame)

    def _wish(
        self, engine: bpy.types.RenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph, frame: _Frame
    ) -> None:
        settings, camera = _settings(depsgraph, frame.camera), frame.camera
        pixel_size = _PIXEL_SIZES[depsgraph.scene_eval.render.preview_pixel_size]
        space = context.space_data
        shown = (frame, settings, pixel_size, space.local_view is not None)
        is_moved = self._shown is None or not same(shown, self._shown)
        if not self._is_stale and not is_moved:
            return
        if self._is_stale or self._shown is None or self._shown[-1] != shown[-1]:
            self._wanted = read_scene(
                depsgraph,
                camera,
                Reporter(engine.report, quiet=True),
                memory=self._memory,
                is_shown=lambda obj: obj.visible_in_viewport_get(space),
            )
            self._is_stale = False
        else:
            self._wanted = replace(self._wanted, camera=camera)
        data = self._wanted
        self._progressive.render(Wish(lambda: self._build(data), settings, pixel_size, data.stars))
        self._shown = shown

    def _build(self, data: SceneData) -> bentlight_native.Scene:
        native, old = self._native, self._data
        self._native = None  # of no use if this fails
        self._data = data
        self._native = update_scene(native, old, data) if native else build_scene(data)
        return self._native

    def _show(self, engine: bpy.types.RenderEngine, scene: bpy.types.Scene, frame: _Frame) -> None:
        preview, failure = self._progressive.preview, self._progressive.failure
        if failure:
            engine.update_stats("Bentlight", str(failure))
        if preview is None or failure:
            return
        if preview is not self._preview:
            self._preview, self._texture = preview, _texture(preview.pixels)
        engine.update_stats("", told("Sample {}/{}", preview.samples, preview.wish.settings.sample_count))
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (frame.x, frame.y), frame.camera.width, frame.camera.height)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _settings(depsgraph: bpy.types.Depsgraph, camera: CameraData) -> bentlight_native.RenderSettings:
    """As for a final render, but for size and samples, and always from the camera: light from lamps would be the same
    for all of a picture's rounds only at its end."""
    settings = render_settings(depsgraph.scene_eval, depsgraph.view_layer_eval, is_preview=False)
    samples = depsgraph.scene_eval.bentlight.preview_samples or _ENDLESS
    return replace(settings, width=camera.width, height=camera.height, sample_count=samples, integrator="PATH")


def _frame(context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> _Frame:
    """The picture that a viewport wants: all of its region, or the border that the user has drawn in it."""
    region, space, data = context.region, context.space_data, context.region_data
    view = View(
        (region.width, region.height),
        np.array(data.view_matrix, np.float64),
        np.array(data.window_matrix, np.float64),
        (space.clip_start, space.clip_end),
    )
    render, border = depsgraph.scene_eval.render, None
    camera = space.camera if space.use_local_camera else depsgraph.scene_eval.camera
    if data.view_perspective == "CAMERA" and camera is not None and camera.type == "CAMERA":
        camera = camera.evaluated_get(depsgraph)
        left, right, bottom, top = camera_frame(camera, depsgraph.scene_eval, view)
        taken = read_camera(camera, render, np.array(camera.matrix_world), camera.data.shift_x)
        part = (
            -left / (right - left),
            (1 - left) / (right - left),
            -bottom / (top - bottom),
            (1 - bottom) / (top - bottom),
        )
        whole = framed(taken, view.size, part)
        if render.use_border:
            x, y = right - left, top - bottom
            border = (left + render.border_min_x * x, left + render.border_max_x * x,
                      bottom + render.border_min_y * y, bottom + render.border_max_y * y)  # fmt: skip
    else:
        whole = read_free_view(view)
        if space.use_render_border:
            border = (space.render_border_min_x, space.render_border_max_x,
                      space.render_border_min_y, space.render_border_max_y)  # fmt: skip
    return _cut(whole, border or (0.0, 1.0, 0.0, 1.0))


def _cut(whole: CameraData, border: tuple[float, float, float, float]) -> _Frame:
    """The whole pixels of a viewport that a border, in [0, 1] of it, contains; at least one."""
    width, height = whole.width, whole.height
    left, bottom = (
        int(np.clip(value * size, 0, size - 1)) for value, size in zip(border[::2], (width, height), strict=True)
    )
    right, top = (
        int(np.clip(value * size, 1, size)) for value, size in zip(border[1::2], (width, height), strict=True)
    )
    right, top = max(right, left + 1), max(top, bottom + 1)
    part = (left / width, right / width, bottom / height, top / height)
    return _Frame(left, bottom, framed(whole, (right - left, top - bottom), part))


def _texture(pixels: np.ndarray) -> gpu.types.GPUTexture:
    height, width = pixels.shape[:2]
    data = gpu.types.Buffer("FLOAT", pixels.size, np.ascontiguousarray(pixels).reshape(-1))
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
