"""The material of an accretion disk: what it emits, how its frequency is shifted, where it ends.

With g = nu_observed / nu_emitted, a blackbody of temperature T is seen as one of temperature g T, exactly; a color of
unknown spectrum as g^4 times itself, which is right for the sum over all frequencies. The Doppler and the gravitational
factor of g are each raised to the power of their slider.
"""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np

from ..report import RenderError
from . import thermal
from .disk import DiskExtent, Pattern, hottest_flux
from .images import ImageTable, has_associated_alpha
from .material import Compiled, compile_output, node_tree
from .nodes.compiler import Compiler

_RAMP_ENTRIES = 256

MATERIAL_ATTRIBUTES = (
    "bentlight_radius",
    "bentlight_azimuth",
    "bentlight_frequency_ratio",
    "bentlight_doppler",
    "bentlight_gravitational",
    "bentlight_image_order",
    "bentlight_pattern",
)
"""What the nodes of a disk's own material may ask for by Attribute nodes."""


def compile_disk(owner: str, settings: Any, extent: DiskExtent, pattern: Pattern, images: ImageTable) -> Compiled:
    """The program of a disk."""
    writer = _DiskWriter(Compiler(owner, images, bpy.app.version), settings, extent, pattern)
    writer.write()
    compiler = writer.compiler
    return Compiled(compiler.builder.build(compiler.owner), compiler.warnings, compiler.wanted)


def ramp_table(ramp: bpy.types.ColorRamp) -> np.ndarray:
    """(n, 4) RGB and alpha at equal steps of a color ramp."""
    return np.array([tuple(ramp.evaluate(i / (_RAMP_ENTRIES - 1))) for i in range(_RAMP_ENTRIES)], np.float32)


