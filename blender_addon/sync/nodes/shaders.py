"""Nodes with a shader output."""

from __future__ import annotations

from .compiler import NodeView, shader_node
from .film import emit_film

STARS_MARK = "bentlight_stars"
"""Property of the node that shows a world's stars in Cycles; the core draws them itself."""


@shader_node("ShaderNodeBsdfPrincipled")
def _principled(node: NodeView, weight: int) -> None:
    names = (
        *("Base Color", "Metallic", "Roughness", "Diffuse Roughness", "IOR", "Specular IOR Level", "Specular Tint"),
        *("Transmission Weight", "Alpha", "Normal", "Emission Color", "Emission Strength"),
    )
    operands = [node.normal() if name == "Normal" else node.input(name) for name in names]
    operands += _stretch(node, "Anisotropic", "Anisotropic Rotation")
    if not node.is_default("Sheen Weight", 0.0):
        node.emit("sheen_layer", *[node.input(f"Sheen {name}") for name in ("Weight", "Roughness", "Tint")])
    if not node.is_default("Coat Weight", 0.0):
        coat = [node.input(f"Coat {name}") for name in ("Weight", "Roughness", "IOR", "Tint")]
        node.emit("coat_layer", *coat, node.normal("Coat Normal"))
    if not node.is_default("Subsurface Weight", 0.0):
        below = [node.input(f"Subsurface {name}") for name in ("Weight", "Radius", "Scale", "IOR", "Anisotropy")]
        node.emit("subsurface_layer", *below, immediates=(_walk(node, node.node.subsurface_method),))
    emit_film(node)
    node.emit("principled", weight, *operands, immediates=(node.node.distribution,))


def _walk(node: NodeView, method: str) -> str:
    if method == "BURLEY":
        node.warn("Christensen-Burley is rendered as a random walk, with the same radius")
        return "RANDOM_WALK"
    return method


@shader_node("ShaderNodeSubsurfaceScattering")
def _subsurface(node: NodeView, weight: int) -> None:
    operands = [node.input(name) for name in ("Color", "Radius", "Scale", "IOR", "Roughness", "Anisotropy")]
    node.emit("subsurface", weight, *operands, node.normal(), immediates=(_walk(node, node.node.falloff),))


def _stretch(node: NodeView, anisotropy: str, rotation: str) -> list[int]:
    """The operands anisotropy, rotation and tangent: around the z axis of the object if no tangent is linked."""
    if node.is_default(anisotropy, 0.0):
        return [node.constant(0.0)] * 3
    return [node.input(anisotropy), node.input(rotation), node.input("Tangent", lambda: node.coordinate("TANGENT"))]


@shader_node("ShaderNodeBsdfDiffuse")
def _diffuse(node: NodeView, weight: int) -> None:
    node.emit("diffuse", weight, node.input("Color"), node.input("Roughness"), node.normal())


@shader_node("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")
def _glossy(node: NodeView, weight: int) -> None:
    operands = (node.input("Color"), node.input("Roughness"), node.normal())
    stretch = _stretch(node, "Anisotropy", "Rotation")
    node.emit("glossy", weight, *operands, *stretch, immediates=(node.node.distribution,))


@shader_node("ShaderNodeBsdfMetallic")
def _metallic(node: NodeView, weight: int) -> None:
    model = node.node.fresnel_type
    colors = ("Base Color", "Edge Tint") if model == "F82" else ("IOR", "Extinction")
    operands = (*map(node.input, colors), node.input("Roughness"), node.normal())
    stretch = _stretch(node, "Anisotropy", "Rotation")
    emit_film(node)
    node.emit("metallic", weight, *operands, *stretch, immediates=(node.node.distribution, model))


@shader_node("ShaderNodeBsdfGlass")
def _glass(node: NodeView, weight: int) -> None:
    operands = (node.input("Color"), node.input("Roughness"), node.input("IOR"), node.normal())
    emit_film(node)
    node.emit("glass", weight, *operands, immediates=(node.node.distribution,))


@shader_node("ShaderNodeBsdfRefraction")
def _refraction(node: NodeView, weight: int) -> None:
    operands = (*map(node.input, ("Color", "Roughness", "IOR")), node.normal())
    node.emit("refraction", weight, *operands, immediates=(node.node.distribution,))


@shader_node("ShaderNodeBsdfTranslucent")
def _translucent(node: NodeView, weight: int) -> None:
    node.emit("translucent", weight, node.input("Color"), node.normal())


@shader_node("ShaderNodeBsdfSheen")
def _sheen(node: NodeView, weight: int) -> None:
    operands = (node.input("Color"), node.input("Roughness"), node.normal())
    node.emit("sheen", weight, *operands, immediates=(node.node.distribution,))


@shader_node("ShaderNodeHoldout")
def _holdout(node: NodeView, weight: int) -> None:
    node.emit("holdout", weight)


@shader_node("ShaderNodeBsdfTransparent")
def _transparent(node: NodeView, weight: int) -> None:
    node.emit("transparent", weight, node.input("Color"))


@shader_node("ShaderNodeEmission", "ShaderNodeBackground")
def _emission(node: NodeView, weight: int) -> None:
    node.emit("emission", weight, node.input("Color"), node.input("Strength"))


@shader_node("ShaderNodeMixShader")
def _mix_shader(node: NodeView, weight: int) -> None:
    factor = node.emit("clamp", node.input("Fac"))
    rest = node.emit("math", node.constant(1.0), factor, node.constant(0.0), immediates=("SUBTRACT",))
    node.shade("Shader", node.emit("multiply", weight, rest))
    node.shade("Shader_001", node.emit("multiply", weight, factor))


@shader_node("ShaderNodeScript")
def _script(node: NodeView, weight: int) -> None:
    if STARS_MARK not in node.node:
        node.unsupported(weight)


@shader_node("ShaderNodeAddShader")
def _add_shader(node: NodeView, weight: int) -> None:
    node.shade("Shader", weight)
    node.shade("Shader_001", weight)
