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

from . import farm, memory, passes
from .moments import Moments
from .persistent import kept_by
from .properties import check_range
from .recording import Recording
from .report import RenderError, Reporter, told
from .session import FinishedTile, Session, StarLight, Tile, spiral_tiles
from .sync import labels, motion
from .sync.camera import image_size, read_camera
from .sync.change import update_scene
from .sync.cryptomatte import metadata
from .sync.fingerprint import fingerprint
from .sync.memory import Memory
from .sync.native import build_scene
from .sync.objects import read_scene
from .sync.scene_data import CameraData, SceneData
from .sync.spacetime import influence_radii
from .sync.star_images import draw_stars, find_stars

log = logging.getLogger(__name__)
T = TypeVar("T")
_Shown = tuple[bentlight_native.Scene, StarLight | None]

_POLL = 0.05  # seconds between looks at the user's wish to stop
_STATUS_INTERVAL = 0.5  # seconds between status lines
_TILE_SIZES = (64, 32, 16)
_TILES_PER_THREAD = 8  # at least, so that no thread idles long at the end
_TILE_PATHS = 1 << 20  # at most, about a second's work, so that the picture grows before the user's eyes
_FILTER_WIDTHS = 0.01, 30.0  # pixels, that the core takes; Blender lets users set any
_PREVIEW_SAMPLES, _PREVIEW_BOUNCES = 32, 4
_LOST_JOINS = 1e-3  # so many of the rays to lights may be missing without a word
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
        farm.fail(text)


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
    left, right = (_border_pixel(part, width) for part in (render.border_min_x, render.border_max_x))
    bottom, top = (_border_pixel(part, height) for part in (render.border_min_y, render.border_max_y))
    return left, bottom, right - left, top - bottom


