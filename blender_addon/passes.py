"""PASSES: the one table of what a render can deliver to Blender; and the passes that a view layer lists by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import bentlight_native
import bpy
import numpy as np

from .report import RenderError
from .sync.aovs import valid_aovs

_IS_5 = bpy.app.version >= (5, 0, 0)  # which gave passes longer names


@dataclass(frozen=True)
class Pass:
    """A render pass. `toggle` is the view layer's property, ours if it starts with "bentlight."; "": listed by name.

    Its values are those of the channel from component `first` on, over those of the channel `color`, if it has one: the
    color of light passes, or the weight of vectors.
    """

    name: str
    components: str  # one letter for each, as EXR calls its channels
    socket: str  # type of the compositor's socket: 'COLOR', 'VECTOR' or 'VALUE'
    channel: str  # of the native renderer
    toggle: str = ""
    builtin: bool = False  # Blender makes room for it by itself
    first: int = 0
    color: str = ""

    @property
    def width(self) -> int:
        """Floats per pixel."""
        return len(self.components)

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that it is made of."""
        return (self.channel, self.color) if self.color else (self.channel,)

    def is_enabled(self, view_layer: bpy.types.ViewLayer) -> bool:
        """Whether the user wants it; the combined picture always exists."""
        return self.name == "Combined" or view_layer.path_resolve(self.toggle)

    def values(self, channels: Mapping[str, np.ndarray]) -> np.ndarray:
        """(height, width, components) float32 out of the native renderer's."""
        return bentlight_native.pass_values(channels, self.channel, self.first, self.width, self.color)


def _light_passes() -> Iterator[Pass]:
    for kind, short in (("Diffuse", "Diff"), ("Glossy", "Gloss"), ("Transmission", "Trans")):
        for part, abbreviation in (("Direct", "Dir"), ("Indirect", "Ind"), ("Color", "Col")):
            channel = f"{kind}_{part}".lower()
            color = f"{kind}_color".lower() if part != "Color" else ""
            name = f"{kind} {part}" if _IS_5 else short + abbreviation
            yield Pass(name, "RGB", "COLOR", channel, f"use_pass_{channel}", builtin=True, color=color)


def _long(name: str, short: str) -> str:
    return name if _IS_5 else short


# fmt: off
PASSES = (
    Pass("Combined", "RGBA", "COLOR", "combined", "use_pass_combined", builtin=True),
    Pass("Depth", "Z", "VALUE", "depth", "use_pass_z", builtin=True),
    Pass("Mist", "Z", "VALUE", "mist", "use_pass_mist", builtin=True),
    Pass("Normal", "XYZ", "VECTOR", "normal", "use_pass_normal", builtin=True),
    Pass("Position", "XYZ", "VECTOR", "position", "use_pass_position", builtin=True),
    Pass("Vector", "XYZW", "VECTOR", "vector", "use_pass_vector", builtin=True, color="vector_weight"),
    Pass("UV", "UVA", "VECTOR", "uv", "use_pass_uv", builtin=True),
    Pass(_long("Object Index", "IndexOB"), "X", "VALUE", "object_index", "use_pass_object_index", builtin=True),
    Pass(_long("Material Index", "IndexMA"), "X", "VALUE", "material_index", "use_pass_material_index", builtin=True),
    *_light_passes(),
    Pass(_long("Emission", "Emit"), "RGB", "COLOR", "emission", "use_pass_emit", builtin=True),
    Pass(_long("Environment", "Env"), "RGB", "COLOR", "environment", "use_pass_environment", builtin=True),
    Pass(_long("Ambient Occlusion", "AO"), "RGB", "COLOR", "ambient_occlusion", "use_pass_ambient_occlusion",
         builtin=True),
    Pass("Denoising Albedo", "RGB", "COLOR", "denoising_albedo", "bentlight.use_pass_denoising"),
    Pass("Denoising Normal", "XYZ", "VECTOR", "denoising_normal", "bentlight.use_pass_denoising"),
    Pass("Denoising Depth", "Z", "VALUE", "denoising_depth", "bentlight.use_pass_denoising"),
    Pass("Debug Sample Count", "X", "VALUE", "sample_count", "bentlight.use_pass_sample_count"),
    Pass("Bentlight Deflection", "XYZ", "VECTOR", "deflection", "bentlight.use_pass_deflection"),
    Pass("Bentlight Frequency Shift", "X", "VALUE", "frequency_shift", "bentlight.use_pass_frequency_shift"),
    Pass("Bentlight Image Order", "X", "VALUE", "image_order", "bentlight.use_pass_image_order"),
    Pass("Bentlight Disk", "RGB", "COLOR", "disk_only", "bentlight.use_pass_disk"),
    Pass("Bentlight Error", "X", "VALUE", "error", "bentlight.use_pass_error"),
    Pass("Bentlight Winding", "X", "VALUE", "winding", "bentlight.use_pass_winding"),
    Pass("Bentlight Fate", "X", "VALUE", "fate", "bentlight.use_pass_fate"),
)
# fmt: on

