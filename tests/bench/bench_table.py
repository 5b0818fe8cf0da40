"""Speed and error of deflection tables: building, every kind of lookup, and the images for shaders.

    python tests/bench/bench_table.py [--count 65536] [--repeat 30]

Prints Markdown: nanoseconds a lookup, the same in Y (bench_trace.py: the yardstick's time a ray at error 2e-6), and the
largest and 95th percentile error against the endpoint route at 1e-12 or the closed forms. Lookups go to arrays that
exist already, as in a renderer. Run on one core (``taskset -c 1``) for numbers worth comparing.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from bench_trace import yardstick_time
from bentlight_native import DeflectionTable, KerrMap, SampledTable, Spacetime, instruction_set, trace_rays

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


def line(name, seconds, count, unit_ns, error=None):
    nanoseconds = seconds / count * 1e9
    quantiles = "| |" if error is None else f"{np.percentile(error, 95):.1e} | {np.max(error):.1e} |"
    print(f"| {name} | {nanoseconds:.2f} | {nanoseconds / unit_ns:.4f} | {quantiles}", flush=True)


def bench_total(name, table, count, repeat, unit_ns):
    delta = 10 ** np.random.default_rng(1).uniform(-6, 3, count)
    angle = np.empty(count)
    seconds = fastest(lambda: table._core.total(delta, angle), repeat)
    closed = total_by_agm(delta, table.spacetime.kind == "ellis")
    error = np.array([table.measured.total_max]) if closed is None else np.abs(angle - closed)
    line(f"{name}, total (1 in)", seconds, count, unit_ns, error)


def bench_finite(name, table, count, repeat, unit_ns):
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
    line(f"{name}, finite radius (2 in)", seconds, count, unit_ns, np.abs(swept - traced["swept"])[out])
    direction, error = np.empty((count, 3)), np.empty(count)
    seconds = fastest(lambda: table._core.trace(origins, directions, fate, direction, error, swept), repeat)
    apart = angle_between(direction[out], traced["direction"][out])
    line(f"{name}, point and direction", seconds, count, unit_ns, apart)
    points = 20 * core * unit(origins)
    exits, outgoing = np.empty((count, 3)), np.empty((count, 3))
    seconds = fastest(lambda: table._core.cross(points, directions, fate, exits, outgoing), repeat)
    line(f"{name}, across a lens sphere", seconds, count, unit_ns)


def bench_images(name, table, count, unit_ns):
    images = SampledTable.from_table(table)
    delta = 10 ** np.random.default_rng(3).uniform(-6, 6, count)
    error = np.abs(images.total(delta) - table.total(delta))
    line(f"{name}, float32 image of total (numpy)", fastest(lambda: images.total(delta), 3), count, unit_ns, error)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=65536)
    parser.add_argument("--repeat", type=int, default=30)
    options = parser.parse_args()
    unit_ns = yardstick_time(Path(__file__).with_name("kerr_yardstick.c"))
    print(f"Instruction set {instruction_set()}, {options.count} lookups, Y = {unit_ns:.0f} ns\n")
    for name, spacetime in SPACETIMES.items():
        build = fastest(lambda spacetime=spacetime: DeflectionTable(spacetime, threads=1), 5)
        table = DeflectionTable(spacetime, threads=1)
        numbers = ", ".join(f"{key} {value:.1e}" for key, value in table.measured._asdict().items())
        print(f"{name}: built in {1e3 * build:.1f} ms on one thread; measured {numbers}")
        print("\n| lookup | ns | Y | p95 error | max error |\n|---|---|---|---|---|")
        bench_total(name, table, options.count, options.repeat, unit_ns)
        bench_finite(name, table, options.count, options.repeat, unit_ns)
        bench_images(name, table, options.count, unit_ns)
        print()
    for spin in (0.5, 0.9, 0.998):
        start = time.perf_counter()
        kerr = KerrMap(Spacetime.kerr(1.0, spin), 20.0, threads=1)
        seconds = time.perf_counter() - start
        error = kerr.measure()
        print(
            f"Kerr map, spin {spin}, {kerr.shape}: {seconds:.1f} s with its error map; median {error.median:.1e}, ",
            end="",
        )
        print(f"95 % {error.p95:.1e}, max {error.maximum:.1e}")


if __name__ == "__main__":
    main()
