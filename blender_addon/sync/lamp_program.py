"""The programs of lamps: power, color and node tree, times where a lamp's cone, its slats or its disk let it shine.

Radiances are those of Cycles, with E the lamp's color times its power and A the area of its surface: E / (pi A);
without "Normalize" E / pi. A lamp without size has the radiant intensity E / (4 pi). A sun of angular diameter a has
the radiance E / (pi sin^2(a/2)), without "Normalize" or an angle E.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ..report import Reporter, told
from .images import ImageTable
from .material import Compiled, compile_output, node_tree
from .nodes.compiler import Compiler

_SPREAD_MIN = np.radians(1)


def compile_lamp(light: bpy.types.Light, area: float, images: ImageTable, reporter: Reporter) -> Compiled:
    """The program of a lamp that is not a sun; `area` is what its power is divided by."""
    compiler = _compiler(light, images)
    weight = compiler.builder.constant(_power(light) / (np.pi * area))
    if light.type == "AREA":
        weight = _spread(compiler, weight, light, reporter)
    else:
        weight = _sphere_and_cone(compiler, weight, light)
    return _compile(compiler, light, weight)


def compile_sun(light: bpy.types.Light, factor: float, images: ImageTable) -> Compiled:
    """The program of a sun."""
    compiler = _compiler(light, images)
    return _compile(compiler, light, compiler.builder.constant(_power(light) * factor))


def sun_radiance(light: bpy.types.Light, factor: float) -> np.ndarray:
    """Radiance (3,) of a sun without a node tree."""
    return np.maximum(_power(light) * factor, 0)


def _compiler(light: bpy.types.Light, images: ImageTable) -> Compiler:
    return Compiler(told("Light '{}'", light.name), images, bpy.app.version)


def _power(light: bpy.types.Light) -> np.ndarray:
    """Color times power: watts, or for a sun watts per square meter."""
    power = np.array(light.color, dtype=np.float64) * light.energy * 2.0**light.exposure
    return power * np.array(light.temperature_color) if light.use_temperature else power


def _compile(compiler: Compiler, light: bpy.types.Light, weight: int) -> Compiled:
    tree = node_tree(light)
    if tree is None:
        one = compiler.builder.constant(1.0)
        compiler.emit("emission", weight, one, one)
    else:
        compiler.coordinates = _coordinates(compiler, light)
        compile_output(compiler, tree, weight)
    return Compiled(compiler.builder.build(compiler.owner), compiler.warnings, compiler.wanted)


def _times(compiler: Compiler, weight: int, operation: str, *operands: float, immediates: tuple = ()) -> int:
    constants = map(compiler.builder.constant, operands)
    return compiler.emit("multiply", weight, compiler.emit(operation, *constants, immediates=immediates))


def _sphere_and_cone(compiler: Compiler, weight: int, light: bpy.types.Light) -> int:
    radius, soft = light.shadow_soft_size, light.use_soft_falloff
    if radius > 0:
        weight = _times(compiler, weight, "sphere_lamp", radius, immediates=("ON" if soft else "OFF",))
    if light.type == "SPOT":
        edge = np.cos(light.spot_size / 2)
        weight = _times(
            compiler, weight, "spot_cone", edge, (1 - edge) * light.spot_blend, 0.0 if soft else max(radius, 0.0)
        )
    return weight


def _spread(compiler: Compiler, weight: int, light: bpy.types.AreaLight, reporter: Reporter) -> int:
    """As in Cycles the power stays: it is divided by the integral of (tan h - tan x) cos x over the cone, x < h."""
    if light.spread >= np.pi * (1 - 1e-6):
        return weight
    if light.spread < _SPREAD_MIN:
        reporter.warn("Light '{}': a spread of less than 1 degree is too hard to find; 1 degree is used", light.name)
    half = max(light.spread, _SPREAD_MIN) / 2
    difference = np.tan(half) - half if half > 0.05 else half**3 / 3
    return _times(compiler, weight, "area_spread", np.tan(half), 1 / difference)


def _coordinates(compiler: Compiler, light: bpy.types.Light) -> dict[str, Any]:
    """What lamps have instead of the coordinates of meshes."""
    is_disk = light.type in {"POINT", "SPOT"} and (light.shadow_soft_size <= 0 or light.use_soft_falloff)
    coordinates = {"GENERATED": lambda: compiler.emit("coordinate", immediates=("OBJECT",))}
    if is_disk:  # a disk's normal is where its light goes
        coordinates["NORMAL"] = lambda: compiler.emit("coordinate", immediates=("BEAM",))
        for kind in ("SHADING_NORMAL", "TRUE_NORMAL"):
            coordinates[kind] = lambda: compiler.emit("coordinate", immediates=("INCOMING",))
    if light.type == "POINT":
        coordinates["UV"] = lambda: _sphere_uv(compiler, "BEAM" if is_disk else "NORMAL")
    if light.type == "SPOT":
        coordinates["UV"] = lambda: _spot_uv(compiler, light)
    return coordinates


def _sphere_uv(compiler: Compiler, kind: str) -> int:
    """Longitude and latitude of a direction."""
    half = compiler.builder.constant(0.5)
    direction = compiler.emit("coordinate", immediates=(kind,))
    place = compiler.emit("vector_math", direction, half, half, half, immediates=("MULTIPLY_ADD",))
    return compiler.emit("project", place, immediates=("SPHERE",))


def _spot_uv(compiler: Compiler, light: bpy.types.SpotLight) -> int:
    """The image of a projector: as wide as the cone."""
    constant, zero = compiler.builder.constant, compiler.builder.constant(0.0)
    beam = compiler.emit("coordinate", immediates=("BEAM",))
    x, y, z = (compiler.emit("channel", beam, immediates=(name,)) for name in "XYZ")
    factor = compiler.emit("math", constant(-0.5 / np.tan(light.spot_size / 2)), z, zero, immediates=("DIVIDE",))
    u, v = (compiler.emit("math", side, factor, constant(0.5), immediates=("MULTIPLY_ADD",)) for side in (x, y))
    return compiler.emit("combine", u, v, zero)
