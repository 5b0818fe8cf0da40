"""Textures made of numbers alone."""

from __future__ import annotations

from .compiler import NodeView, Outputs, value_node


def _vector(node: NodeView) -> int:
    return node.input("Vector", lambda: node.coordinate("GENERATED"))


def _switch(is_on: bool) -> str:
    return "ON" if is_on else "OFF"


@value_node("ShaderNodeTexNoise")
def _noise(node: NodeView) -> Outputs:
    settings = node.node
    names = ("W", "Scale", "Detail", "Roughness", "Lacunarity", "Offset", "Gain", "Distortion")
    is_colored = settings.outputs["Color"].is_linked  # it takes three times as long
    switches = (_switch(settings.normalize), _switch(is_colored))
    immediates = (settings.noise_dimensions, settings.noise_type, *switches)
    value = node.emit("noise", _vector(node), *map(node.input, names), immediates=immediates)
    return {"Fac": value, "Color": value + 1}


@value_node("ShaderNodeTexWhiteNoise")
def _white_noise(node: NodeView) -> Outputs:
    immediates = (node.node.noise_dimensions,)
    value = node.emit("white_noise", node.input("Vector"), node.input("W"), immediates=immediates)
    return {"Value": value, "Color": value + 1}


@value_node("ShaderNodeTexGabor")
def _gabor(node: NodeView) -> Outputs:
    names = ("Scale", "Frequency", "Anisotropy", "Orientation 2D", "Orientation 3D")
    value = node.emit("gabor", _vector(node), *map(node.input, names), immediates=(node.node.gabor_type,))
    return {"Value": value, "Phase": value + 1, "Intensity": value + 2}


@value_node("ShaderNodeTexVoronoi")
def _voronoi(node: NodeView) -> Outputs:
    settings = node.node
    names = ("W", "Scale", "Detail", "Roughness", "Lacunarity", "Smoothness", "Exponent", "Randomness")
    switches = (_switch(settings.normalize), _switch(node.compiler.version < (5, 0)))
    kinds = (settings.voronoi_dimensions, settings.feature, settings.distance, *switches)
    distance = node.emit("voronoi", _vector(node), *map(node.input, names), immediates=kinds)
    outputs = {name: distance + i for i, name in enumerate(("Distance", "Color", "Position", "W"))}
    return outputs | {"Radius": distance}


@value_node("ShaderNodeTexGradient")
def _gradient(node: NodeView) -> Outputs:
    value = node.emit("gradient", _vector(node), immediates=(node.node.gradient_type,))
    return {"Color": value, "Fac": value}


@value_node("ShaderNodeTexMagic")
def _magic(node: NodeView) -> Outputs:
    operands = (_vector(node), node.input("Scale"), node.input("Distortion"))
    color = node.emit("magic", *operands, immediates=(str(node.node.turbulence_depth),))
    return {"Color": color, "Fac": color + 1}


@value_node("ShaderNodeTexWave")
def _wave(node: NodeView) -> Outputs:
    settings = node.node
    names = ("Scale", "Distortion", "Detail", "Detail Scale", "Detail Roughness", "Phase Offset")
    direction = settings.bands_direction if settings.wave_type == "BANDS" else settings.rings_direction
    kinds = (settings.wave_type, direction, settings.wave_profile)
    value = node.emit("wave", _vector(node), *map(node.input, names), immediates=kinds)
    return {"Color": value, "Fac": value}


@value_node("ShaderNodeTexBrick")
def _brick(node: NodeView) -> Outputs:
    settings = node.node
    names = (
        *("Color1", "Color2", "Mortar", "Scale", "Mortar Size", "Mortar Smooth", "Bias"),
        *("Brick Width", "Row Height"),
    )
    pattern = (settings.offset, settings.offset_frequency, settings.squash, settings.squash_frequency)
    color = node.emit("brick", _vector(node), *map(node.input, names), *map(node.constant, pattern))
    return {"Color": color, "Fac": color + 1}
