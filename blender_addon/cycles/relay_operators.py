"""The relay camera's buttons, and the handler that keeps its maps fitting, frame after frame."""

from __future__ import annotations

import logging

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty

from ..report import RenderError, Reporter, told
from . import failures, relay, render_state

log = logging.getLogger(__name__)


def _bake(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, reporter: Reporter) -> str:
    """Bakes what no longer fits; says what came of it."""
    with render_state.as_rendered(view_layer) as depsgraph:
        maps = relay.update(scene, depsgraph, reporter)
    failures.forget(scene, "relay camera")
    if maps is None:
        return told("No relay camera")
    text = "{:.2f} million curved rays in {:.1f} s; {:.1f} % see black; {} pixels of compressed image take more"
    return told(text, maps.rays / 1e6, maps.seconds, 100 * maps.lost / max(maps.rays, 1), maps.fine_pixels)


class _Operator:
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            self.report({"INFO"}, self._work(context))
        except (RenderError, OSError, RuntimeError) as error:
            self.report({"ERROR"}, told("Bentlight: {}", error))
            return {"CANCELLED"}
        return {"FINISHED"}


class BENTLIGHT_OT_relay_setup(_Operator, bpy.types.Operator):
    """Let Cycles take curved camera rays: Bentlight traces each ray to the surface that it meets, Cycles shades it"""

    bl_idname = "bentlight.relay_setup"
    bl_label = "Use Relay Camera"

    bake: BoolProperty(name="Bake Now", description="Trace the rays at once, not only before a render", default=True)

    def _work(self, context: bpy.types.Context) -> str:
        camera = relay.setup(context.scene)
        if not self.bake:
            return told("The scene's camera is '{}' now", camera.name)
        try:
            baked = _bake(context.scene, context.view_layer, Reporter(self.report))
        except Exception:
            relay.clear(context.scene)
            raise
        return told("The scene's camera is '{}' now: {}", camera.name, baked)


class BENTLIGHT_OT_relay_clear(_Operator, bpy.types.Operator):
    """Give the scene its own camera back"""

    bl_idname = "bentlight.relay_clear"
    bl_label = "Remove Relay Camera"

    def _work(self, context: bpy.types.Context) -> str:
        had = relay.clear(context.scene)
        failures.forget(context.scene, "relay camera")
        return told("The relay camera is removed") if had else told("There was no relay camera")


@persistent
def _before_render(scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """Before each frame of a render: handlers cannot stop it, so what goes wrong is said loudly."""
    if scene.render.engine != "CYCLES" or relay.source_of(scene.camera) is None:
        return
    try:
        reporter = Reporter(lambda level, text: log.warning("%s", text))
        log.info("%s", _bake(scene, scene.view_layers[0], reporter))
    except (RenderError, OSError, RuntimeError) as error:
        relay.darken(scene)
        text = told("The relay camera has no maps, the picture stays black: {}", error)
        failures.remember(scene, "relay camera", text)


_CLASSES = (BENTLIGHT_OT_relay_setup, BENTLIGHT_OT_relay_clear)


def register() -> None:
    """Adds all of it."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.render_pre.append(_before_render)


def unregister() -> None:
    """Removes it, and this session's maps."""
    if _before_render in bpy.app.handlers.render_pre:
        bpy.app.handlers.render_pre.remove(_before_render)
    relay.forget_all()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
