"""Nodes that make and change numbers and vectors."""

from __future__ import annotations

from .compiler import NodeView, Outputs, socket_value, value_node

_SCALARS = ("DOT_PRODUCT", "DISTANCE", "LENGTH")  # operations of Vector Math whose result is a number


@value_node("ShaderNodeRGB", "ShaderNodeValue")
def _constant(node: NodeView) -> Outputs:
    socket = node.node.outputs[0]
    return {socket.identifier: node.constant(socket_value(socket))}


@value_node("ShaderNodeMath")
def _math(node: NodeView) -> Outputs:
    operands = [node.input(name) for name in ("Value", "Value_001", "Value_002")]
    result = node.emit("math", *operands, immediates=(node.node.operation,))
    return {"Value": node.emit("clamp", result) if node.node.use_clamp else result}


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


@value_node("ShaderNodeSeparateXYZ")
def _separate_xyz(node: NodeView) -> Outputs:
    vector = node.input("Vector")
    return {name: node.emit("channel", vector, immediates=(name,)) for name in "XYZ"}


@value_node("ShaderNodeCombineXYZ")
def _combine_xyz(node: NodeView) -> Outputs:
    return {"Vector": node.emit("combine", *map(node.input, "XYZ"))}


@value_node("ShaderNodeVectorMath")
def _vector_math(node: NodeView) -> Outputs:
    operands = [node.input(name) for name in ("Vector", "Vector_001", "Vector_002", "Scale")]
    result = node.emit("vector_math", *operands, immediates=(node.node.operation,))
    return {"Value" if node.node.operation in _SCALARS else "Vector": result}


@value_node("ShaderNodeClamp")
def _clamp(node: NodeView) -> Outputs:
    operands = map(node.input, ("Value", "Min", "Max"))
    return {"Result": node.emit("clamp_between", *operands, immediates=(node.node.clamp_type,))}


@value_node("ShaderNodeMapRange")
def _map_range(node: NodeView) -> Outputs:
    settings = node.node
    is_vector = settings.data_type == "FLOAT_VECTOR"
    if is_vector:
        names = ("Vector", *(f"{name}_FLOAT3" for name in ("From_Min", "From_Max", "To_Min", "To_Max", "Steps")))
    else:
        names = ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
    operands = [node.input(name) for name in names]
    immediates = (settings.interpolation_type, "ON" if is_vector else "OFF")
    result = node.emit("map_range", *operands, immediates=immediates)
    if settings.clamp:
        result = node.emit("clamp_between", result, *operands[3:5], immediates=("RANGE",))
    return {"Vector" if is_vector else "Result": result}


@value_node("ShaderNodeNormal")
def _normal(node: NodeView) -> Outputs:
    direction = node.emit(
        "vector_math", *[node.constant(socket_value(node.node.outputs[0]))] * 4, immediates=("NORMALIZE",)
    )
    given = node.emit("vector_math", *[node.input("Normal")] * 4, immediates=("NORMALIZE",))
    return {"Normal": direction, "Dot": node.emit("dot", direction, given)}


@value_node("ShaderNodeVectorRotate")
def _vector_rotate(node: NodeView) -> Outputs:
    settings, zero, one = node.node, node.constant(0.0), node.constant(1.0)
    vector, center = node.input("Vector"), node.input("Center")
    if settings.rotation_type == "EULER_XYZ":
        kind = "TEXTURE" if settings.invert else "VECTOR"  # the first turns the other way
        moved = node.emit("vector_math", vector, center, zero, zero, immediates=("SUBTRACT",))
        turned = node.emit("mapping", moved, zero, node.input("Rotation"), one, immediates=(kind,))
        return {"Vector": node.emit("vector_math", turned, center, zero, zero, immediates=("ADD",))}
    axes = {"X_AXIS": (1.0, 0.0, 0.0), "Y_AXIS": (0.0, 1.0, 0.0), "Z_AXIS": (0.0, 0.0, 1.0)}
    axis = axes.get(settings.rotation_type)
    axis = node.input("Axis") if axis is None else node.constant(axis)
    angle = node.input("Angle")
    if settings.invert:
        angle = node.emit("math", zero, angle, zero, immediates=("SUBTRACT",))
    return {"Vector": node.emit("rotate", vector, center, axis, angle)}


@value_node("ShaderNodeVectorTransform")
def _vector_transform(node: NodeView) -> Outputs:
    settings, vector = node.node, node.input("Vector")
    spaces = (settings.convert_from, settings.convert_to)
    if "CAMERA" in spaces:
        node.warn("the camera's space is not supported yet; the vector is left as it is")
        return {"Vector": vector}
    return {"Vector": node.emit("change_space", vector, immediates=(settings.vector_type, *spaces))}
