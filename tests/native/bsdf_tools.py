"""Materials of one closure each, and integrals over the sphere, for the tests of BSDFs."""

from dataclasses import dataclass

import numpy as np
from bentlight_native import ProgramBuilder, Scene

SCENE = Scene()
NORMAL = object()  # stands for the shading normal among the operands

PRINCIPLED = {
    "base_color": (0.8, 0.8, 0.8),
    "metallic": 0.0,
    "roughness": 0.5,
    "diffuse_roughness": 0.0,
    "ior": 1.5,
    "specular_level": 0.5,
    "specular_tint": (1.0, 1.0, 1.0),
    "transmission": 0.0,
    "alpha": 1.0,
    "normal": NORMAL,
    "emission_color": (1.0, 1.0, 1.0),
    "emission_strength": 0.0,
    "anisotropy": 0.0,
    "rotation": 0.0,
    "tangent": (1.0, 0.0, 0.0),
}
# Layers are operations of their own before the Principled BSDF, where one of their settings is given.
LAYERS = {
    "sheen_layer": {"sheen_weight": 0.0, "sheen_roughness": 0.5, "sheen_tint": (1.0, 1.0, 1.0)},
    "coat_layer": {
        "coat_weight": 0.0,
        "coat_roughness": 0.03,
        "coat_ior": 1.5,
        "coat_tint": (1.0, 1.0, 1.0),
        "coat_normal": NORMAL,
    },
    "subsurface_layer": {
        "subsurface_weight": 0.0,
        "subsurface_radius": (1.0, 0.2, 0.1),
        "subsurface_scale": 0.05,
        "subsurface_ior": 1.4,
        "subsurface_anisotropy": 0.0,
    },
}


def material(*closures, scene=SCENE):
    """Adds a material: closures are (operation, operands after the weight, immediates, weight), and perhaps layers of
    (operation, operands, immediates) before it. Immediates are a tuple, the only one, or None."""
    builder = ProgramBuilder()
    normal = builder.emit("coordinate", immediates=("SHADING_NORMAL",))[0]

    def emit(operation, operands, immediates):
        if isinstance(immediates, np.ndarray):
            immediates = builder.table(immediates)
        numbers = [normal if value is NORMAL else builder.constant(value) for value in operands]
        builder.emit(operation, *numbers, immediates=immediates_of(immediates))

    for operation, operands, immediates, weight, *layers in closures:
        for layer in layers:
            emit(*layer)
        emit(operation, (weight, *operands), immediates)
    return scene.add_material(builder.build())


def immediates_of(value):
    return value if isinstance(value, tuple) else () if value is None else (value,)


def diffuse(color=1.0, roughness=0.0, normal=NORMAL, weight=1.0):
    return ("diffuse", (color, roughness, normal), None, weight)


def glossy(color=1.0, roughness=0.5, normal=NORMAL, distribution="MULTI_GGX", weight=1.0, anisotropy=0.0, rotation=0.0):
    return ("glossy", (color, roughness, normal, anisotropy, rotation, (1.0, 0.0, 0.0)), distribution, weight)


def glass(color=1.0, roughness=0.0, ior=1.5, normal=NORMAL, distribution="MULTI_GGX", weight=1.0):
    return ("glass", (color, roughness, ior, normal), distribution, weight)


def refraction(color=1.0, roughness=0.0, ior=1.5, normal=NORMAL, distribution="GGX", weight=1.0):
    return ("refraction", (color, roughness, ior, normal), distribution, weight)


def translucent(color=1.0, normal=NORMAL, weight=1.0):
    return ("translucent", (color, normal), None, weight)


def metallic(
    color=1.0,
    edge=1.0,
    roughness=0.5,
    normal=NORMAL,
    anisotropy=0.0,
    rotation=0.0,
    physical=False,
    distribution="MULTI_GGX",
    weight=1.0,
):
    operands = (color, edge, roughness, normal, anisotropy, rotation, (1.0, 0.0, 0.0))
    return ("metallic", operands, (distribution, "PHYSICAL_CONDUCTOR" if physical else "F82"), weight)


def sheen(color=1.0, roughness=0.5, normal=NORMAL, distribution="MICROFIBER", weight=1.0):
    return ("sheen", (color, roughness, normal), distribution, weight)


def transparent(color=1.0, weight=1.0):
    return ("transparent", (color,), None, weight)


# The sensitivity that tests of films use: one wavelength of 500 nm for all channels, which is seen at any way.
FILM_WAVELENGTH_NM, FILM_ENTRIES = 500.0, 20_000


