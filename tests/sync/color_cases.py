"""More cases for value_cases: nodes that change numbers, vectors and colors, with all their modes."""

import bpy
from value_cases import CASES, case, color, new, parts

VECTOR_OPERATIONS = bpy.types.ShaderNodeVectorMath.bl_rna.properties["operation"].enum_items.keys()
INTERPOLATIONS = bpy.types.ShaderNodeMapRange.bl_rna.properties["interpolation_type"].enum_items.keys()
SCALARS = ("DOT_PRODUCT", "DISTANCE", "LENGTH")


def signed(tree):
    """A vector whose parts have either sign."""
    return new(tree, "Mapping", {0: color(tree), "Location": (-0.5, -0.3, 0.2), "Scale": (1, -0.7, 0.4)}).outputs[0]


def _add_vector_math(operation):
    def build(tree):
        inputs = {0: color(tree), 1: signed(tree), 2: (0.3, -0.6, 0.2), 3: 0.7}
        node = new(tree, "VectorMath", inputs, operation=operation)
        return node.outputs["Value" if operation in SCALARS else "Vector"]

    def build_zero(tree):
        node = new(tree, "VectorMath", {0: color(tree), 1: (0, 0, 0), 2: (0, 0, 0), 3: 1.3}, operation=operation)
        return node.outputs["Value" if operation in SCALARS else "Vector"]

    CASES[f"vector_math_{operation}"] = build
    CASES[f"vector_math_{operation}_zero"] = build_zero


for name in VECTOR_OPERATIONS:
    _add_vector_math(name)


@case
def vector_math_reflect_known_normal(tree):
    inputs = {0: color(tree), 1: (0, 0.3, 0.4)}
    return new(tree, "VectorMath", inputs, operation="REFLECT").outputs[0]


def _add_mix(name, is_clamped, **settings):
    a, b, out = {"FLOAT": (2, 3, 0), "VECTOR": (4, 5, 1), "RGBA": (6, 7, 2)}[settings["data_type"]]

    def build(tree):
        value = parts(tree)[1] if a == 2 else signed(tree)
        other = 0.4 if b == 3 else (0.1, 1.5, 0.7, 1)[: 3 if b == 5 else 4]
        node = new(tree, "Mix", {0: parts(tree)[0], a: value, b: other}, clamp_factor=is_clamped, **settings)
        return node.outputs[out]

    CASES[f"mix_{name}_{'clamped' if is_clamped else 'free'}"] = build


for clamped in (False, True):
    _add_mix("float", clamped, data_type="FLOAT")
    _add_mix("vector", clamped, data_type="VECTOR")
    _add_mix("color", clamped, data_type="RGBA")
    _add_mix("color_result", clamped, data_type="RGBA", clamp_result=True, blend_type="ADD")


def _add_map_range(interpolation, clamp):
    """Inputs: value, from minimum and maximum, to minimum and maximum, steps; from 6 on the same for vectors."""

    def build(tree):
        u, v, w = parts(tree)
        inputs = {0: u, 1: -0.7, 2: 0.9, 3: v, 4: w, 5: 3.5}
        return new(tree, "MapRange", inputs, interpolation_type=interpolation, clamp=clamp).outputs["Result"]

    def build_backward(tree):
        u, v, _ = parts(tree)
        inputs = {0: u, 1: 1.2, 2: v, 3: 2.0, 4: -0.5, 5: 2.0}
        return new(tree, "MapRange", inputs, interpolation_type=interpolation, clamp=clamp).outputs["Result"]

    def build_empty(tree):
        inputs = {0: parts(tree)[0], 1: 0.5, 2: 0.5, 3: 0.3, 4: 0.9, 5: 0.0}
        return new(tree, "MapRange", inputs, interpolation_type=interpolation, clamp=clamp).outputs["Result"]

    def build_vector(tree):
        inputs = {6: color(tree), 7: (-0.5, 0.8, 0.2), 8: (0.7, -0.4, 0.2)}
        inputs |= {9: signed(tree), 10: (2, 0.1, 0.5), 11: (3, 2.5, 0)}
        settings = {"interpolation_type": interpolation, "clamp": clamp, "data_type": "FLOAT_VECTOR"}
        return new(tree, "MapRange", inputs, **settings).outputs[1]

    suffix = f"{interpolation}_{'clamped' if clamp else 'free'}"
    CASES[f"map_range_{suffix}"] = build
    CASES[f"map_range_backward_{suffix}"] = build_backward
    CASES[f"map_range_empty_{suffix}"] = build_empty
    CASES[f"map_range_vector_{suffix}"] = build_vector