def _border_pixel(part: float, size: int) -> int:
    """Blender multiplies in single precision, where a third of 48 is 16."""
    return int(np.float32(part) * np.float32(size))


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
        **passes.render_settings(scene, view_layer),
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
        self._reporter = reporter
        self._view = view
        self._passes = passes.enabled(self._view_layer)
        self._channels = [name for item in self._passes for name in item.channels]
        self._border = _border(self._scene.render)
        self._job = farm.Job() if engine.is_preview else farm.job()
        self._window = self._job.window_of(self._border)
        self._next_status = 0.0
        self._kept = kept_by(engine, self._scene)
        self._moments = Moments(
            engine, depsgraph, self._read, self._kept.memory(self._view_layer.name, depsgraph.updates)
        )
        self._around = ""  # fingerprint of the scene in the frames around, if they matter to a part or a checkpoint
        self._data: SceneData | None  # what the native scene shows
        self._native: bentlight_native.Scene | None
        self._native, self._data = self._kept.take(self._view_layer.name, view)

    @property
    def _scene(self) -> bpy.types.Scene:
        """As evaluated; Blender frees it, and the next, when it moves on to another moment."""
        return self._depsgraph.scene_eval

    @property
    def _view_layer(self) -> bpy.types.ViewLayer:
        return self._depsgraph.view_layer_eval

    def run(self) -> None:
        if self._view:
            self._engine.active_view_set(self._view)
        self._engine.update_stats("", told("Reading the scene"))
        self._add_passes()
        try:
            self._render()
            self._kept.keep(self._view_layer.name, self._view, self._native, self._data)
        finally:
            self._moments.end()
            del self._moments  # which holds this: the engine must not live on

    def _render(self) -> None:
        settings = render_settings(self._scene, self._view_layer, self._engine.is_preview)
        data = self._moments.begin(self._reporter, settings, self._job.part_of(settings, self._reporter))
        if data is None or not self._build(data) or not self._set_motion():
            self._write_nothing()
            return
        settings = self._possible(settings)
        if self._moments.slices and settings.integrator == "BIDIRECTIONAL":
            settings = replace(settings, photon_ring_samples=1)  # or moments of more samples would bring more light
        stars = self._find_stars(settings)
        if self._engine.test_break():
            self._write_nothing()
            return
        self._render_tiles(settings, stars)
        self._describe_mattes()

    def _read(self, reporter: Reporter, memory: Memory) -> SceneData | None:
        studio, should_stop = self._engine.is_preview, self._engine.test_break
        return read_scene(self._depsgraph, self._read_camera(), reporter, studio, should_stop, memory=memory)

    def _move(self, moment: int, settings: bentlight_native.RenderSettings) -> _Shown | None:
        """The native scene of another moment and its stars; None if the user gave up."""
        data = self._moments.move(moment)
        if data is None or not self._build(data):
            return None
        stars = self._find_stars(settings)
        return None if self._engine.test_break() else (self._native, stars)

    def _add_passes(self) -> None:
        for item in self._passes:
            if not item.builtin:
                self._engine.add_pass(item.name, item.width, item.components, layer=self._view_layer.name)

    def _matte_metadata(self) -> dict[str, str]:
        """Cryptomatte's manifests, for the picture's file."""
        found: dict[str, str] = {}
        for kind in passes.wanted_mattes(self._view_layer):
            layer = f"{self._view_layer.name}.Crypto{kind.capitalize()}"
            found |= metadata(layer, labels.matte_names(self._moments.frame, kind))
        return found

    def _describe_mattes(self) -> None:
        for field, value in self._matte_metadata().items():
            self._engine.get_result().stamp_data_add_field(field, value)

    def _read_camera(self) -> CameraData:
        camera = self._moments.camera
        if camera is None:
            raise RenderError("No camera: the scene needs an active camera")
        camera = camera.evaluated_get(self._depsgraph)
        if camera.type != "CAMERA":
            raise RenderError("Camera '{}' is not a camera object", camera.name)
        return read_camera(
            camera,
            self._scene.render,
            np.array(self._engine.camera_model_matrix(camera)),
            self._engine.camera_shift_x(camera),
        )

    def _find_stars(self, settings: bentlight_native.RenderSettings) -> StarLight | None:
        """Where the camera sees the world's stars; None if there are none, or the user gave up."""
        data, native = self._data, self._native
        if data.stars is None:
            return None
        window, threads = self._window, self._scene.render.threads
        group = labels.group_index(data.world_group, passes.light_groups(self._view_layer))
        if not native.shows_stars():
            self._reporter.warn("An orthographic camera sees no single stars; there are none in this picture")
            if not self._moments.slices:
                return None
            return StarLight(np.zeros((window[3], window[2], 3), np.float32), window[:2], group)  # others may see them
        for item, radius in zip(data.spacetimes, influence_radii(data.spacetimes), strict=True):
            if item.spin and radius != math.inf:
                self._reporter.warn(
                    "Black hole '{}' spins within a sphere of influence: no stars are seen in it", item.name
                )

        def find(progress: bentlight_native.Progress) -> StarLight:
            images = find_stars(native, data.stars, settings, threads, progress)
            shown = draw_stars(images, data.stars, settings, window, threads, progress)
            return StarLight(shown, window[:2], group)

        return self._on_a_thread(find)

    def _build(self, data: SceneData) -> bool:
        """Makes the native scene show this, by as few edits as it takes. False if the user gave up."""
        native, old = self._native, self._data
        self._native, self._data = None, data
        self._native = self._on_a_thread(
            lambda progress: update_scene(native, old, data, progress) if native else build_scene(data, progress)
        )
        if self._native is not None:
            labels.set_labels(self._native, data, passes.light_groups(self._view_layer))
        return self._native is not None

    def _set_motion(self) -> bool:
        """Tells the native scene where things are in the frames around, if a pass asks for that; as in Cycles it has no
        answer where there is motion blur. False if the user gave up."""
        self._native.set_motion()  # of another frame, if it was kept
        if "vector" not in self._channels or self._moments.slices or self._engine.is_preview:
            return True
        try:
            around = self._moments.read_neighbors()
            if around is None:
                return False
            motion.set_motion(self._native, self._data, *around)
        except RenderError as failure:
            self._reporter.warn("The Vector pass is 0: the frame before or after cannot be read: {}", failure)
            return True
        if self._job.is_kept:
            self._around = fingerprint(around)
        return True

    def _on_a_thread(self, work: Callable[[bentlight_native.Progress], T]) -> T | None:
        """What `work` returns, done on a thread of its own: who gives up need not wait for it. None if they did."""
        progress = bentlight_native.Progress()

        def attempt() -> T | None:  # without an exception, which would hold the scene in a circle of references
            try:
                return work(progress)
            except bentlight_native.Cancelled:
                return None

        with ThreadPoolExecutor(1) as pool:
            doing = pool.submit(attempt)
            while not wait([doing], _POLL).done:
                if self._engine.test_break():
                    progress.cancel()
        return doing.result()

    def _tiles(self, threads: int, samples: int) -> list[Tile]:
        largest = min(self._window[2] * self._window[3] / (threads * _TILES_PER_THREAD), _TILE_PATHS / samples)
        size = next((size for size in _TILE_SIZES if size * size <= largest), _TILE_SIZES[-1])
        return spiral_tiles(*self._window, size)

    def _render_tiles(self, whole: bentlight_native.RenderSettings, stars: StarLight | None) -> None:
        settings = self._job.part_of(whole, self._reporter)
        threads = self._scene.render.threads
        tiles = self._tiles(threads, settings.sample_count)
        limit = self._time_limit()
        recording = self._recording(whole, settings, tiles, stars, limit)
        kept = {"keeps_state": True, "begun": recording.begun, "light": recording.light} if recording else {}
        tiles = recording.tiles if recording else tiles
        blur = {"slices": self._moments.slices, "move": lambda moment: self._move(moment, settings)}
        session = Session(self._native, settings, tiles, self._channels, threads, limit, stars, **kept, **blur)
        written = False
        try:
            for finished in session.finished(_POLL):
                if finished:
                    self._write(finished)
                    written = True
                if recording:
                    if finished:
                        recording.add(finished)
                    recording.poll(session)
                if self._engine.test_break():
                    session.cancel()
                self._show_progress(session)
            if recording:
                farm.remove_when_written(recording.finish(self._engine.test_break(), session.star_sums))
        finally:
            if recording:
                recording.close()
        self._tell_lost_light(settings, session.lost_joins)
        if not written:
            self._write_nothing()

    def _tell_lost_light(self, settings: bentlight_native.RenderSettings, lost: float) -> None:
        """Near the horizon of a fast hole not all rays to lights are found; scattering makes up for it where it can."""
        if lost < _LOST_JOINS:
            return
        percent = f"{100 * lost:.1f}"
        if settings.light_sampling == "CONNECTIONS":
            self._reporter.warn(
                "{} % of the bent rays to lights were not found: their light is missing. Set Light Sampling to Both",
                percent,
            )
        elif self._data.lamps or any(sun.angle == 0 for sun in self._data.suns):
            self._reporter.warn(
                "{} % of the bent rays to lights were not found: of lamps without size that light is missing. "
                "Give them a size",
                percent,
            )

    def _time_limit(self) -> float:
        """Seconds; 0 if there is none."""
        limit = 0.0 if self._engine.is_preview else self._scene.bentlight.time_limit
        if limit and self._job.is_part:
            self._reporter.warn("Parts of a picture take all their samples: the time limit is off")
            return 0.0
        return limit

    def _recording(
        self,
        whole: bentlight_native.RenderSettings,
        settings: bentlight_native.RenderSettings,
        tiles: list[Tile],
        stars: StarLight | None,
        limit: float,
    ) -> Recording | None:
        """What keeps a part of the picture, or its checkpoint; None if nothing asks for that."""
        if not self._job.is_kept:
            return None
        names = tuple(dict.fromkeys((*self._channels, "sample_count")))
        picture = bentlight_native.Picture(
            layer=self._view_layer.name,
            view=self._view,
            frame=self._moments.number,
            settings=replace(whole, noise_threshold=settings.noise_threshold),
            window=self._border,
            is_cropped=not self._scene.render.use_border or self._scene.render.use_crop_to_border,
            names=names,
            passes=tuple(
                bentlight_native.PassPlan(p.name, p.components, p.channel, p.first, p.color) for p in self._passes
            ),
            scene=fingerprint([self._moments.frame, self._moments.times, self._around]),
            star_group=stars.group if stars else -1,
            metadata=self._matte_metadata(),
        )
        path = farm.stem(self._depsgraph.scene, self._moments.number, self._view_layer.name, self._view)
        order = fingerprint([self._data, self._moments.slices, bool(limit)])
        return Recording(self._job, path, picture, settings, self._window, tiles, order)

    def _possible(self, settings: bentlight_native.RenderSettings) -> bentlight_native.RenderSettings:
        """The settings, but with light followed from the camera alone where the scene does not allow otherwise."""
        if settings.integrator != "BIDIRECTIONAL":
            return settings
        parts = passes.tell_light_apart(self._passes)
        obstacle = self._native.bidirectional_obstacle() or (
            parts and told("the pass '{}' tells light apart", parts[0].name)
        )
        if not obstacle:
            return settings
        self._reporter.warn(
            "Bidirectional is not possible, light is followed from the camera alone: {}", told(obstacle)
        )
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
                target.rect.foreach_set(item.values(finished.channels).reshape(-1))
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
        status = told("Mem {:.0f}M (Peak {:.0f}M) | {:.0%}", used, peak, session.fraction)
        if left is not None:
            status = told("Remaining {} | {}", _clock(left), status)
        self._engine.update_stats(f"{self._view_layer.name} {self._view}".strip(), status)


def _clock(seconds: float) -> str:
    """As Cycles writes it: hours only if there are any, hundredths of seconds."""
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02}:{seconds:05.2f}" if hours else f"{minutes:02}:{seconds:05.2f}"
