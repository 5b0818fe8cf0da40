"""Nodes that make and change numbers, colors and vectors."""

from __future__ import annotations

import numpy as np

from .compiler import NodeView, Outputs, socket_value, value_node

RAMP_ENTRIES = 257  # at which Cycles evaluates a color ramp, linear in between


@value_node("ShaderNodeRGB", "ShaderNodeValue")
def _constant(node: NodeView) -> Outputs:
    socket = node.node.outputs[0]
    return {socket.identifier: node.constant(socket_value(socket))}


@value_node("ShaderNodeMath")
def _math(node: NodeView) -> Outputs:
    operands = [node.input(name) for name in ("Value", "Value_001", "Value_002")]
    result = node.emit("math", *operands, immediates=(node.node.operation,))
    return {"Value": node.emit("clamp", result) if node.node.use_clamp else result}


@value_node("ShaderNodeMixRGB")
def _mix_rgb(node: NodeView) -> Outputs:
    factor = node.emit("clamp", node.input("Fac"))
    operands = (factor, node.input("Color1"), node.input("Color2"))
    result = node.emit("blend", *operands, immediates=(node.node.blend_type,))
    return {"Color": node.emit("clamp", result) if node.node.use_clamp else result}


@value_node("ShaderNodeMix")
def _mix(node: NodeView) -> Outputs:
    settings = node.node
    names = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}
    if settings.data_type not in names:
        return {}
    name = names[settings.data_type]
    by_component = name == "Vector" and settings.factor_mode == "NON_UNIFORM"
    factor = node.input("Factor_Vector" if by_component else "Factor_Float")
    if settings.clamp_factor:
        factor = node.emit("clamp", factor)
    operands = (factor, node.input(f"A_{name}"), node.input(f"B_{name}"))
    if name != "Color":
        return {f"Result_{name}": node.emit("mix", *operands)}
    result = node.emit("blend", *operands, immediates=(settings.blend_type,))
    return {"Result_Color": node.emit("clamp", result) if settings.clamp_result else result}


@value_node("ShaderNodeValToRGB")
def _color_ramp(node: NodeView) -> Outputs:
    ramp = node.node.color_ramp
    entries = np.array([ramp.evaluate(i / (RAMP_ENTRIES - 1)) for i in range(RAMP_ENTRIES)], np.float32)
    start, count = node.compiler.builder.table(np.nan_to_num(entries))
    smooth = "OFF" if ramp.interpolation == "CONSTANT" else "ON"
    color = node.emit("ramp", node.input("Fac"), immediates=(start, count, smooth))
    return {"Color": color, "Alpha": color + 1}


@value_node("ShaderNodeSeparateXYZ")
def _separate_xyz(node: NodeView) -> Outputs:
    vector = node.input("Vector")
    return {name: node.emit("channel", vector, immediates=(name,)) for name in "XYZ"}


@value_node("ShaderNodeCombineXYZ")
def _combine_xyz(node: NodeView) -> Outputs:
    return {"Vector": node.emit("combine", *map(node.input, "XYZ"))}


@value_node("ShaderNodeSeparateColor")
def _separate_color(node: NodeView) -> Outputs:
    if node.node.mode != "RGB":
        return {}
    color = node.input("Color")
    channels = {"Red": "X", "Green": "Y", "Blue": "Z"}
    return {name: node.emit("channel", color, immediates=(channel,)) for name, channel in channels.items()}


@value_node("ShaderNodeCombineColor")
def _combine_color(node: NodeView) -> Outputs:
    if node.node.mode != "RGB":
        return {}
    return {"Color": node.emit("combine", *map(node.input, ("Red", "Green", "Blue")))}
