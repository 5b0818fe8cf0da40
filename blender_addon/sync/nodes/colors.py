"""Nodes that make and change colors, and curves."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..cie_1931 import COLOR_MATCHING, FIRST_NM, RGB_FROM_XYZ, RGB_FROM_XYZ_5, STEP_NM
from .compiler import NodeView, Outputs, value_node

TABLE_ENTRIES = 257  # at which Cycles evaluates ramps and curves, linear in between


@value_node("ShaderNodeMixRGB")
def _mix_rgb(node: NodeView) -> Outputs:
    factor = node.emit("clamp", node.input("Fac"))
    operands = (factor, node.input("Color1"), node.input("Color2"))
    result = node.emit("blend", *operands, immediates=(node.node.blend_type,))
    return {"Color": node.emit("clamp", result) if node.node.use_clamp else result}


@value_node("ShaderNodeValToRGB")
def _color_ramp(node: NodeView) -> Outputs:
    ramp = node.node.color_ramp
    entries = np.array([ramp.evaluate(i / (TABLE_ENTRIES - 1)) for i in range(TABLE_ENTRIES)], np.float32)
    start, count = node.compiler.builder.table(np.nan_to_num(entries))
    smooth = "OFF" if ramp.interpolation == "CONSTANT" else "ON"
    color = node.emit("ramp", node.input("Fac"), immediates=(start, count, smooth))
    return {"Color": color, "Alpha": color + 1}


@value_node("ShaderNodeSeparateColor", "ShaderNodeSeparateRGB", "ShaderNodeSeparateHSV")
def _separate_color(node: NodeView) -> Outputs:
    """The second and third are of Blender up to 4.5."""
    color, model = node.input(node.node.inputs[0].identifier), _color_model(node)
    if model != "RGB":
        color = node.emit("color_to_model", color, immediates=(model,))
    channels = [node.emit("channel", color, immediates=(channel,)) for channel in "XYZ"]
    return {socket.identifier: channel for socket, channel in zip(node.node.outputs, channels, strict=True)}


@value_node("ShaderNodeCombineColor", "ShaderNodeCombineRGB", "ShaderNodeCombineHSV")
def _combine_color(node: NodeView) -> Outputs:
    color = node.emit("combine", *(node.input(socket.identifier) for socket in node.node.inputs))
    model = _color_model(node)
    if model != "RGB":
        color = node.emit("color_from_model", color, immediates=(model,))
    return {node.node.outputs[0].identifier: color}


def _color_model(node: NodeView) -> str:
    return getattr(node.node, "mode", node.node.bl_idname[-3:])


@value_node("ShaderNodeRGBToBW")
def _color_to_gray(node: NodeView) -> Outputs:
    return {"Val": node.emit("dot", node.input("Color"), node.constant(node.compiler.luminance))}


@value_node("ShaderNodeGamma")
def _gamma(node: NodeView) -> Outputs:
    return {"Color": node.emit("gamma", node.input("Color"), node.input("Gamma"))}


@value_node("ShaderNodeInvert")
def _invert(node: NodeView) -> Outputs:
    return {"Color": node.emit("invert", node.input("Fac"), node.input("Color"))}


@value_node("ShaderNodeBrightContrast")
def _brightness_contrast(node: NodeView) -> Outputs:
    return {"Color": node.emit("brightness_contrast", *map(node.input, ("Color", "Bright", "Contrast")))}


@value_node("ShaderNodeHueSaturation")
def _hue_saturation(node: NodeView) -> Outputs:
    return {"Color": node.emit("hue_saturation", *map(node.input, ("Hue", "Saturation", "Value", "Fac", "Color")))}


@value_node("ShaderNodeBlackbody")
def _blackbody(node: NodeView) -> Outputs:
    return {"Color": node.emit("blackbody", node.input("Temperature"))}


@value_node("ShaderNodeWavelength")
def _wavelength(node: NodeView) -> Outputs:
    """The observer's color of one wavelength, scaled as in Cycles, without negative parts; black beyond the table."""
    entries = np.zeros((len(COLOR_MATCHING), 4), np.float32)
    matrix = RGB_FROM_XYZ_5 if node.compiler.version >= (5, 0) else RGB_FROM_XYZ
    entries[:, :3] = COLOR_MATCHING @ matrix.T / 2.52
    table = node.compiler.builder.table(entries)
    zero, last = node.constant(0.0), FIRST_NM + STEP_NM * (len(entries) - 1)
    wavelength = node.input("Wavelength")
    ends = (node.constant(FIRST_NM), node.constant(last), zero, node.constant(1.0), zero)
    place = node.emit("map_range", wavelength, *ends, immediates=("LINEAR", "OFF"))
    color = node.emit("ramp", place, immediates=(*table, "ON"))
    for limit, side in ((FIRST_NM, "GREATER_THAN"), (last, "LESS_THAN")):
        color = node.emit(
            "multiply", color, node.emit("math", wavelength, node.constant(limit), zero, immediates=(side,))
        )
    return {"Color": node.emit("vector_math", color, zero, zero, zero, immediates=("MAXIMUM",))}


@value_node("ShaderNodeRGBCurve")
def _rgb_curves(node: NodeView) -> Outputs:
    *channels, combined = node.node.mapping.curves
    return {"Color": _curves(node, "Fac", "Color", [(combined, channel) for channel in channels])}


@value_node("ShaderNodeVectorCurve")
def _vector_curves(node: NodeView) -> Outputs:
    return {"Vector": _curves(node, "Fac", "Vector", [(curve,) for curve in node.node.mapping.curves])}


@value_node("ShaderNodeFloatCurve")
def _float_curve(node: NodeView) -> Outputs:
    return {"Value": _curves(node, "Factor", "Value", [(node.node.mapping.curves[0],)] * 3)}


def _curves(node: NodeView, factor: str, value: str, channels: list[tuple[Any, ...]]) -> int:
    """Three channels, each mapped by curves one after the other, over the range that all curves' points span."""
    mapping = node.node.mapping
    mapping.update()
    curves = {curve for channel in channels for curve in channel}
    start = min(curve.points[0].location[0] for curve in curves)
    width = max(curve.points[-1].location[0] for curve in curves) - start
    places = start + width * np.linspace(0, 1, TABLE_ENTRIES)
    entries = np.zeros((TABLE_ENTRIES, 4), np.float32)
    for column, channel in enumerate(channels):
        values = places
        for curve in channel:
            values = [mapping.evaluate(curve, x) for x in values]
        entries[:, column] = values
    table = node.compiler.builder.table(np.nan_to_num(entries))
    beyond = "ON" if mapping.extend == "EXTRAPOLATED" else "OFF"
    operands = (node.input(factor), node.input(value), node.constant(start), node.constant(width))
    return node.emit("curves", *operands, immediates=(*table, beyond))