for name in INTERPOLATIONS:
    for clamped in (False, True):
        _add_map_range(name, clamped)


def _add_clamp(clamp_type):
    def build(tree):
        u, v, _ = parts(tree)
        return new(tree, "Clamp", {0: u, 1: 0.8, 2: v}, clamp_type=clamp_type).outputs[0]

    CASES[f"clamp_{clamp_type}"] = build


_add_clamp("MINMAX")
_add_clamp("RANGE")


def _add_color_model(mode):
    def build_separate(tree):
        node = new(tree, "SeparateColor", {0: color(tree)}, mode=mode)
        return new(tree, "CombineXYZ", dict(enumerate(node.outputs))).outputs[0]

    def build_combine(tree):
        return new(tree, "CombineColor", dict(enumerate(parts(tree))), mode=mode).outputs[0]

    def build_both(tree):
        node = new(tree, "SeparateColor", {0: new(tree, "Clamp", {0: parts(tree)[0]}).outputs[0]}, mode=mode)
        gray = new(tree, "CombineColor", dict(enumerate(node.outputs)), mode=mode)
        return gray.outputs[0]

    CASES[f"separate_color_{mode}"] = build_separate
    CASES[f"combine_color_{mode}"] = build_combine
    CASES[f"color_{mode}_of_gray"] = build_both


for name in ("RGB", "HSV", "HSL"):
    _add_color_model(name)


def _add_old_color_model(mode):
    def build(tree):
        node = new(tree, f"Separate{mode}", {0: color(tree)})
        inputs = {0: node.outputs[1], 1: node.outputs[0], 2: node.outputs[2]}
        return new(tree, f"Combine{mode}", inputs).outputs[0]

    CASES[f"old_color_{mode}"] = build


if hasattr(bpy.types, "ShaderNodeSeparateRGB"):  # up to Blender 4.5
    _add_old_color_model("RGB")
    _add_old_color_model("HSV")


@case
def separate_xyz(tree):
    split = new(tree, "SeparateXYZ", {0: color(tree)})
    return new(tree, "CombineXYZ", {0: split.outputs[2], 1: split.outputs[0], 2: split.outputs[1]}).outputs[0]


@case
def rgb_to_bw(tree):
    return new(tree, "RGBToBW", {0: color(tree)}).outputs[0]


@case
def gamma(tree):
    return new(tree, "Gamma", {0: color(tree), 1: 2.2}).outputs[0]


@case
def gamma_varying(tree):
    return new(tree, "Gamma", {0: (0.2, 0.5, 1.7, 1), 1: parts(tree)[0]}).outputs[0]


@case
def gamma_zero(tree):
    return new(tree, "Gamma", {0: color(tree), 1: 0.0}).outputs[0]


@case
def invert(tree):
    return new(tree, "Invert", {0: 1.0, 1: color(tree)}).outputs[0]


@case
def invert_in_part(tree):
    return new(tree, "Invert", {0: parts(tree)[1], 1: color(tree)}).outputs[0]


@case
def brightness_contrast(tree):
    return new(tree, "BrightContrast", {0: color(tree), 1: 0.2, 2: 0.6}).outputs[0]


