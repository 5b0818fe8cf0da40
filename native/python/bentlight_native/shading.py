"""Images, materials and the world of a scene, and a look at a material outside a render.

`ShadingMethods` gives these methods to `Scene`. Colors are linear RGB, directions unit vectors away from the surface.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .program import Program


class Samples(NamedTuple):
    """wi (n, 3), weight (n, 3) = f |cos| / pdf, pdf (n,) per solid angle (0: delta lobe), lobe (n,): 2 diffuse, 4
    glossy, 8 transmission, 16 transparent, 0 absorbed (then everything is 0)."""

    wi: NDArray[np.float64]
    weight: NDArray[np.float64]
    pdf: NDArray[np.float64]
    lobe: NDArray[np.uint8]


RAY_CAMERA, RAY_SHADOW, RAY_DIFFUSE, RAY_GLOSSY, RAY_TRANSMISSION, RAY_REFLECTION, RAY_SINGULAR = (
    1 << i for i in range(7)
)
"""Bits of the kinds of ray that materials can tell apart, as in scene/shading.h."""

POINT_DEFAULTS: dict[str, ArrayLike] = {
    "position": (0.0, 0.0, 0.0),
    "generated": (0.0, 0.0, 0.0),
    "wo": (0.0, 0.0, 1.0),
    "geometric_normal": (0.0, 0.0, 1.0),
    "normal": (0.0, 0.0, 1.0),
    "tangent": (1.0, 0.0, 0.0),
    "tangent_sign": (1.0,),
    "uv": (0.0, 0.0),
    "object_index": (0.0,),
    "backfacing": (0.0,),
    "barycentric": (0.0, 0.0),
    "object_color": (1.0, 1.0, 1.0, 1.0),
    "object_random": (0.0,),
    "ray_length": (1.0,),
    "ray_kinds": (0,),  # RAY_* bits
    "ray_depths": (0, 0, 0, 0, 0),  # all bounces, diffuse, glossy, transmission, transparent
}


def _point_rows(fields: dict[str, ArrayLike]) -> NDArray[np.float64]:
    """Rows of shade points (n, 37) from the fields of scene/shading.h.

    What is missing is a default, what has one row is repeated. The caller turns normals to the side of wo.
    """
    unknown = set(fields) - set(POINT_DEFAULTS)
    if unknown:
        raise ValueError(f"no such part of a shade point: {', '.join(sorted(unknown))}")
    parts = []
    for name in _core.Scene._point_fields():
        width = len(np.atleast_1d(POINT_DEFAULTS[name]))
        value = np.asarray(fields.get(name, POINT_DEFAULTS[name]), np.float64)
        parts.append(value.reshape(-1, width))
    count = max(map(len, parts))
    return np.ascontiguousarray(np.hstack([np.broadcast_to(p, (count, p.shape[1])) for p in parts]))


class ShadingMethods:
    """Methods of Scene about images, materials and the world. Indices count from 0."""

    def add_image(self, pixels: NDArray, srgb: bool = False) -> int:
        """Adds an image, rows from the bottom up, RGB with associated alpha; returns its index.

        pixels: (height, width, 4), float32 (finite, scene-linear) or uint8 (divided by 255). srgb: values are encoded
        by the sRGB curve, and decoded after interpolation, as Cycles does with byte images.
        """
        return self._add_image(np.ascontiguousarray(pixels), pixels.dtype == np.uint8, srgb)

    def update_image(self, index: int, pixels: NDArray, srgb: bool = False) -> None:
        """Replaces an image; see add_image."""
        self._update_image(index, np.ascontiguousarray(pixels), pixels.dtype == np.uint8, srgb)

    def add_material(self, program: Program) -> int:
        """Adds a material; returns its index. Its images must have been added. ValueError names a bad instruction."""
        return self._add_material(program.code, program.constants, program.table)

    def update_material(self, index: int, program: Program) -> None:
        """Replaces a material; see add_material."""
        self._update_material(index, program.code, program.constants, program.table)

    def set_world(self, program: Program | None) -> None:
        """Sets the sky: a program that sees the asymptotic direction as generated coordinate. None is black."""
        if program is None:
            self._set_world()
        else:
            self._set_world(program.code, program.constants, program.table)

    def set_gravitational(self, amount: float) -> None:
        """How much gravity shifts light on its way, [0, 1]; needs a commit.

        Each color is seen (nu_observed / nu_emitted)^(4 amount) as bright and keeps its hue. Surfaces, lamps and the
        camera are at rest with local observers, the sky is at infinity. Accretion disks shift their light themselves.
        """
        self._set_gravitational(amount)

    def shift_light(
        self, origins: ArrayLike, directions: ArrayLike, ends: ArrayLike, arrivals: ArrayLike, sky: ArrayLike
    ) -> NDArray[np.float64]:
        """How bright light is to rays' beginnings over how bright it is where it comes from (n,), by set_gravitational.

        origins, ends: places (n, 3), world; directions, arrivals: local unit directions of the rays there; sky: (n,),
        whether a ray ends in the sky instead.
        """
        rows = [np.ascontiguousarray(values, np.float64) for values in (origins, directions, ends, arrivals)]
        brightness = np.empty(len(rows[0]))
        self._shift_light(*rows, np.ascontiguousarray(sky, np.uint8), brightness)
        return brightness

    def sky(self, directions: ArrayLike, ray_kinds: int = 0, across: ArrayLike | None = None) -> NDArray[np.float64]:
        """Radiance (n, 3) of the sky in unit directions (n, 3), as rays of those kinds (RAY_* bits) see it.

        across: (n, 2, 3): equirectangular images are averaged by about a Gaussian that has these changes of the
        direction as its standard deviation. None: they are not.
        """
        rows = np.ascontiguousarray(directions, np.float64)
        spreads = np.zeros((*rows.shape[:1], 2, 3)) if across is None else np.ascontiguousarray(across, np.float64)
        radiance = np.zeros_like(rows)
        self._sky(rows, spreads, ray_kinds, radiance)
        return radiance

    def shade(
        self, material: int, world_from_object: ArrayLike | None = None, **point: ArrayLike
    ) -> dict[str, NDArray[np.float64]]:
        """Runs a material at points; returns "emission" (n, 3) towards wo and "albedo" (n, 3), the estimate that
        denoisers get. world_from_object: (4, 4), None for the identity. point: fields of scene/shading.h's shade_point,
        (n, width) or one row for all."""
        rows = _point_rows(point)
        matrix = np.eye(4) if world_from_object is None else np.asarray(world_from_object, np.float64)
        results = np.zeros((len(rows), 6))
        self._shade(material, rows, np.stack([matrix, np.linalg.inv(matrix)]), results)
        return {"emission": results[:, :3], "albedo": results[:, 3:]}

    def draw_bsdf(self, material: int, u: ArrayLike, portals: bool = False, **point: ArrayLike) -> Samples:
        """Draws directions at one point from random numbers u (n, 3) in [0, 1). portals: as the renderer does with
        portal_sampling, some through the mouths of wormholes; the scene must be committed."""
        u = np.ascontiguousarray(u, np.float64)
        samples = np.zeros((len(u), 8))
        self._draw_bsdf(material, _point_rows(point)[0], u, samples, portals)
        return Samples(samples[:, :3], samples[:, 3:6], samples[:, 6], samples[:, 7].astype(np.uint8))

    def evaluate_bsdf(
        self, material: int, wi: ArrayLike, portals: bool = False, **point: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """f(wo, wi) |cos| (n, 3) without delta lobes, and the pdf (n,) of draw_bsdf, for wi (n, 3) at one point."""
        wi = np.ascontiguousarray(wi, np.float64)
        values = np.zeros((len(wi), 4))
        self._evaluate_bsdf(material, _point_rows(point)[0], wi, values, portals)
        return values[:, :3], values[:, 3]