def film_table(reach):
    phase = 2 * np.pi * np.linspace(0, reach, FILM_ENTRIES) / FILM_WAVELENGTH_NM
    rows = np.zeros((FILM_ENTRIES, 2, 4), np.float32)
    rows[:, 0, :3], rows[:, 1, :3] = np.cos(phase)[:, None], -np.sin(phase)[:, None]
    return rows.reshape(-1, 4)


def under_film(closure, thickness, ior=1.33):
    """A closure of bsdf_tools with a film on it."""
    return (*closure, ("film", (thickness, ior, 1.0, 9000.0), film_table(9000.0)))


def subsurface(
    color=1.0, radius=1.0, ior=1.4, alpha=1.0, anisotropy=0.0, method="RANDOM_WALK", normal=NORMAL, weight=1.0
):
    return ("subsurface", (color, radius, 1.0, ior, alpha, anisotropy, normal), method, weight)


def principled(distribution="MULTI_GGX", weight=1.0, method="RANDOM_WALK", **settings):
    layers = []
    for operation, defaults in LAYERS.items():
        given = {name: settings.pop(name) for name in defaults if name in settings}
        if given:
            immediates = method if operation == "subsurface_layer" else None
            layers.append((operation, tuple((defaults | given).values()), immediates))
    assert set(settings) <= set(PRINCIPLED), settings
    return ("principled", tuple((PRINCIPLED | settings).values()), distribution, weight, *layers)


def direction(cos_theta, phi=0.0):
    """Unit vector at an angle to +z."""
    sine = np.sqrt(1 - cos_theta**2)
    return np.stack(np.broadcast_arrays(sine * np.cos(phi), sine * np.sin(phi), cos_theta), axis=-1)


@dataclass
class Grid:
    """Cells of equal solid angle over the sphere, each with `fine` x `fine` midpoints."""

    rows: int = 16
    columns: int = 24
    fine: int = 24

    @property
    def cell(self):
        return 4 * np.pi / (self.rows * self.columns)

    def directions(self):
        """(rows, columns, fine^2, 3)"""
        z = (np.arange(self.rows * self.fine) + 0.5) / (self.rows * self.fine) * 2 - 1
        phi = (np.arange(self.columns * self.fine) + 0.5) / (self.columns * self.fine) * 2 * np.pi
        all_directions = direction(z[:, None], phi[None, :])
        split = all_directions.reshape(self.rows, self.fine, self.columns, self.fine, 3)
        return split.transpose(0, 2, 1, 3, 4).reshape(self.rows, self.columns, self.fine**2, 3)

    def count(self, directions):
        """How many directions (n, 3) fall in each cell."""
        row = np.clip(((directions[:, 2] + 1) / 2 * self.rows).astype(int), 0, self.rows - 1)
        turn = np.arctan2(directions[:, 1], directions[:, 0]) / (2 * np.pi) % 1
        column = np.clip((turn * self.columns).astype(int), 0, self.columns - 1)
        return np.bincount(row * self.columns + column, minlength=self.rows * self.columns)


def chi_square_z(observed, expected):
    """The chi-square statistic as a standard normal deviate (Wilson and Hilferty 1931); rare cells are pooled."""
    rare = expected < 8
    observed = np.append(observed[~rare], observed[rare].sum())
    expected = np.append(expected[~rare], max(expected[rare].sum(), 1e-9))
    if expected[-1] < 8:
        assert observed[-1] < 8 + 6 * np.sqrt(8)
        observed, expected = observed[:-1], expected[:-1]
    degrees = len(observed) - 1
    statistic = ((observed - expected) ** 2 / expected).sum()
    spread = 2 / (9 * degrees)
    return ((statistic / degrees) ** (1 / 3) - (1 - spread)) / np.sqrt(spread)


def draw_evenly(closure, count=20_000, **where):
    """Draws from a smooth closure with even numbers, which tell the chance of each way to 1 / count."""
    u = np.zeros((count, 3))
    u[:, 2] = (np.arange(count) + 0.5) / count
    return SCENE.draw_bsdf(material(closure), u, **where)


def brought(drawn, lobe):
    """What one way of a smooth closure brings of the light: its weight, always the same, times its chance."""
    kind = drawn.lobe == lobe
    assert not kind.any() or np.ptp(drawn.weight[kind]) < 1e-12
    return (drawn.weight[:, 0] * kind).mean()
