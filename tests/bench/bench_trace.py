"""Speed and error of ``trace_rays``: every spacetime and route, ordinary rays and the named hard cases.

    python tests/bench/bench_trace.py [--grid 256] [--repeat 7] [--yardstick FILE.c]

Prints Markdown. Errors are angles to the Taylor route at tolerance 1e-14. By a yardstick program, kerr_yardstick.c (it
prints a table of ns/ray and 99th percentile errors) times are also given in units of Y, its time at error 2e-6; run on
one core (``taskset -c 1``) for numbers worth comparing.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bentlight_native import Spacetime, instruction_set, trace_rays

sys.path.insert(0, str(Path(__file__).parents[1] / "native"))
from hard_cases import hard_cases
from rays import angle_between, image_grid

YARDSTICK_ERROR = 2e-6
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
KERR_SPIN_SEEN = 0.9  # the hole's spin is its negative


@dataclass(frozen=True)
class Measurement:
    """One run of trace_rays: the best of several, and its errors against the reference."""

    name: str
    route: str
    tolerance: float
    nanoseconds: float
    median: float
    p99: float
    largest: float
    steps: float
    wrong: int  # fates that differ from the reference's


def measure(name, space, origins, directions, tolerance, route, reference, repeat):
    """Times trace_rays, its launching and Python's part included."""
    best = np.inf
    for _ in range(repeat):
        start = time.perf_counter()
        got = trace_rays(space, origins, directions, tolerance, route=route)
        best = min(best, time.perf_counter() - start)
    out = np.isin(got["fate"], (1, 3)) & np.isin(reference["fate"], (1, 3))
    error = angle_between(got["direction"][out], reference["direction"][out]) if out.any() else np.zeros(1)
    wrong = int(np.count_nonzero((got["fate"] != reference["fate"]) & (got["fate"] != 0) & (reference["fate"] != 0)))
    quantiles = np.percentile(error, (50, 99, 100))
    return Measurement(name, route, tolerance, best / len(origins) * 1e9, *quantiles, float(got["steps"].mean()), wrong)


def ordinary(grid=256, repeat=7):
    """The square of image_grid around each object: Kerr's rays, for all of them."""
    origins, directions = image_grid(KERR_SPIN_SEEN, grid=grid)
    spaces = {
        "Kerr 0.9": Spacetime.kerr(1, -KERR_SPIN_SEEN),
        "Schwarzschild": Spacetime.schwarzschild(1),
        "Ellis": Spacetime.ellis(1),
    }
    for name, space in spaces.items():
        reference = trace_rays(space, origins, directions, 1e-14, route="taylor")
        for route in ("taylor", "auto"):
            for tolerance in TOLERANCES:
                yield measure(name, space, origins, directions, tolerance, route, reference, repeat)


def hard(repeat=3, copies=50):
    """Each named hard case, its rays repeated so that there is something to time."""
    for case in hard_cases():
        origins, directions = (np.tile(x, (copies, 1)) for x in (case.origins, case.directions))
        reference = trace_rays(case.spacetime, origins, directions, 1e-14, route="taylor")
        for route in ("taylor", "auto"):
            yield measure(case.name, case.spacetime, origins, directions, 1e-9, route, reference, repeat)


def time_at_error(errors, times, wanted):
    """Time at a wanted error, log-interpolated in a table of falling errors; NaN outside it."""
    order = np.argsort(errors)
    x, y = np.log(np.asarray(errors)[order]), np.asarray(times)[order]
    return float(np.interp(np.log(wanted), x, y, left=np.nan))


def yardstick_time(source):
    """Compiles and runs the yardstick; its ns/ray at YARDSTICK_ERROR."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "yardstick"
        flags = ["-O3", "-march=native", "-ffast-math", "-funroll-loops"]
        subprocess.run(["cc", *flags, str(source), "-o", str(program), "-lm"], check=True, stderr=subprocess.DEVNULL)
        text = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    table = np.array([[float(x) for x in line.split()] for line in text.splitlines()[2:]])
    return time_at_error(table[:, 4], table[:, 1], YARDSTICK_ERROR)


def print_table(measurements, unit):
    print(
        "| rays | route | tolerance | ns/ray |" + (" Y |" if unit else "") + " p50 | p99 | max | arcs | wrong fates |"
    )
    print("|---|---|---|---|" + ("---|" if unit else "") + "---|---|---|---|---|")
    for m in measurements:
        scaled = f" {m.nanoseconds / unit:.2f} |" if unit else ""
        errors = " | ".join(f"{e:.1e}" for e in (m.median, m.p99, m.largest))
        print(f"| {m.name} | {m.route} | {m.tolerance:.0e} | {m.nanoseconds:.1f} |{scaled} {errors} | ", end="")
        print(f"{m.steps:.1f} | {m.wrong} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grid", type=int, default=256)
    parser.add_argument("--repeat", type=int, default=7)
    parser.add_argument("--yardstick", type=Path, default=Path(__file__).with_name("kerr_yardstick.c"))
    options = parser.parse_args()
    unit = yardstick_time(options.yardstick) if options.yardstick else None
    print(f"Instruction set {instruction_set()}, {options.grid**2} rays" + (f", Y = {unit:.0f} ns" if unit else ""))
    found = list(ordinary(options.grid, options.repeat))
    print_table(found, unit)
    for name, route, error in (
        ("Kerr 0.9", "taylor", YARDSTICK_ERROR),
        ("Kerr 0.9", "auto", 2e-11),
        ("Schwarzschild", "auto", None),
        ("Ellis", "auto", None),
    ):
        of = [m for m in found if (m.name, m.route) == (name, route)]
        at = (
            of[-1].nanoseconds
            if error is None
            else time_at_error([m.p99 for m in of], [m.nanoseconds for m in of], error)
        )
        label = f"tolerance {of[-1].tolerance:.0e}" if error is None else f"p99 {error:.0e}"
        print(f"\n{name}, {route}, {label}: {at:.1f} ns" + (f" = {at / unit:.2f} Y" if unit else ""))
    print()
    print_table(hard(), unit)


if __name__ == "__main__":
    main()
