"""Nodes that tell about the point that is shaded: its geometry, its object, how it is looked at."""

from __future__ import annotations

from .compiler import NodeView, Outputs, value_node

_FIRST_PARTICLE = 0.8603127584467439  # the random number of particle 0, by Bob Jenkins' hash
_DEPTHS = ("Diffuse Depth", "Glossy Depth", "Transparent Depth", "Transmission Depth")


@value_node("ShaderNodeNewGeometry")
def _geometry(node: NodeView) -> Outputs:
    kinds = {"Normal": "SHADING_NORMAL"} | {
        name: name.upper().replace(" ", "_")
        for name in ("Position", "Tangent", "True Normal", "Incoming", "Parametric", "Backfacing")
    }
    derived = {"Pointiness": "POINTINESS", "Random Per Island": "ISLAND"}
    outputs = {name: node.attribute(kind) for name, kind in derived.items() if name in _linked(node)}
    return outputs | _linked_coordinates(node, kinds)


@value_node("ShaderNodeTangent")
def _tangent(node: NodeView) -> Outputs:
    settings = node.node
    if settings.direction_type == "UV_MAP":
        return {"Tangent": node.emit("tangent", node.attribute("TANGENT", settings.uv_map))}
    middle = node.emit("vector_math", node.coordinate("GENERATED"), *[node.constant(0.5)] * 3, immediates=("SUBTRACT",))
    axis = node.constant([float(settings.axis == name) for name in "XYZ"])
    around = node.emit("vector_math", axis, middle, axis, axis, immediates=("CROSS_PRODUCT",))
    if settings.axis == "Y":  # which Cycles goes around the other way
        around = node.emit("multiply", around, node.constant(-1.0))
    return {"Tangent": node.emit("tangent", around)}


@value_node("ShaderNodeObjectInfo")
def _object_info(node: NodeView) -> Outputs:
    names = ("Location", "Color", "Alpha", "Random")
    kinds = {name: f"OBJECT_{name.upper()}" for name in names} | {"Object Index": "OBJECT_INDEX"}
    return _linked_coordinates(node, kinds) | {"Material Index": node.constant(node.compiler.material_index)}


@value_node("ShaderNodeAttribute")
def _attribute(node: NodeView) -> Outputs:
    settings = node.node
    if settings.attribute_name in node.compiler.given:
        number = node.compiler.given[settings.attribute_name]
        return {"Color": number, "Vector": number, "Fac": number, "Alpha": node.constant(1.0)}
    vector = node.attribute(settings.attribute_type, settings.attribute_name)
    return {"Color": vector, "Vector": vector, "Fac": vector + 1, "Alpha": vector + 2}


@value_node("ShaderNodeVertexColor")
def _color_attribute(node: NodeView) -> Outputs:
    color = node.attribute("COLOR", node.node.layer_name)
    return {"Color": color, "Alpha": color + 2}


@value_node("ShaderNodeLightPath")
def _light_path(node: NodeView) -> Outputs:
    """As Cycles counts; without volumes and ray portals there is nothing to tell of them."""
    names = [
        f"Is {kind} Ray" for kind in ("Camera", "Shadow", "Diffuse", "Glossy", "Singular", "Reflection", "Transmission")
    ]
    kinds = {name: name.upper()[:-4].replace(" ", "_") for name in names}
    kinds |= {name: name.upper().replace(" ", "_") for name in ("Ray Depth", *_DEPTHS)}
    linked = _linked(node)
    outputs = {name: node.emit("light_path", immediates=(kind,)) for name, kind in kinds.items() if name in linked}
    outputs |= {name: node.constant(0.0) for name in ("Is Volume Scatter Ray", "Portal Depth")}
    return outputs | _linked_coordinates(node, {"Ray Length": "RAY_LENGTH"})


@value_node("ShaderNodeFresnel")
def _fresnel(node: NodeView) -> Outputs:
    return {"Fac": node.emit("fresnel", node.input("IOR"), node.normal())}


@value_node("ShaderNodeLayerWeight")
def _layer_weight(node: NodeView) -> Outputs:
    fresnel = node.emit("layer_weight", node.input("Blend"), node.normal())
    return {"Fresnel": fresnel, "Facing": fresnel + 1}


@value_node("ShaderNodeLightFalloff")
def _light_falloff(node: NodeView) -> Outputs:
    quadratic = node.emit("light_falloff", node.input("Strength"), node.input("Smooth"))
    return {"Quadratic": quadratic, "Linear": quadratic + 1, "Constant": quadratic + 2}


@value_node("ShaderNodeAmbientOcclusion")
def _ambient_occlusion(node: NodeView) -> Outputs:
    settings = node.node
    switches = ("ON" if on else "OFF" for on in (settings.inside, settings.only_local))
    operands = (node.normal(), node.input("Distance"))
    is_open = node.emit("occlusion", *operands, immediates=(settings.samples, *switches))
    return {"Color": node.emit("multiply", node.input("Color"), is_open), "AO": is_open}


@value_node("ShaderNodeBevel")
def _bevel(node: NodeView) -> Outputs:
    node.warn("'Bevel' is not supported; edges stay sharp")
    return {"Normal": node.normal()}


@value_node("ShaderNodeParticleInfo", "ShaderNodeHairInfo", "ShaderNodePointInfo", "ShaderNodeVolumeInfo")
def _of_other_primitives(node: NodeView) -> Outputs:
    """What they are on the surface of a mesh."""
    outputs = {socket.identifier: node.constant(0.0) for socket in node.node.outputs}
    return outputs | ({"Random": node.constant(_FIRST_PARTICLE)} if "Lifetime" in outputs else {})


def _linked_coordinates(node: NodeView, kinds: dict[str, str]) -> Outputs:
    """A coordinate for each output, by identifier, that is linked."""
    linked = _linked(node)
    return {name: node.coordinate(kind) for name, kind in kinds.items() if name in linked}


def _linked(node: NodeView) -> set[str]:
    """The identifiers of the outputs that are linked."""
    return {socket.identifier for socket in node.node.outputs if socket.is_linked}
