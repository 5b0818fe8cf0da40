"""Speed and error of deflection tables: building, every kind of lookup, and the images for shaders.

    python tests/bench/bench_table.py [--count 65536] [--repeat 30]

Prints Markdown: nanoseconds a lookup, the same in Y (bench_trace.py: the yardstick's time a ray at error 2e-6), and the
largest and 95th percentile error against the endpoint route at 1e-12 or the closed forms. Lookups go to arrays that
exist already, as in a renderer. Run on one core (``taskset -c 1``) for numbers worth comparing.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bench_trace import yardstick_time
from bentlight_native import DeflectionTable, KerrMap, LensSphere, SampledTable, Spacetime, instruction_set, trace_rays

sys.path.insert(0, str(Path(__file__).parents[1] / "native"))
from rays import angle_between, unit

SPACETIMES = {"Schwarzschild": Spacetime.schwarzschild(1.0), "Ellis": Spacetime.ellis(1.0)}


def fastest(call, repeat):
    """Seconds of the fastest of some calls."""
    best = np.inf
    for _ in range(repeat):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    return best


def total_by_agm(delta, is_ellis):
    """Closed forms of the total angle: Ellis by the arithmetic-geometric mean; None for Schwarzschild."""
    if not is_ellis:
        return None
    x, y = 1 + np.abs(delta), np.sqrt(np.abs(delta) * (2 + np.abs(delta)))
    for _ in range(12):
        x, y = (x + y) / 2, np.sqrt(x * y)
    return np.pi * (1 + np.abs(delta)) / x


@dataclass
class Lookup:
    """What one kind of lookup costs and errs (radians; NaN where there is nothing to compare with)."""

    name: str
    nanoseconds: float
    p95: float = np.nan
    p99: float = np.nan
    largest: float = np.nan

    def row(self, unit_ns: float) -> str:
        """A row of the Markdown table."""
        errors = "| |" if np.isnan(self.largest) else f"{self.p95:.1e} | {self.largest:.1e} |"
        return f"| {self.name} | {self.nanoseconds:.2f} | {self.nanoseconds / unit_ns:.4f} | {errors}"


def lookup(name, seconds, count, error=None) -> Lookup:
    """From the seconds of `count` lookups and the errors of all or some of them."""
    errors = () if error is None else (*np.percentile(error, (95, 99)), np.max(error))
    return Lookup(name, seconds / count * 1e9, *errors)


def bench_total(name, table, count, repeat) -> Iterator[Lookup]:
    delta = 10 ** np.random.default_rng(1).uniform(-6, 3, count)
    angle = np.empty(count)
    seconds = fastest(lambda: table._core.total(delta, angle), repeat)
    closed = total_by_agm(delta, table.spacetime.kind == "ellis")
    error = np.array([table.measured.total_max]) if closed is None else np.abs(angle - closed)
    yield lookup(f"{name}, total (1 in)", seconds, count, error)


def bench_finite(name, table, count, repeat) -> Iterator[Lookup]:
    """From finite radii beyond the part of the plane that is computed directly; half of the rays pass close by."""
    random = np.random.default_rng(2)
    core = table.spacetime.core_radius
    radius = core * 10 ** random.uniform(np.log10(7), 3, count)
    origins = radius[:, None] * unit(random.normal(size=(count, 3)))
    aside = unit(random.normal(size=(count, 3))) * core * random.uniform(0, 30, count)[:, None]
    near = random.random(count) < 0.5
    directions = unit(np.where(near[:, None], aside - origins, random.normal(size=(count, 3))))
    cosine = np.einsum("ij,ij->i", origins, directions) / radius
    sine = np.linalg.norm(np.cross(origins, directions), axis=1) / radius
    fate, swept = np.empty(count, np.uint8), np.empty(count)
    seconds = fastest(lambda: table._core.sweep(radius, cosine, sine, fate, swept), repeat)
    traced = trace_rays(table.spacetime, origins, directions, 1e-12, route="endpoint")
    out = np.isfinite(swept) & np.isfinite(traced["swept"]) & (traced["error"] < 1e-10)
    yield lookup(f"{name}, finite radius (2 in)", seconds, count, np.abs(swept - traced["swept"])[out])
    direction, error = np.empty((count, 3)), np.empty(count)
    seconds = fastest(lambda: table._core.trace(origins, directions, fate, direction, error, swept), repeat)
    apart = angle_between(direction[out], traced["direction"][out])
    yield lookup(f"{name}, point and direction", seconds, count, apart)


def bench_sphere(name, spacetime, count, repeat) -> Iterator[Lookup]:
    """Rays over all of a lens sphere of 20 core radii; the error is the largest that each states."""
    radius = 20 * spacetime.core_radius
    sphere = LensSphere(spacetime, radius)
    random = np.random.default_rng(4)
    points = radius * unit(random.normal(size=(count, 3)))
    directions = unit(random.normal(size=(count, 3)) * 0.3 * radius - points)
    out = sphere.cross(points, directions)
    seconds = fastest(lambda: sphere._core.cross(points, directions, *out.values()), repeat)
    yield lookup(f"{name}, across a lens sphere", seconds, count, out["error"][out["fate"] != 0])


def bench_images(name, table, count) -> Iterator[Lookup]:
    images = SampledTable.from_table(table)
    delta = 10 ** np.random.default_rng(3).uniform(-6, 6, count)
    error = np.abs(images.total(delta) - table.total(delta))
    yield lookup(f"{name}, float32 image of total (numpy)", fastest(lambda: images.total(delta), 3), count, error)


def kerr_line(spin: float) -> str:
    """Time and error of a map for shaders."""
    start = time.perf_counter()
    kerr = KerrMap(Spacetime.kerr(1.0, spin), 20.0, threads=1)
    seconds = time.perf_counter() - start
    error = kerr.measure()
    return (
        f"Kerr map, spin {spin}, {kerr.shape}: {seconds:.1f} s with its error map; median {error.median:.1e}, "
        f"95 % {error.p95:.1e}, max {error.maximum:.1e}"
    )


def report(unit_ns: float, count: int = 65536, repeat: int = 30) -> tuple[str, list[Lookup]]:
    """Everything as Markdown, and the lookups alone. unit_ns: the yardstick's time Y."""
    lines = [f"Instruction set {instruction_set()}, {count} lookups, Y = {unit_ns:.0f} ns\n"]
    lookups: list[Lookup] = []
    for name, spacetime in SPACETIMES.items():
        build = fastest(lambda spacetime=spacetime: DeflectionTable(spacetime, threads=1), 5)
        table = DeflectionTable(spacetime, threads=1)
        numbers = ", ".join(f"{key} {value:.1e}" for key, value in table.measured._asdict().items())
        mine = [*bench_total(name, table, count, repeat), *bench_finite(name, table, count, repeat)]
        mine += bench_sphere(name, spacetime, count, repeat)
        mine += bench_images(name, table, count)
        lines += [
            f"{name}: built in {1e3 * build:.1f} ms on one thread; measured {numbers}\n",
            "| lookup | ns | Y | p95 error | max error |\n|---|---|---|---|---|",
            *(each.row(unit_ns) for each in mine),
            "",
        ]
        lookups += mine
    lines += [kerr_line(spin) + "\n" for spin in (0.5, 0.9, 0.998)]
    return "\n".join(lines), lookups


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=65536)
    parser.add_argument("--repeat", type=int, default=30)
    options = parser.parse_args()
    unit_ns = yardstick_time(Path(__file__).with_name("kerr_yardstick.c"))
    print(report(unit_ns, options.count, options.repeat)[0])


if __name__ == "__main__":
    main()
