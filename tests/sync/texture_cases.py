"""More cases for value_cases: textures made of numbers alone, with all their modes."""

import itertools

import bpy
import numpy as np
from value_cases import CASES, case, color, new, parts, uv


def choices(kind, setting):
    """The values that a setting of a node can have."""
    return getattr(bpy.types, f"ShaderNode{kind}").bl_rna.properties[setting].enum_items.keys()


DIMENSIONS = choices("TexNoise", "noise_dimensions")


def numbered(node, values):
    """Sets inputs by identifier, also those that the mode of the node hides."""
    for socket in node.inputs:
        value = values.get(socket.identifier)
        if isinstance(value, bpy.types.NodeSocket):
            node.id_data.links.new(value, socket)
        elif value is not None:
            socket.default_value = value
    return node


def place(tree):
    """Vector and w that vary."""
    return {"Vector": color(tree), "W": parts(tree)[2]}


def _add_noise(name, output=1, inputs=(), **settings):
    def build(tree):
        values = place(tree) | {"Scale": 2.3, "Detail": 2.6, "Roughness": 0.55, "Lacunarity": 2.1}
        values |= {"Offset": 0.4, "Gain": 1.7} | dict(inputs)
        return numbered(new(tree, "TexNoise", **settings), values).outputs[output]

    CASES[f"noise_{name}"] = build


for dimensions in DIMENSIONS:
    for kind in choices("TexNoise", "noise_type"):
        _add_noise(f"{dimensions}_{kind}", noise_dimensions=dimensions, noise_type=kind)
    options = {"noise_dimensions": dimensions}
    _add_noise(f"{dimensions}_value", output=0, **options)
    _add_noise(f"{dimensions}_distorted", inputs={"Distortion": 0.8}, **options)
    _add_noise(f"{dimensions}_free", normalize=False, **options)
    _add_noise(f"{dimensions}_whole_octaves", inputs={"Detail": 3.0}, **options)
for kind in choices("TexNoise", "noise_type"):
    for detail in (0.0, 0.4):
        _add_noise(f"one_octave_{kind}_{detail}", inputs={"Detail": detail}, noise_type=kind)
_add_noise("out_of_range", inputs={"Detail": 20.0, "Roughness": -0.5, "Lacunarity": 1.1})


@case
def noise_far_away(tree):
    far = new(tree, "VectorMath", {0: uv(tree), 1: (1e6, 3e6, -2e7)}, operation="MULTIPLY")
    return new(tree, "TexNoise", {"Vector": far.outputs[0], "Scale": 1.0, "Detail": 0.0}).outputs[1]


@case
def noise_varying(tree):
    u, v, w = parts(tree)
    inputs = {"Vector": color(tree), "Scale": u, "Detail": v, "Roughness": w, "Distortion": u}
    return new(tree, "TexNoise", inputs).outputs[0]


def _add_white_noise(dimensions):
    def build(tree):
        values = {"Vector": uv(tree), "W": new(tree, "SeparateXYZ", {0: uv(tree)}).outputs[0]}
        return numbered(new(tree, "TexWhiteNoise", noise_dimensions=dimensions), values).outputs[1]

    def build_value(tree):
        values = {"Vector": uv(tree), "W": new(tree, "SeparateXYZ", {0: uv(tree)}).outputs[1]}
        return numbered(new(tree, "TexWhiteNoise", noise_dimensions=dimensions), values).outputs[0]

    CASES[f"white_noise_{dimensions}"] = build
    CASES[f"white_noise_{dimensions}_value"] = build_value


for dimensions in DIMENSIONS:
    _add_white_noise(dimensions)


def _add_gabor(kind, output, anisotropy):
    def build(tree):
        values = {"Vector": color(tree), "Scale": 3.1, "Frequency": 1.7, "Anisotropy": anisotropy}
        values |= {"Orientation 2D": parts(tree)[0], "Orientation 3D": (0.3, -0.8, 0.4)}
        return numbered(new(tree, "TexGabor", gabor_type=kind), values).outputs[output]

    CASES[f"gabor_{kind}_{output}_{anisotropy}"] = build


for kind, output, anisotropy in itertools.product(choices("TexGabor", "gabor_type"), range(3), (1.0, 0.4)):
    _add_gabor(kind, output, anisotropy)

# Horizontal angles; whatever the file gives of the circle, it is mirrored to the whole.
LUMINAIRES = {"symmetric": (0,), "quadrant": (0, 30, 90), "half": (0, 90, 120, 180), "open": (0, 90, 180, 270)}
LUMINAIRES |= {"turned": (90, 180, 270)}
VERTICALS = (0, 20, 45, 90, 100, 180)


def ies_text(horizontals, verticals=VERTICALS):
    """A file of type C whose values are all different."""
    rows = [[round(300 + 200 * np.sin(7 * h + 3 * v), 1) for v in verticals] for h in horizontals]
    numbers = [1, -1, 2.5, len(verticals), len(horizontals), 1, 2, 0, 0, 0, 0.9, 1.1, 60, *verticals, *horizontals]
    return "IESNA:LM-63-2002\n[TEST] a\nTILT=NONE\n" + " ".join(map(str, [*numbers, *itertools.chain(*rows)]))


def _add_ies(name, horizontals, verticals=VERTICALS):
    def build(tree):
        text = bpy.data.texts.new(name)
        text.from_string(ies_text(horizontals, verticals))
        vector = new(tree, "VectorMath", {0: color(tree), 1: (0.5, 0.4, 0.6)}, operation="SUBTRACT").outputs[0]
        node = new(tree, "TexIES", {"Vector": vector, "Strength": 0.02}, mode="INTERNAL")
        node.ies = text
        return node.outputs[0]

    CASES[f"ies_{name}"] = build


