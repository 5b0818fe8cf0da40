"""Nodes that tell about the point that is shaded: its geometry, its object, how it is looked at."""

from __future__ import annotations

from .compiler import NodeView, Outputs, value_node


@value_node("ShaderNodeNewGeometry")
def _geometry(node: NodeView) -> Outputs:
    kinds = {"Normal": "SHADING_NORMAL"} | {
        name: name.upper().replace(" ", "_")
        for name in ("Position", "Tangent", "True Normal", "Incoming", "Parametric", "Backfacing")
    }
    return _linked_coordinates(node, kinds)


@value_node("ShaderNodeObjectInfo")
def _object_info(node: NodeView) -> Outputs:
    names = ("Location", "Color", "Alpha", "Random")
    kinds = {name: f"OBJECT_{name.upper()}" for name in names} | {"Object Index": "OBJECT_INDEX"}
    return _linked_coordinates(node, kinds) | {"Material Index": node.constant(node.compiler.material_index)}


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


def _linked_coordinates(node: NodeView, kinds: dict[str, str]) -> Outputs:
    """A coordinate for each output, by identifier, that is linked."""
    linked = {socket.identifier for socket in node.node.outputs if socket.is_linked}
    return {name: node.coordinate(kind) for name, kind in kinds.items() if name in linked}
