"""The panel of the camera's properties: where it is among black holes."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from ..checks import inside
from ..report import RenderError
from ..sync.spacetime import check_alone, read_spacetime
from .panel import EnginePanel, tell


class BENTLIGHT_PT_camera(EnginePanel, bpy.types.Panel):
    """How near a camera is to what bends its light, counted from the middle."""

    bl_label = "Spacetime"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        holes = any(obj.bentlight.kind == "BLACK_HOLE" for obj in context.view_layer.objects)
        return super().poll(context) and context.camera is not None and context.object is not None and holes

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        place = np.array(context.object.matrix_world.translation)
        for obj in context.view_layer.objects:
            if obj.bentlight.kind != "BLACK_HOLE" or obj.hide_render or not obj.bentlight.mass > 0:
                continue
            item = read_spacetime(obj, obj.matrix_world)
            try:
                check_alone(item)
            except RenderError:
                continue  # a warning tells
            text = iface_("{:.4g} masses from '{}'").format(inside.masses_away(item, place), obj.name)
            tell(column, text, context.region.width, icon="SHADING_SOLID")


CLASSES = (BENTLIGHT_PT_camera,)