MATTE_KINDS = ("object", "material", "asset")
_MATTE_DEPTH_MAX = 16


def matte_ranks(view_layer: bpy.types.ViewLayer) -> int:
    """How many names each Cryptomatte keeps of a pixel: two a pass."""
    return 2 * ((min(_MATTE_DEPTH_MAX, view_layer.pass_cryptomatte_depth) + 1) // 2)


def wanted_mattes(view_layer: bpy.types.ViewLayer) -> list[str]:
    """Those of MATTE_KINDS that the user wants."""
    return [kind for kind in MATTE_KINDS if getattr(view_layer, f"use_pass_cryptomatte_{kind}")]


def light_groups(view_layer: bpy.types.ViewLayer) -> list[str]:
    """Names of the light groups with a pass, in the order of the core."""
    return [group.name for group in view_layer.lightgroups]


def _listed(view_layer: bpy.types.ViewLayer) -> Iterator[Pass]:
    """Passes that a view layer has by name. Cryptomatte's letters are lowercase, as its readers ask."""
    for kind in wanted_mattes(view_layer):
        for i in range(matte_ranks(view_layer) // 2):
            yield Pass(f"Crypto{kind.capitalize()}{i:02}", "rgba", "COLOR", f"matte_{kind}", first=4 * i)
    for i, (name, kind) in enumerate(valid_aovs(view_layer)):
        is_color = kind == "COLOR"
        yield Pass(name, "RGBA" if is_color else "X", "COLOR" if is_color else "VALUE", "aovs", first=4 * i)
    for i, name in enumerate(light_groups(view_layer)):
        yield Pass(f"Combined_{name}", "RGB", "COLOR", "light_groups", first=3 * i)


def enabled(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    """The passes that a view layer asks for, in the table's order."""
    return [item for item in PASSES if item.is_enabled(view_layer)] + list(_listed(view_layer))


def render_settings(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> dict[str, Any]:
    """Settings of the native renderer that only passes ask for."""
    found = {
        "alpha_threshold": view_layer.pass_alpha_threshold,
        "light_groups": len(view_layer.lightgroups),
        "aovs": len(valid_aovs(view_layer)),
        "matte_ranks": matte_ranks(view_layer),
    }
    if scene.world:
        mist = scene.world.mist_settings
        found["mist_start"], found["mist_depth"] = mist.start, mist.depth
        found["mist_falloff"] = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}[mist.falloff]
        found["occlusion_distance"] = scene.world.light_settings.distance
    return found


def tell_light_apart(wanted: list[Pass]) -> list[Pass]:
    """Those that need to know what scattered light, or whose it is."""
    told = ("light_groups", "ambient_occlusion")
    return [item for item in wanted if item.color.endswith("_color") or item.channel in told]


def result_passes(
    layer: bpy.types.RenderLayer, wanted: list[Pass], view: str
) -> Iterator[tuple[Pass, bpy.types.RenderPass]]:
    """Blender's buffers for the wanted passes of one view. Raises RenderError if one is missing."""
    for item in wanted:
        found = layer.passes.find_by_name(item.name, view)
        if found is None:
            raise RenderError("Blender made no room for the pass '{}'", item.name)
        yield item, found
