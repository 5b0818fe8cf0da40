"""PASSES: the one table of what a render can deliver to Blender."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy

from .report import RenderError

# Blender 5.0 gave its passes longer names.
_EMISSION, _ENVIRONMENT = ("Emission", "Environment") if bpy.app.version >= (5, 0, 0) else ("Emit", "Env")


@dataclass(frozen=True)
class Pass:
    """A render pass. `toggle` is the view layer's property, ours if it starts with "bentlight."."""

    name: str
    components: str  # one letter for each, as EXR calls its channels
    socket: str  # type of the compositor's socket: 'COLOR', 'VECTOR' or 'VALUE'
    channel: str  # of the native renderer
    toggle: str
    builtin: bool  # Blender makes room for it by itself

    @property
    def width(self) -> int:
        """Floats per pixel."""
        return len(self.components)

    def is_enabled(self, view_layer: bpy.types.ViewLayer) -> bool:
        """Whether the user wants it; the combined picture always exists."""
        return self.name == "Combined" or view_layer.path_resolve(self.toggle)


PASSES = (
    Pass("Combined", "RGBA", "COLOR", "combined", "use_pass_combined", builtin=True),
    Pass("Depth", "Z", "VALUE", "depth", "use_pass_z", builtin=True),
    Pass("Normal", "XYZ", "VECTOR", "normal", "use_pass_normal", builtin=True),
    Pass("Position", "XYZ", "VECTOR", "position", "use_pass_position", builtin=True),
    Pass(_EMISSION, "RGB", "COLOR", "emission", "use_pass_emit", builtin=True),
    Pass(_ENVIRONMENT, "RGB", "COLOR", "environment", "use_pass_environment", builtin=True),
    Pass("Denoising Albedo", "RGB", "COLOR", "denoising_albedo", "bentlight.use_pass_denoising", builtin=False),
    Pass("Denoising Normal", "XYZ", "VECTOR", "denoising_normal", "bentlight.use_pass_denoising", builtin=False),
    Pass("Bentlight Error", "X", "VALUE", "error", "bentlight.use_pass_error", builtin=False),
    Pass("Bentlight Winding", "X", "VALUE", "winding", "bentlight.use_pass_winding", builtin=False),
    Pass("Bentlight Fate", "X", "VALUE", "fate", "bentlight.use_pass_fate", builtin=False),
)


def enabled(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    """The passes that a view layer asks for, in the table's order."""
    return [item for item in PASSES if item.is_enabled(view_layer)]


def result_passes(
    layer: bpy.types.RenderLayer, wanted: list[Pass], view: str
) -> Iterator[tuple[Pass, bpy.types.RenderPass]]:
    """Blender's buffers for the wanted passes of one view. Raises RenderError if one is missing."""
    for item in wanted:
        found = layer.passes.find_by_name(item.name, view)
        if found is None:
            raise RenderError(f"Blender made no room for the pass '{item.name}'")
        yield item, found
