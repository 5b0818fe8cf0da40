"""Scene methods for meshes, instances, spacetime objects and curved rays."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from . import _core
from .embree import load_embree
from .influence import EVERYONE, Influence

VISIBLE_CAMERA, VISIBLE_DIFFUSE, VISIBLE_GLOSSY, VISIBLE_TRANSMISSION = 1, 2, 4, 8
VISIBLE_ALL = 15
HOLDOUT, SHADOWLESS, IMMATERIAL = 16, 32, 128

UNRESOLVED, ESCAPED, CAPTURED, ESCAPED_FAR, HIT = range(5)
"""Fates of a ray, as in the "fate" array of `Scene.intersect`."""


class GeometryMethods:
    """The part of Scene that knows where surfaces are and how space is bent."""

    def add_mesh(
        self,
        vertices: np.ndarray,
        triangles: np.ndarray,
        *,
        corner_normals: np.ndarray | None = None,
        corner_uvs: np.ndarray | None = None,
        material_slots: np.ndarray | None = None,
        generated: np.ndarray | None = None,
    ) -> int:
        """Copy a triangle mesh into the scene and return its index.

        vertices: (n, 3) float32, finite. triangles: (m, 3) uint32 vertex indices. corner_normals: (m, 3, 3) float32
        unit normals per corner; without them shading is flat. corner_uvs: (m, 3, 2) float32. material_slots: (m,)
        uint32, index into the materials of an instance. generated: (n, 3) float32 in [0, 1]. ValueError if an array has
        another type, shape or content. Triangles without area, duplicates and huge coordinates do no harm; see
        report_mesh.
        """
        return super().add_mesh(vertices, triangles, corner_normals, corner_uvs, material_slots, generated)

    def set_mesh_attribute(self, mesh: int, attribute: int, values: np.ndarray) -> None:
        """Give the corners of a mesh's triangles values that materials ask for by a number (0 or more).

        values: (m, 3, c) float32, finite, c from 1 to 4 components.
        """
        super().set_mesh_attribute(mesh, attribute, values)

    def set_instance_attribute(self, instance: int, attribute: int, value: tuple[float, float, float, float]) -> None:
        """The same of an instance as a whole. Where its mesh has that attribute too, the mesh's counts."""
        super().set_instance_attribute(instance, attribute, value)

    def update_mesh(
        self,
        mesh: int,
        vertices: np.ndarray,
        *,
        corner_normals: np.ndarray | None = None,
        generated: np.ndarray | None = None,
    ) -> None:
        """Replace the vertices (n, 3) float32 of a mesh, n as before, and its corner normals and generated coordinates
        if given.

        Small moves cost the next commit a refit, large ones a rebuild.
        """
        super().update_mesh(mesh, vertices, corner_normals, generated)

    def report_mesh(self, mesh: int) -> dict[str, int]:
        """Count what is odd about a mesh: triangles that are "degenerate" (no area in float32; never hit), "too_large"
        (a coordinate beyond 1.8e18; never hit) and "duplicate" (same corners as another; either one is hit)."""
        return super().report_mesh(mesh)

    def add_instance(
        self,
        mesh: int,
        world_from_mesh: np.ndarray,
        *,
        materials: np.ndarray | None = None,
        visibility: int = VISIBLE_ALL,
        object_index: float = 0.0,
        one_sided: bool = False,
        color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0),
        random: float = 0.0,
        influence: Influence = EVERYONE,
        receiver_set: int = 0,
        blocker_set: int = 0,
    ) -> int:
        """Place a mesh and return the instance's index.

        world_from_mesh: (4, 4) float64, any invertible affine matrix. materials: (k,) int32, one per slot; None for the
        default gray. visibility: VISIBLE_* bits, and HOLDOUT for a hole in the picture, SHADOWLESS for an instance that
        casts no shadow, IMMATERIAL for one that does nothing to rays but send light along them. one_sided: emits and is
        seen on the side of the geometric normal only. object_index, color (RGB and alpha) and random (in [0, 1]) are
        what a material can ask about its object. influence: whom its own light reaches; receiver_set and blocker_set,
        below 64: what the influence of others calls it.
        """
        about = (object_index, int(one_sided), tuple(color), random, influence, (receiver_set, blocker_set))
        return super().add_instance(mesh, world_from_mesh, materials, visibility, *about)

    def update_instance(self, instance: int, world_from_mesh: np.ndarray) -> None:
        """Move an instance; (4, 4) float64 as in add_instance."""
        super().update_instance(instance, world_from_mesh)

    def set_spacetime(self, spacetime: _core.Spacetime, world_from_spacetime: np.ndarray | None = None) -> None:
        """Bend all of space by one object. world_from_spacetime: (4, 4) float64: rotation, uniform scale, translation;
        None for the identity. Spacetime.minkowski() makes space flat again."""
        matrix = np.eye(4) if world_from_spacetime is None else world_from_spacetime
        self.set_spacetime_objects([(spacetime, matrix, math.inf, -1)])

    def set_spacetime_objects(self, objects: Iterable[tuple[_core.Spacetime, np.ndarray, float, int]]) -> None:
        """Bend space by any number of objects, each inside a sphere of its own; between the spheres rays are straight.

        Each object is (spacetime, world_from_spacetime, sphere_radius, exit). sphere_radius in world units, inf only
        for a lone object, 0 for the default: all of space for a lone object, else half-way to the nearest neighbor. A
        ray that grazes a sphere of radius R is bent too little by up to 4M/R (black hole) or, passing at b << R, by
        2Mb/R^2. exit: for a wormhole the index of its other mouth, which must name this one in turn, or -1: then rays
        through the throat see an empty sky of the wormhole's own. ValueError for overlapping spheres, non-uniform
        scale, shear, mirrors, and exits that do not match.
        """
        super().set_spacetimes(list(objects))

    def commit(self, progress: _core.Progress | None = None) -> None:
        """Make all edits visible. Builds or refits what changed. OSError if Embree 4 cannot be found."""
        load_embree()
        super().commit(progress)

    def intersect(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        tolerance: float = 1e-4,
        *,
        angular_tolerance: float = 1e-4,
        length_min: float = 0.0,
        length_max: float = math.inf,
        sources: np.ndarray | None = None,
        visibility: int = VISIBLE_ALL,
        veils: np.ndarray | None = None,
        progress: _core.Progress | None = None,
        out: dict[str, np.ndarray] | None = None,
    ) -> dict[str, np.ndarray]:
        """The nearest hit along each curved ray.

        origins: (n, 3) float64 world positions. directions: (n, 3) float64 in the local frame there, written in world
        axes; normalized here. tolerance: largest distance, in world units, of a hit from the true ray.
        angular_tolerance: wanted error of the directions, radians. length_min, length_max: only hits at such a length
        along the drawn ray count. sources: (n, 2) int32, instance and triangle that each ray leaves, -1 for none.
        out: what an earlier call with as many rays, and with veils or without, has returned, to be overwritten: new
        memory costs time.

        Returns "fate" (n,) uint8 (UNRESOLVED, ESCAPED, CAPTURED, ESCAPED_FAR, HIT); "instance", "triangle" (n,) int32,
        -1 without a hit; "barycentric" (n, 2) weights of vertices 1 and 2; "position" (n, 3) world, NaN without a hit;
        "direction" (n, 3) local at the hit, asymptotic if escaped; "length" (n,); "swept" (n,) radians around spacetime
        objects; "error" (n,) estimated error of the direction in radians; "first_lens" (n,) int32, the object in whose
        sphere the ray started, or which it entered first, or -1; "borders" (n,) uint32, how many spheres it entered
        and left and throats it went through; "sky" (n,) int32, -1 or the wormhole whose
        far sky an escaped ray sees. The scene must be committed (RuntimeError); several threads may call this at once.

        veils: (instances,) bool: surfaces that rays, which are the camera's then, pass straight on, as accretion disks.
        All of the above is of the whole way to what is met behind them; where nothing passes one any more, it is the
        hit. Returned besides: "glow" (n, 3), the linear RGB radiance that veils send to the ray's start, each dimmed by
        those before it; "transmission" (n, 3), the part of the light from behind them that passes; "layers" (n,)
        uint32, how many have done anything where they were met. Rays through more than 64 surfaces are UNRESOLVED.
        """
        n = len(origins)
        out = out or {
            "fate": np.empty(n, np.uint8),
            "instance": np.empty(n, np.int32),
            "triangle": np.empty(n, np.int32),
            "barycentric": np.empty((n, 2)),
            "position": np.empty((n, 3)),
            "direction": np.empty((n, 3)),
            "length": np.empty(n),
            "swept": np.empty(n),
            "error": np.empty(n),
            "first_lens": np.empty(n, np.int32),
            "borders": np.empty(n, np.uint32),
            "sky": np.empty(n, np.int32),
            **({} if veils is None else _veil_results(n)),
        }
        super().intersect(
            origins,
            directions,
            sources,
            tolerance,
            angular_tolerance,
            length_min,
            length_max,
            visibility,
            progress,
            None if veils is None else np.ascontiguousarray(veils, np.uint8),
            *out.values(),
            *([None] * 3 if veils is None else []),
        )
        return out


def _veil_results(n: int) -> dict[str, np.ndarray]:
    return {"glow": np.empty((n, 3)), "transmission": np.empty((n, 3)), "layers": np.empty(n, np.uint32)}