if bpy.app.version >= (5, 0, 0):  # before, Cycles took what is beyond the first and last angles for dark
    for name, horizontals in LUMINAIRES.items():
        _add_ies(name, horizontals)
    _add_ies("uneven", (0, 90, 360))
    _add_ies("downwards", (0, 360), (0, 30, 60, 90))


def _add_voronoi(name, output, inputs=(), **settings):
    def build(tree):
        values = place(tree) | {"Scale": 1.7, "Smoothness": 0.8, "Exponent": 1.4, "Randomness": 0.9} | dict(inputs)
        node = numbered(new(tree, "TexVoronoi", **settings), values)
        return next(socket for socket in node.outputs if socket.identifier == output)

    CASES[f"voronoi_{name}"] = build


OCTAVES = {"Detail": 1.6, "Roughness": 0.6, "Lacunarity": 1.9}
METRICS = choices("TexVoronoi", "distance")
for dimensions in DIMENSIONS:
    place_output = "W" if dimensions == "1D" else "Position"
    for feature in ("F1", "F2", "SMOOTH_F1"):
        for metric, is_normal in itertools.product(METRICS, (False, True)):
            settings = {"feature": feature, "distance": metric, "normalize": is_normal}
            name = f"{dimensions}_{feature}_{metric}_{'normal' if is_normal else 'free'}"
            _add_voronoi(name, "Distance", OCTAVES if is_normal else {}, voronoi_dimensions=dimensions, **settings)
        options = {"feature": feature, "voronoi_dimensions": dimensions}
        for inputs, suffix in (({}, ""), (OCTAVES, "_octaves")):
            _add_voronoi(f"{dimensions}_{feature}_color{suffix}", "Color", inputs, **options)
            _add_voronoi(f"{dimensions}_{feature}_position{suffix}", place_output, inputs, **options)
        _add_voronoi(f"{dimensions}_{feature}_color_normal", "Color", OCTAVES, normalize=True, **options)
    for is_normal in (False, True):
        options = {"feature": "DISTANCE_TO_EDGE", "voronoi_dimensions": dimensions, "normalize": is_normal}
        _add_voronoi(f"{dimensions}_edge_{is_normal}", "Distance", **options)
        _add_voronoi(f"{dimensions}_edge_octaves_{is_normal}", "Distance", OCTAVES, **options)
    _add_voronoi(f"{dimensions}_radius", "Radius", feature="N_SPHERE_RADIUS", voronoi_dimensions=dimensions)
_add_voronoi("4D_w", "W", OCTAVES, voronoi_dimensions="4D")
_add_voronoi("not_smooth", "Distance", {"Smoothness": 0.0}, feature="SMOOTH_F1")
_add_voronoi("regular", "Color", {"Randomness": 0.0, "Scale": 0.77})
_add_voronoi("no_scale", "Position", {"Scale": 0.0})


def _add_gradient(kind):
    def build(tree):
        return new(tree, "TexGradient", {0: color(tree)}, gradient_type=kind).outputs[0]

    CASES[f"gradient_{kind}"] = build


for kind in choices("TexGradient", "gradient_type"):
    _add_gradient(kind)


def _add_magic(depth):
    def build(tree):
        return new(tree, "TexMagic", {0: color(tree), 1: 0.4, 2: 1.3}, turbulence_depth=depth).outputs[0]

    CASES[f"magic_{depth}"] = build


for depth in range(11):
    _add_magic(depth)


@case
def magic_factor(tree):
    return new(tree, "TexMagic", {0: color(tree), 1: 0.7, 2: 0.0}).outputs[1]


def _add_wave(name, inputs=(), **settings):
    def build(tree):
        inputs_ = {"Vector": color(tree), "Scale": 0.3, "Phase Offset": 0.4} | dict(inputs)
        return new(tree, "TexWave", inputs_, **settings).outputs[0]

    CASES[f"wave_{name}"] = build


for kind, setting in (("BANDS", "bands_direction"), ("RINGS", "rings_direction")):
    for direction in choices("TexWave", setting):
        _add_wave(f"{kind}_{direction}", wave_type=kind, **{setting: direction})
for profile in choices("TexWave", "wave_profile"):
    details = {"Distortion": 1.2, "Detail": 1.5, "Detail Scale": 1.3, "Detail Roughness": 0.6}
    _add_wave(f"distorted_{profile}", details, wave_profile=profile)
    _add_wave(f"plain_{profile}", wave_profile=profile)


def _add_brick(name, inputs=(), output=0, **settings):
    def build(tree):
        colors = {1: (0.8, 0.1, 0.2, 1), 2: (0.1, 0.7, 0.9, 1), 3: (0.3, 0.4, 0.2, 1)}
        return new(tree, "TexBrick", {0: uv(tree)} | colors | dict(inputs), **settings).outputs[output]

    CASES[f"brick_{name}"] = build


_add_brick("default")
_add_brick("factor", {"Mortar Size": 0.1}, output=1)
_add_brick("sharp", {"Mortar Size": 0.08, "Mortar Smooth": 0.0, "Scale": 3.0})
_add_brick("smooth", {"Mortar Size": 0.12, "Mortar Smooth": 1.0, "Bias": -0.2})
_add_brick("half_smooth", {"Mortar Size": 0.12, "Mortar Smooth": 0.5, "Brick Width": 0.7, "Row Height": 0.4})
_add_brick("shifted", {"Bias": 0.3}, offset=0.3, offset_frequency=3, squash=0.6, squash_frequency=4)
_add_brick("in_line", offset_frequency=1, squash=1.7, squash_frequency=1)
