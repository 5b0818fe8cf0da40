"""Brute force for the curved-ray tests: oracle.c, compiled once a test run, and how an answer is judged by it."""

import ctypes

import numpy as np
from compiled import load, pointer

KINDS = {"isotropic": 0, "areal": 1, "ellis": 2, "kerr": 3}
OUTER = 6.0  # rays are followed to this distance; everything in the tests lies within it


def build(folder):
    """Compiles oracle.c into `folder` and loads it."""
    return load("oracle.c", folder)


class Oracle:
    """The truth about rays in one spacetime, in its own axes, among triangles (m, 3, 3) float64."""

    def __init__(self, library, kind, triangles, *, mass=0.0, spin=0.0, throat=0.0, outer=OUTER):
        self.library = library
        self.space = [ctypes.c_int(KINDS[kind]), *(ctypes.c_double(v) for v in (mass, spin, throat, outer))]
        self.triangles = np.ascontiguousarray(triangles, float)
        self.boxes = np.ascontiguousarray(np.stack([triangles.min(1), triangles.max(1)], 1), float)

    def hits(self, origins, directions):
        """Fate (n,), triangle (n,), -1 for none, position (n, 3) and drawn length (n,) of the first hits."""
        n = len(origins)
        fate, triangle, position, length = np.empty(n, np.int32), np.empty(n, np.int32), np.empty((n, 3)), np.empty(n)
        self.library.oracle_hits(
            *self.space, ctypes.c_size_t(len(self.triangles)), pointer(self.triangles), pointer(self.boxes),
            ctypes.c_size_t(n), pointer(np.ascontiguousarray(origins)), pointer(np.ascontiguousarray(directions)),
            pointer(fate), pointer(triangle), pointer(position), pointer(length))  # fmt: skip
        return fate, triangle, position, length

    def distances(self, origins, directions, segments):
        """Smallest distance of each ray from its own segments (n, k, 2, 3)."""
        n, k = segments.shape[:2]
        out = np.empty(n)
        self.library.oracle_distances(
            *self.space, ctypes.c_size_t(n), pointer(np.ascontiguousarray(origins)),
            pointer(np.ascontiguousarray(directions)), ctypes.c_size_t(k),
            pointer(np.ascontiguousarray(segments, float)), pointer(out))  # fmt: skip
        return out

    def edge_distances(self, origins, directions, triangle):
        """Distance of each ray from the nearest edge of a triangle each."""
        corners = self.triangles[triangle]
        return self.distances(origins, directions, np.stack([corners, np.roll(corners, -1, axis=1)], axis=2))

    def length_to(self, origin, direction, triangle, shift):
        """Drawn length at which one ray meets one triangle that is moved by `shift` along its normal, or infinity."""
        corners = self.triangles[triangle]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        moved = (corners + shift * normal / np.linalg.norm(normal))[None]
        alone = Oracle.__new__(Oracle)
        alone.library, alone.space, alone.triangles = self.library, self.space, moved
        alone.boxes = np.ascontiguousarray(np.stack([moved.min(1), moved.max(1)], 1))
        fate, _, _, length = alone.hits(origin[None], direction[None])
        return length[0] if fate[0] == 4 else np.inf
