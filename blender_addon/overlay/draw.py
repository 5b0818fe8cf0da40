"""Draws the overlay into 3D viewports, and remembers what need not be found anew for each redraw."""

from __future__ import annotations

from collections.abc import Hashable

import blf
import bpy
import gpu
import numpy as np
from bpy.app.translations import pgettext_iface
from gpu_extras.batch import batch_for_shader

from .. import changes
from ..report import RenderError
from . import contents
from .contents import Line

_COLORS = {
    "HORIZON": (1.0, 0.28, 0.2),
    "PHOTON": (1.0, 0.8, 0.25),
    "ISCO": (0.3, 0.85, 0.9),
    "DISK": (1.0, 0.5, 0.1),
    "THROAT": (0.65, 0.5, 1.0),
    "ESCAPED": (0.75, 0.85, 1.0),
    "CAPTURED": (0.9, 0.2, 0.25),
    "HIT": (0.45, 1.0, 0.5),
}
_IN_FRONT, _BEHIND = 0.9, 0.25  # opacity of lines, the latter where surfaces hide them
_WIDTH, _RAY_WIDTH = 1.5, 1.0  # pixels
_FONT_SIZE, _MARGIN = 11, 4  # pixels
_LEAST_SIZE = 60  # pixels across a line that gets its name
_MESSAGE_PLACE = 20  # pixels from the viewport's lower left corner
# Where around its line a name is, so that the names of a hole's lines do not meet.
_NAME_ANGLES = np.radians([110.0, 215.0, 10.0, -40.0, 165.0, 70.0])
_SHADER = "POLYLINE_UNIFORM_COLOR"


class Overlay:
    """All viewports of a session. What it keeps are names and numbers, never Blender's data."""

    def __init__(self) -> None:
        self._change = -1  # up to which what follows holds
        self._names: dict[Hashable, list[str]] = {}
        self._rays: dict[Hashable, tuple[list[Line], str]] = {}

    def lines(self, context: bpy.types.Context) -> tuple[list[Line], list[Line], str]:
        """What the viewport of the context shows: lines around objects, rays, and why there are no rays, or ""."""
        settings = context.scene.bentlight.overlay
        if not context.space_data.overlay.show_overlays or not (settings.show_circles or settings.rays != "OFF"):
            return [], [], ""
        if self._change != changes.count():
            self._names.clear()
            self._rays.clear()
            self._change = changes.count()
        names = self._benders(context)
        if not names and settings.rays == "OFF":
            return [], [], ""
        depsgraph = context.evaluated_depsgraph_get()
        objects = [obj for name in names if (obj := context.view_layer.objects.get(name)) is not None]
        space = context.space_data
        shown = {obj for obj in objects if obj.visible_get(view_layer=context.view_layer, viewport=space)}
        subjects = contents.read_subjects(objects, shown.__contains__, depsgraph)
        marks: list[Line] = []
        if settings.show_circles:
            view = context.region_data
            eye = contents.camera_eye(np.array(view.view_matrix), view.is_perspective)
            marks = contents.mark_lines(subjects, eye)
        return marks, *self._ray_lines(context, depsgraph, subjects)

    def _benders(self, context: bpy.types.Context) -> list[str]:
        """Names of the objects that bend light: there may be many others."""
        key = context.scene.name_full, context.view_layer.name
        if key not in self._names:
            self._names[key] = [obj.name for obj in context.view_layer.objects if obj.bentlight.kind != "NONE"]
        return self._names[key]

    def _ray_lines(
        self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph, subjects: list[contents.Subject]
    ) -> tuple[list[Line], str]:
        settings = context.scene.bentlight.overlay
        if settings.rays == "OFF":
            return [], ""
        names = tuple(subject.item.name for subject in subjects)
        cursor = tuple(context.scene.cursor.location) if settings.rays == "CURSOR" else None
        key = context.scene.name_full, context.view_layer.name, settings.rays, settings.ray_count, cursor, names
        if key not in self._rays:
            try:
                self._rays[key] = contents.ray_lines(context.scene, depsgraph, subjects), ""
            except RenderError as error:
                self._rays[key] = [], str(error)
        return self._rays[key]


def _draw_lines(overlay: Overlay) -> None:
    """In the scene's space."""
    marks, rays, _message = overlay.lines(bpy.context)
    if not marks and not rays:
        return
    shader = gpu.shader.from_builtin(_SHADER)
    scale = bpy.context.preferences.system.pixel_size
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_mask_set(False)
    for test, opacity in (("LESS_EQUAL", _IN_FRONT), ("GREATER", _BEHIND)):
        gpu.state.depth_test_set(test)
        for lines, width in ((marks, _WIDTH), (rays, _RAY_WIDTH)):
            shader.bind()
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            shader.uniform_float("lineWidth", width * scale)
            for line in lines:
                shader.uniform_float("color", (*_COLORS[line.kind], opacity))
                points = line.points.astype(np.float32)
                batch_for_shader(shader, "LINE_STRIP", {"pos": points}).draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _draw_names(overlay: Overlay) -> None:
    """In the region's pixels."""
    context = bpy.context
    marks, _rays, message = overlay.lines(context)
    scale = context.preferences.system.ui_scale
    font = 0
    blf.size(font, _FONT_SIZE * scale)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, 0.0, 0.0, 0.0, 1.0)
    blf.shadow_offset(font, 1, -1)
    if context.scene.bentlight.overlay.show_labels:
        matrix = np.array(context.region_data.perspective_matrix)
        size = np.array([context.region.width, context.region.height])
        for index, line in enumerate(marks):
            angle = _NAME_ANGLES[index % len(_NAME_ANGLES)]
            place = name_place(line.points, matrix, size, angle)
            if place is not None:
                name = pgettext_iface(line.name)
                left = blf.dimensions(font, name)[0] if np.cos(angle) < 0 else 0.0
                place += _MARGIN * scale * np.sign([np.cos(angle), np.sin(angle)]) - (left, 0)
                _write(font, place, name, _COLORS[line.kind])
    if message:
        _write(font, np.full(2, _MESSAGE_PLACE * scale), message, _COLORS["CAPTURED"])
    blf.disable(font, blf.SHADOW)


def name_place(points: np.ndarray, matrix: np.ndarray, size: np.ndarray, angle: float) -> np.ndarray | None:
    """Pixel (2,) beside which a line's name is written; None if it is behind the viewer or small.

    points (n, 3) world, matrix (4, 4) clip space from world, size: of the region in pixels. angle: towards which
    the place lies, radians counterclockwise from the right.
    """
    clip = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ matrix.T
    if (clip[:, 3] <= 0).any():
        return None
    pixels = (clip[:, :2] / clip[:, 3:] + 1) / 2 * size
    if np.ptp(pixels, axis=0).max() < _LEAST_SIZE:
        return None
    return pixels[np.argmax(pixels @ np.array([np.cos(angle), np.sin(angle)]))]


def _write(font: int, place: np.ndarray, text: str, color: tuple[float, float, float]) -> None:
    blf.color(font, *color, 1.0)
    blf.position(font, float(place[0]), float(place[1]), 0.0)
    blf.draw(font, text)


_draw_handlers: list[object] = []


def register() -> None:
    """Begins to draw; without a window there is nothing to draw into."""
    if not bpy.app.background:
        overlay = Overlay()
        add = bpy.types.SpaceView3D.draw_handler_add
        _draw_handlers.append(add(_draw_lines, (overlay,), "WINDOW", "POST_VIEW"))
        _draw_handlers.append(add(_draw_names, (overlay,), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Ends it."""
    while _draw_handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_draw_handlers.pop(), "WINDOW")
