"""A final render (F12, animation, background, material icons): from the depsgraph to Blender's render result."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from typing import TypeVar

import bentlight_native
import bpy
import numpy as np

from . import memory, passes
from .properties import check_range
from .report import RenderError, Reporter
from .session import FinishedTile, Session, StarLight, Tile, spiral_tiles
from .sync.camera import image_size, read_camera
from .sync.native import build_scene
from .sync.objects import read_scene
from .sync.scene_data import CameraData, SceneData
from .sync.spacetime import influence_radii

log = logging.getLogger(__name__)
T = TypeVar("T")

_POLL = 0.05  # seconds between looks at the user's wish to stop
_STATUS_INTERVAL = 0.5  # seconds between status lines
_TILE_SIZES = (64, 32, 16)
_TILES_PER_THREAD = 8  # at least, so that no thread idles long at the end
_TILE_PATHS = 1 << 20  # at most, about a second's work, so that the picture grows before the user's eyes
_FILTER_WIDTHS = 0.01, 30.0  # pixels, that the core takes; Blender lets users set any
_PREVIEW_SAMPLES, _PREVIEW_BOUNCES = 32, 4
# The whole support of a filter over Blender's filter size, as Cycles has it (intern/cycles/scene/film.cpp).
_FILTER_SUPPORT = {"BLACKMAN_HARRIS": 2.0, "GAUSSIAN": 3.0, "BOX": 1.0}


def render(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
    """Renders; whatever goes wrong becomes an error that fails the operator.

    Blender would swallow an exception and call the render finished.
    """
    reporter = Reporter(engine.report, quiet=engine.is_preview)  # a preview's scene is not the user's
    try:
        for view in _views(depsgraph.scene):
            _ViewRender(engine, depsgraph, reporter, view).run()
    except Exception as failure:
        expected = isinstance(failure, (RenderError, MemoryError, OSError))
        if not expected:
            log.exception("render failed")
        text = f"{failure}" if expected and str(failure) else f"{type(failure).__name__}: {failure}"
        reporter.error(f"Bentlight: {text}")
        engine.error_set(f"Bentlight: {text}")


def _views(scene: bpy.types.Scene) -> list[str]:
    """Names of the stereo views; one without a name if there are none."""
    if not scene.render.use_multiview:
        return [""]
    return [view.name for view in scene.render.views if view.use]


def _border(render: bpy.types.RenderSettings) -> tuple[int, int, int, int]:
    """x, y, width, height of the part of the image to render, in pixels, as Blender rounds it."""
    width, height = image_size(render)
    if not render.use_border:
        return 0, 0, width, height
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    return left, bottom, right - left, top - bottom


def render_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, is_preview: bool
) -> bentlight_native.RenderSettings:
    """What the user set, for the native renderer; a preview (a material's icon) is quick."""
    user, render = scene.bentlight, scene.render
    check_range(user, type(user).__annotations__)
    check_range(render, ["filter_size"])
    samples, bounces = view_layer.samples or user.samples, user.max_bounces
    if is_preview:
        samples, bounces = min(samples, _PREVIEW_SAMPLES), min(bounces, _PREVIEW_BOUNCES)
    width, height = image_size(render)
    return bentlight_native.RenderSettings(
        width=width,
        height=height,
        sample_count=samples,
        seed=user.seed,
        sampling_pattern=user.sampling_pattern,
        noise_threshold=user.adaptive_threshold if user.use_adaptive_sampling else 0.0,
        min_samples=user.adaptive_min_samples or _min_samples(user.adaptive_threshold),
        photon_ring_samples=user.photon_ring_samples,
        max_bounces=bounces,
        diffuse_bounces=bounces,
        glossy_bounces=bounces,
        transmission_bounces=bounces,
        transparent_bounces=user.transparent_bounces,
        tolerance=user.tolerance,
        filter=user.pixel_filter,
        filter_width=min(
            max(_FILTER_SUPPORT[user.pixel_filter] * render.filter_size, _FILTER_WIDTHS[0]), _FILTER_WIDTHS[1]
        ),
        sky_filter=user.sky_filter / math.sqrt(samples),
        film_transparent=render.film_transparent,
        clamp_direct=user.clamp_direct,
        clamp_indirect=user.clamp_indirect,
        blur_glossy=user.blur_glossy,
        caustics_reflective=user.caustics_reflective,
        caustics_refractive=user.caustics_refractive,
        integrator=user.integrator,
        light_sampling=user.light_sampling if user.integrator == "PATH" else "BOTH",
        portal_sampling=user.portal_sampling,
        light_threshold=user.light_threshold,
    )


def _min_samples(threshold: float) -> int:
    """Samples that it takes to tell a pixel's noise: as many as Cycles takes."""
    return max(4, math.ceil(16 / threshold**0.3))


class _ViewRender:
    """One view of one view layer of one frame."""

    def __init__(
        self, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, reporter: Reporter, view: str
    ) -> None:
        self._engine = engine
        self._depsgraph = depsgraph
        self._scene = depsgraph.scene_eval
        self._view_layer = depsgraph.view_layer_eval
        self._reporter = reporter
        self._view = view
        self._passes = passes.enabled(self._view_layer)
        self._border = _border(self._scene.render)
        self._next_status = 0.0

    def run(self) -> None:
        if self._view:
            self._engine.active_view_set(self._view)
        self._engine.update_stats("", "Reading the scene")
        self._add_passes()
        studio, should_stop = self._engine.is_preview, self._engine.test_break
        data = read_scene(self._depsgraph, self._read_camera(), self._reporter, studio, should_stop)
        native = self._build(data) if data else None
        if native is None or should_stop():
            self._write_nothing()
            return
        settings = self._possible(render_settings(self._scene, self._view_layer, self._engine.is_preview), native)
        stars = self._find_stars(data, native, settings)
        if should_stop():
            self._write_nothing()
            return
        self._render_tiles(native, settings, stars)

    def _add_passes(self) -> None:
        for item in self._passes:
            if not item.builtin:
                self._engine.add_pass(item.name, item.width, item.components, layer=self._view_layer.name)

    def _read_camera(self) -> CameraData:
        camera = self._engine.camera_override or self._scene.camera
        if camera is None:
            raise RenderError("No camera: the scene needs an active camera")
        camera = camera.evaluated_get(self._depsgraph)
        if camera.type != "CAMERA":
            raise RenderError(f"Camera '{camera.name}' is not a camera object")
        if camera.data.dof.use_dof:
            self._reporter.warn(f"Camera '{camera.name}': depth of field is not supported yet; everything is sharp")
        if self._scene.render.use_motion_blur:
            self._reporter.warn("Motion blur is not supported yet; everything stands still")
        return read_camera(
            camera,
            self._scene.render,
            np.array(self._engine.camera_model_matrix(camera)),
            self._engine.camera_shift_x(camera),
        )

    def _find_stars(
        self, data: SceneData, native: bentlight_native.Scene, settings: bentlight_native.RenderSettings
    ) -> StarLight | None:
        """Where the camera sees the world's stars; None if there are none, or the user gave up."""
        if data.stars is None:
            return None
        if not native.shows_stars():
            self._reporter.warn("An orthographic camera sees no single stars; there are none in this picture")
            return None
        for item, radius in zip(data.spacetimes, influence_radii(data.spacetimes), strict=True):
            if item.spin and radius != math.inf:
                self._reporter.warn(
                    f"Black hole '{item.name}' spins within a sphere of influence: no stars are seen in it"
                )

        def find(progress: bentlight_native.Progress) -> StarLight:
            images = native.find_stars(
                data.stars.directions,
                (settings.width, settings.height),
                margin=settings.filter_width / 2,
                tolerance=settings.tolerance,
                transparent_bounces=settings.transparent_bounces,
                threads=self._scene.render.threads,
                progress=progress,
            )
            return StarLight(images, images.light(data.stars.irradiance))

        return self._on_a_thread(find)

    def _build(self, data: SceneData) -> bentlight_native.Scene | None:
        """The native scene; None if the user gave up."""
        return self._on_a_thread(lambda progress: build_scene(data, progress))

    def _on_a_thread(self, work: Callable[[bentlight_native.Progress], T]) -> T | None:
        """What `work` returns, done on a thread of its own: who gives up need not wait for it. None if they did."""
        progress = bentlight_native.Progress()
        with ThreadPoolExecutor(1) as pool:
            doing = pool.submit(work, progress)
            while not wait([doing], _POLL).done:
                if self._engine.test_break():
                    progress.cancel()
        try:
            return doing.result()
        except bentlight_native.Cancelled:
            return None

    def _tiles(self, threads: int, samples: int) -> list[Tile]:
        largest = min(self._border[2] * self._border[3] / (threads * _TILES_PER_THREAD), _TILE_PATHS / samples)
        size = next((size for size in _TILE_SIZES if size * size <= largest), _TILE_SIZES[-1])
        return spiral_tiles(*self._border, size)

    def _render_tiles(
        self, native: bentlight_native.Scene, settings: bentlight_native.RenderSettings, stars: StarLight | None
    ) -> None:
        threads = self._scene.render.threads
        channels = [item.channel for item in self._passes]
        tiles = self._tiles(threads, settings.sample_count)
        limit = 0.0 if self._engine.is_preview else self._scene.bentlight.time_limit
        session = Session(native, settings, tiles, channels, threads, limit, stars)
        written = False
        for finished in session.finished(_POLL):
            if finished:
                self._write(finished)
                written = True
            if self._engine.test_break():
                session.cancel()
            self._show_progress(session)
        if not written:
            self._write_nothing()

    def _possible(
        self, settings: bentlight_native.RenderSettings, native: bentlight_native.Scene
    ) -> bentlight_native.RenderSettings:
        """The settings, but with light followed from the camera alone where the scene does not allow otherwise."""
        obstacle = native.bidirectional_obstacle() if settings.integrator == "BIDIRECTIONAL" else None
        if obstacle is None:
            return settings
        self._reporter.warn(f"Bidirectional is not possible, light is followed from the camera alone: {obstacle}")
        return replace(settings, integrator="PATH")

    def _write(self, finished: FinishedTile) -> None:
        """Shows a tile in the render view; Blender counts from the border's corner."""
        tile = finished.tile
        result = self._engine.begin_result(
            tile.x - self._border[0],
            tile.y - self._border[1],
            tile.width,
            tile.height,
            layer=self._view_layer.name,
            view=self._view,
        )
        if result is None:
            raise RenderError("Blender's render result does not have the expected size")
        try:
            for item, target in passes.result_passes(result.layers[0], self._passes, self._view):
                target.rect.foreach_set(finished.channels[item.channel].reshape(-1))
        finally:
            self._engine.end_result(result)

    def _write_nothing(self) -> None:
        """A render that was stopped before its first pixel: Blender crashes when it gets no result at all."""
        result = self._engine.begin_result(0, 0, 1, 1, layer=self._view_layer.name, view=self._view)
        if result is not None:
            self._engine.end_result(result)

    def _show_progress(self, session: Session) -> None:
        """Progress bar and status line, not more often than anyone can read; background renders print each line."""
        self._engine.update_progress(session.fraction)
        if time.monotonic() < self._next_status:
            return
        self._next_status = time.monotonic() + _STATUS_INTERVAL
        used, peak = memory.used_and_peak()
        self._engine.update_memory_stats(memory_used=used, memory_peak=peak)
        left = session.seconds_left
        remaining = "" if left is None else f"Remaining {_clock(left)} | "
        self._engine.update_stats(
            f"{self._view_layer.name} {self._view}".strip(),
            f"{remaining}Mem {used:.0f}M (Peak {peak:.0f}M) | {session.fraction:.0%}",
        )


def _clock(seconds: float) -> str:
    """As Cycles writes it: hours only if there are any, hundredths of seconds."""
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02}:{seconds:05.2f}" if hours else f"{minutes:02}:{seconds:05.2f}"
