"""Curved rays against meshes beside Embree's straight rays: 1.3 million triangles, one core.

Run it alone for a table, or call measure() for its rows. Times are CPU time of the one thread that works, the best of
several turns, Embree's yardstick measured anew in each turn.
"""

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "native"))
import meshes
from bentlight_native import Scene, Spacetime
from bentlight_native.embree import embree_candidates

RAYS = 200_000
SIZE = 2.0  # of the scene; the hole's mass is a hundredth of it
SPACETIMES = {
    "flat": Spacetime.minkowski(),
    "Schwarzschild": Spacetime.schwarzschild(SIZE / 100),
    "Kerr a = 0.9": Spacetime.kerr(SIZE / 100, 0.9 * SIZE / 100),
    "Ellis": Spacetime.ellis(SIZE / 100),
}
TOLERANCES = (1e-3, 1e-4)  # in units of the scene's size
GOALS = {1e-3: 2.2, 1e-4: 3.0}


def spheres(rng):
    """1000 spheres of 1296 triangles each, 3e-3 wide, none of them over the hole."""
    parts = []
    while len(parts) < 1000:
        center = rng.uniform(-SIZE / 2, SIZE / 2, 3)
        if np.linalg.norm(center) > 0.1:
            parts.append(meshes.sphere(0.045, center, segments=36, rings=19))
    return meshes.joined(*parts)


def rays(rng):
    """Origins anywhere in the scene outside 2.5 M, directions anywhere."""
    origins = rng.uniform(-SIZE / 2, SIZE / 2, (RAYS, 3))
    origins[np.linalg.norm(origins, axis=1) < 0.05] = 0.5
    return origins, meshes.directions(rng, RAYS)


class Yardstick:
    """rtcIntersect1 called directly, from C."""

    def __init__(self, vertices, triangles, origins, directions):
        folder = tempfile.mkdtemp()
        library = Path(folder) / "embree_direct.so"
        source = Path(__file__).with_name("embree_direct.c")
        subprocess.run([shutil.which("cc"), "-O2", "-shared", "-fPIC", str(source), "-o", str(library)], check=True)
        self.call = ctypes.CDLL(str(library)).embree_direct
        self.direct = meshes.DirectEmbree(embree_candidates()[0], vertices, triangles)
        distance = np.empty(len(origins), np.float32)
        self.arrays = origins, directions, distance

    def __call__(self):
        intersect1 = ctypes.cast(self.direct.lib.rtcIntersect1, ctypes.c_void_p)
        pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in self.arrays]
        self.call(intersect1, ctypes.c_void_p(self.direct.scene), ctypes.c_size_t(len(self.arrays[0])), *pointers)


def cpu_time(call):
    start = time.thread_time()
    call()
    return time.thread_time() - start


def measure(turns=5):
    """Rows of (what, tolerance over the scene's size or None, microseconds a ray, ratio to Embree, goal or None)."""
    rng = np.random.default_rng(1)
    vertices, triangles = spheres(rng)
    origins, directions = rays(rng)
    scene = Scene()
    scene.add_instance(scene.add_mesh(vertices, triangles), np.eye(4))
    start = time.perf_counter()
    scene.commit()
    commit = time.perf_counter() - start
    yardstick = Yardstick(vertices, triangles, origins, directions)
    rows = [("commit 1 M triangles, seconds", None, commit / len(triangles) * 1e6, None, 1.0)]
    cases = [("flat", None)] + [(name, t) for name in SPACETIMES if name != "flat" for t in TOLERANCES]
    for name, tolerance in cases:
        scene.set_spacetime(SPACETIMES[name])
        scene.commit()
        hits = scene.intersect(origins, directions)

        def intersect(distance=(tolerance or 1e-4) * SIZE, hits=hits):
            scene.intersect(origins, directions, tolerance=distance, out=hits)

        pairs = [(cpu_time(yardstick), cpu_time(intersect)) for _ in range(turns)]
        direct, ours = (min(times) / RAYS * 1e6 for times in zip(*pairs, strict=True))
        if name == "flat":
            rows.append(("Embree called directly", None, direct, 1.0, None))
        rows.append((name, tolerance, ours, ours / direct, GOALS.get(tolerance)))
    return rows


def main():
    print("| ray | tolerance / size | µs a ray | ratio to Embree | goal |\n|---|---|---|---|---|")
    for what, tolerance, microseconds, ratio, goal in measure():
        print(f"| {what} | {tolerance or ''} | {microseconds:.3f} | {ratio or 0:.2f} | {goal or ''} |")


if __name__ == "__main__":
    main()