@case
def brightness_contrast_varying(tree):
    u, v, _ = parts(tree)
    return new(tree, "BrightContrast", {0: (0.9, 0.2, 0.6, 1), 1: u, 2: v}).outputs[0]


@case
def hue_saturation(tree):
    inputs = {"Hue": 0.7, "Saturation": 1.4, "Value": 0.8, "Fac": 0.9, "Color": color(tree)}
    return new(tree, "HueSaturation", inputs).outputs[0]


@case
def hue_saturation_varying(tree):
    u, v, w = parts(tree)
    inputs = {"Hue": u, "Saturation": v, "Value": w, "Fac": 1.0, "Color": (0.9, 0.3, 0.5, 1)}
    return new(tree, "HueSaturation", inputs).outputs[0]


@case
def hue_saturation_factor(tree):
    inputs = {"Hue": 0.1, "Saturation": 2.0, "Value": 1.3, "Fac": parts(tree)[0], "Color": (0.4, 0.8, 0.5, 1)}
    return new(tree, "HueSaturation", inputs).outputs[0]


@case
def blackbody(tree):
    """From below the coolest color, over all parts of the fit, to above the hottest."""
    inputs = {"Value": parts(tree)[0], "From Min": -1.6, "From Max": 2.6, "To Min": -300.0, "To Max": 14000.0}
    return new(tree, "Blackbody", {0: new(tree, "MapRange", inputs).outputs[0]}).outputs[0]


@case
def blackbody_cool(tree):
    inputs = {"Value": parts(tree)[0], "From Min": -1.6, "From Max": 2.6, "To Min": 700.0, "To Max": 2500.0}
    return new(tree, "Blackbody", {0: new(tree, "MapRange", inputs).outputs[0]}).outputs[0]


def bend(curve, *points, handle="AUTO"):
    """Gives a curve these points between its ends, whose height is moved to the first and last of them."""
    curve.points[0].location, curve.points[-1].location = points[0], points[-1]
    for x, y in points[1:-1]:
        curve.points.new(x, y).handle_type = handle


def _add_curves(extend):
    def build_rgb(tree):
        node = new(tree, "RGBCurve", {0: 0.8, 1: color(tree)})
        bend(node.mapping.curves[0], (0, 0.1), (0.4, 0.7), (1, 0.8))
        bend(node.mapping.curves[1], (-0.3, 0.2), (0.5, 0.3), (1.4, 1.2), handle="VECTOR")
        bend(node.mapping.curves[3], (0, 0), (0.3, 0.5), (1, 0.9), handle="AUTO_CLAMPED")
        node.mapping.extend = extend
        return node.outputs[0]

    def build_rgb_factor(tree):
        node = new(tree, "RGBCurve", {0: parts(tree)[0], 1: (0.2, 0.5, 0.9, 1)})
        bend(node.mapping.curves[3], (0, 0.3), (0.6, 0.2), (1, 1))
        node.mapping.extend = extend
        return node.outputs[0]

    def build_vector(tree):
        node = new(tree, "VectorCurve", {0: 0.7, 1: color(tree)})
        for curve, height in zip(node.mapping.curves, (0.4, -0.3, 0.9), strict=True):
            bend(curve, (-1, -0.8), (0.2, height), (1, 0.6))
        node.mapping.extend = extend
        return node.outputs[0]

    def build_float(tree):
        node = new(tree, "FloatCurve", {0: 0.9, 1: parts(tree)[0]})
        bend(node.mapping.curves[0], (0, 0.2), (0.25, 0.9), (0.7, 0.1), (1, 0.5))
        node.mapping.extend = extend
        return node.outputs[0]

    CASES[f"rgb_curves_{extend}"] = build_rgb
    CASES[f"rgb_curves_factor_{extend}"] = build_rgb_factor
    CASES[f"vector_curves_{extend}"] = build_vector
    CASES[f"float_curve_{extend}"] = build_float


_add_curves("HORIZONTAL")
_add_curves("EXTRAPOLATED")