class _DiskWriter:
    """Writes one disk's program; operands are as in ProgramBuilder."""

    def __init__(self, compiler: Compiler, settings: Any, extent: DiskExtent, pattern: Pattern) -> None:
        self.compiler, self._settings, self._extent = compiler, settings, extent
        self._constant = compiler.builder.constant
        chart = "ISOTROPIC" if extent.is_isotropic else "OBLATE"
        self._spin = self._constant(extent.spin)
        mass = self._constant(extent.mass)
        first = compiler.emit("disk", mass, self._spin, immediates=(chart,))
        self._radius, self._azimuth, self._doppler, self._gravitational, self._order = range(first, first + 5)
        self._pattern = pattern

    def write(self) -> None:
        """Everything."""
        cover = self._cover()
        if self._settings.emission == "MATERIAL":
            self._write_material(cover)
        else:
            color, alpha = self._color()
            cover = self._multiply(cover, self._constant(self._settings.opacity), alpha)
            if self._settings.pattern > 0:
                factor = self._noise() + 1  # the operation's second output
                color = self._multiply(color, factor)
                cover = self._multiply(cover, self._math("MINIMUM", factor, 1.0))
            self.compiler.emit("emission", cover, color, self._constant(self._settings.strength))
        rest = self._math("SUBTRACT", 1.0, cover)
        self.compiler.emit("transparent", self._constant(1.0), rest)

    def _math(self, operation: str, *values: float | int) -> int:
        """`float`: a constant; `int`: an operand."""
        operands = [self._constant(value) if isinstance(value, float) else value for value in values]
        operands += [self._constant(0.0)] * (3 - len(operands))
        return self.compiler.emit("math", *operands, immediates=(operation,))

    def _multiply(self, first: int, *others: int) -> int:
        for other in others:
            first = self.compiler.emit("multiply", first, other)
        return first

    def _noise(self) -> int:
        pattern = self._pattern
        values = map(self._constant, (pattern.phase, pattern.period, pattern.scale, pattern.contrast))
        return self.compiler.emit("disk_pattern", self._radius, self._azimuth, self._spin, *values)

    def _cover(self) -> int:
        """1 on the disk, 0 outside; in between along a soft outer edge."""
        extent, inside = self._extent, self._math("GREATER_THAN", self._radius, self._extent.inner)
        width = self._settings.softness * (extent.outer - extent.inner)
        if width > 0:
            edge = (self._radius, extent.outer - width, extent.outer, 1.0, 0.0, 0.0)
            operands = [self._constant(value) if isinstance(value, float) else value for value in edge]
            fade = self.compiler.emit("map_range", *operands, immediates=("SMOOTHSTEP", "OFF"))
        else:
            fade = self._math("LESS_THAN", self._radius, extent.outer)
        return self._multiply(inside, fade)

    def _shift(self) -> int:
        """g, as far as the sliders let it."""
        doppler = self._math("POWER", self._doppler, self._settings.doppler)
        return self._multiply(doppler, self._math("POWER", self._gravitational, self._settings.gravitational))

    def _color(self) -> tuple[int, int]:
        """Radiance at strength 1, and alpha."""
        kind = self._settings.emission
        if kind in {"PAGE_THORNE", "POWER_LAW"}:
            return self._thermal(self._temperature()), self._constant(1.0)
        color, alpha = self._ramp() if kind == "RAMP" else self._image()
        return self._multiply(color, self._math("POWER", self._shift(), 4.0)), alpha

    def _temperature(self) -> int:
        """Of the blackbody that is seen, in K."""
        if self._settings.emission == "POWER_LAW":
            part = self._math("POWER", self._math("DIVIDE", self._radius, self._extent.inner), -self._settings.exponent)
        else:
            flux = self.compiler.emit("disk_flux", self._radius, self._spin)
            part = self._math("POWER", self._math("DIVIDE", flux, hottest_flux(self._extent)), 0.25)
        return self._multiply(self._constant(self._settings.temperature), part, self._shift())

    def _thermal(self, temperature: int) -> int:
        table = self.compiler.builder.table(thermal.blackbody_table(self.compiler.version))
        ends = map(self._constant, (thermal.LOWEST_K, thermal.HIGHEST_K))
        light = self.compiler.emit("blackbody_light", temperature, *ends, immediates=table)
        return self._multiply(light, self._constant(1 / thermal.luminance(self._settings.temperature)))

    def _depth(self) -> int:
        """0 at the inner, 1 at the outer edge."""
        extent = self._extent
        return self._math("DIVIDE", self._math("SUBTRACT", self._radius, extent.inner), extent.outer - extent.inner)

    def _ramp(self) -> tuple[int, int]:
        texture = self._settings.ramp
        if texture is None or not texture.use_color_ramp:
            raise RenderError("{}: its disk has no color ramp: choose a texture that has one", self.compiler.owner)
        table = self.compiler.builder.table(ramp_table(texture.color_ramp))
        color = self.compiler.emit("ramp", self._depth(), immediates=(*table, "ON"))
        return color, color + 1

    def _image(self) -> tuple[int, int]:
        image = self._settings.image
        if image is None:
            raise RenderError("{}: its disk has no image: choose one", self.compiler.owner)
        index = self.compiler.images.index_of(image, self.compiler.warnings.append)
        around = self._math("DIVIDE", self._azimuth, 2 * math.pi)
        edge = 0.5 / image.size[1]  # images repeat around the hole, not outwards
        height = self._math("MINIMUM", self._math("MAXIMUM", self._depth(), edge), 1 - edge)
        place = self.compiler.emit("combine", around, height, self._constant(0.0))
        straight = "ON" if has_associated_alpha(image) else "OFF"
        color = self.compiler.emit("image", place, immediates=(index, "Linear", "REPEAT", straight))
        return color, color + 1

    def _write_material(self, cover: int) -> None:
        material = self._settings.material
        if material is None or node_tree(material) is None:
            raise RenderError("{}: its disk has no material with nodes: choose one", self.compiler.owner)
        place, factors = (self._radius, self._azimuth), (self._shift(), self._doppler, self._gravitational)
        values = (*place, *factors, self._order, self._noise())
        self.compiler.given = dict(zip(MATERIAL_ATTRIBUTES, values, strict=True))
        compile_output(self.compiler, node_tree(material), cover)
