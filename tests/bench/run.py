"""make bench: measures everything once and writes output/bench/bench.md and output/bench/rays.svg.

Take the numbers on a machine that does nothing else; ratios are of works that took turns in one run.
"""

import argparse
import logging
import os
import platform
from datetime import date
from pathlib import Path

import bench_connect
import bench_flicker
import bench_intersect
import bench_lens
import bench_lens_sky
import bench_lens_sky_time
import bench_lens_stars
import bench_lights
import bench_relay
import bench_room
import bench_sky
import bench_table
import bench_trace
import bench_viewport
import bentlight_native
from chart import Series, log_log_chart

HERE = Path(__file__).resolve().parent
OUTPUT = HERE.parents[1] / "output" / "bench"
log = logging.getLogger("bentlight.bench")


def table(head: list[str], rows: list[list[object]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def processor() -> str:
    """The processor's name, as Linux tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def rays_section(ordinary: list[bench_trace.Measurement], hard: list[bench_trace.Measurement], y: float) -> str:
    """Nanoseconds and errors of trace_rays."""
    head = ["rays", "route", "tolerance", "ns a ray", "Y", "median error", "99th percentile", "largest", "wrong fates"]
    rows = [
        [m.name, m.route, f"{m.tolerance:.0e}", f"{m.nanoseconds:.0f}", f"{m.nanoseconds / y:.2f}"]
        + [f"{error:.0e}" for error in (m.median, m.p99, m.largest)]
        + [m.wrong]
        for m in (*ordinary, *hard)
    ]
    return (
        "## Rays to infinity or the horizon\n\nOn one core, called from Python, launching included. Errors are angles "
        "(rad) to the Taylor route at tolerance 1e-14. *taylor* follows the path, *auto* takes the endpoint formulas "
        f"where they hold. Y = {y:.0f} ns is the time of kerr_yardstick.c at 99th-percentile error 2e-6. The named "
        "cases below are the hard ones; what double precision leaves of a nearly critical ray is its error there.\n\n"
        "![time against error](rays.svg)\n\n" + table(head, rows)
    )


def rays_chart(
    ordinary: list[bench_trace.Measurement],
    hard: list[bench_trace.Measurement],
    lookups: list[bench_table.Lookup],
) -> str:
    """Time against error: a line for each spacetime and route, clouds for the tables and the hard cases."""
    series: dict[tuple[str, str], Series] = {}
    for m in ordinary:
        series.setdefault((m.name, m.route), Series(f"{m.name}, {m.route}")).points.append((m.p99, m.nanoseconds))
    for route in ("taylor", "auto"):
        points = [(m.p99, m.nanoseconds) for m in hard if m.route == route]
        series["hard", route] = Series(f"hard cases, {route}", points, is_cloud=True)
    points = [(each.p99, each.nanoseconds) for each in lookups]
    series["table", ""] = Series("deflection tables", points, is_cloud=True)
    return log_log_chart("Curved rays", "99th percentile of the error (rad)", "ns a ray", list(series.values()))


def connect_section() -> str:
    """Rays that join two points."""
    head = ["spacetime", "images", "tolerance", "µs a pair", "met", "goal"]
    return "## Rays that join two points\n\nOne core.\n\n" + table(head, list(bench_connect.measure()))


def intersect_section() -> str:
    """Curved and straight rays beside Embree called directly."""
    commit, *rays = bench_intersect.measure()
    rows = [
        [what, f"{tolerance:g}" if tolerance else "", f"{time:.3f}", f"{ratio:.2f}", goal or ""]
        for what, tolerance, time, ratio, goal in rays
    ]
    return (
        "## Rays against 1.3 million triangles\n\nOne core, transport and traversal together, the hole a hundredth of "
        f"the scene's size. Committing a million triangles takes {commit[2]:.2f} s (goal: {commit[4]:g}).\n\n"
        + table(["rays", "tolerance / size", "µs a ray", "ratio to Embree", "goal"], rows)
    )


def room_section(times: bench_room.RoomTimes) -> str:
    """The room's seconds and ratios."""
    width, height = bench_room.RESOLUTION
    ratios = [
        ["with the hole / without", f"{times.hole_over_flat:.2f}", "2.5"],
        ["without the hole: Bentlight / Cycles", f"{times.flat_over_cycles:.2f}", "1.5"],
        ["1 thread / 2 threads", f"{times.speed_up:.2f}", ""],
    ]
    return (
        f"## The room of make render, {width} x {height}, {bench_room.SAMPLES} samples\n\n"
        + table(["render", "seconds"], [[name, f"{value:.2f}"] for name, value in times.seconds.items()])
        + "\n"
        + table(["ratio", "measured", "goal"], ratios)
    )


def viewport_section(times: bench_viewport.ViewportTimes) -> str:
    """How soon Rendered shading shows something."""
    width, height = bench_viewport.RESOLUTION
    rows = [
        ["a camera that has moved, first picture", f"{times.moved:.2f}", "0.3"],
        ["the same, in full resolution", f"{times.full:.2f}", ""],
        ["a new viewport, first picture", f"{times.begun:.2f}", ""],
    ]
    return f"## The room in Rendered shading, {width} x {height}\n\n" + table(["until", "seconds", "goal"], rows)


def lens_section(times: bench_lens.LensTimes) -> str:
    """What Cycles pays for a lens."""
    width, height = bench_lens.RESOLUTION
    names = ("lens", "lens, spin 0.9")
    ratios = [[name, *(f"{times.ratio(name, way):.2f}" for way in bench_lens.WITHOUT), "1.5"] for name in names]
    return (
        f"## The room by Cycles, {width} x {height}, {bench_lens.SAMPLES} samples\n\n"
        + table(["render", "seconds"], [[name, f"{value:.2f}"] for name, value in times.seconds.items()])
        + "\n"
        + table(["over no lens by", *bench_lens.WITHOUT, "goal for OSL"], ratios)
        + f"\nTables of a kind of space are made once, in {times.bake:.2f} s.\n"
    )


def lens_sky_section(times: dict[str, float]) -> str:
    """What Cycles pays for a lens where nothing else is seen."""
    width, height = bench_lens_sky_time.RESOLUTION
    rows = [[name, f"{1e6 * value:.2f}", f"{value / times['no lens']:.1f}"] for name, value in times.items()]
    return (
        f"## A lens and an image of the sky by Cycles, {width} x {height}, {bench_lens_sky_time.SAMPLES} samples\n\n"
        "Processor time, all in Open Shading Language.\n\n" + table(["picture", "µs a sample", "over no lens"], rows)
    )


def relay_section(costs: dict[str, bench_relay.RelayCost], resolution: tuple[int, int]) -> str:
    """Rays and memory of the relay camera's maps, by what is seen, in so many pixels."""
    width, height = resolution
    head = ["picture", "million rays", "seconds", "million a second", "maps, MiB", "before", "most in the bake"]
    head += ["most in the render"]
    rows = [
        [name, f"{cost.rays / 1e6:.1f}", f"{cost.seconds:.1f}", f"{cost.rays / cost.seconds / 1e6:.2f}"]
        + [f"{value:.0f}" for value in (cost.maps, cost.before, cost.baked, cost.rendered)]
        for name, cost in costs.items()
    ]
    return (
        f"## The relay camera, {width} x {height}, 4 x 4 rays a pixel and more at the hole\n\n"
        f"{bench_relay.__doc__.splitlines()[0]} Memory in MiB; the goal in 1920 x 1080 is 2048.\n\n" + table(head, rows)
    )


def lights_section(results: list[bench_lights.Efficiency]) -> str:
    """What each way to find light costs to a given error, beside chance (or Bentlight beside Cycles)."""
    head = ["room", "light by", "samples x seeds", "seconds", "error", "gain at equal time"]
    head += [f"{bench_lights.CONFIDENCE:.0%} interval", "without the worst"]
    first = {}
    rows = []
    for each in results:
        reference = first.setdefault(each.room, each)
        error = f"{each.error2**0.5:.4f}"
        row = [each.room, each.way.lower(), f"{each.samples} x {len(each.pictures)}", f"{each.seconds:.2f}", error]
        if each is not reference:
            low, high = bench_lights.gain_interval(reference, each)
            row += [f"{bench_lights.gain(reference, each):.3g}", f"{low:.3g} to {high:.3g}"]
            row += [f"{bench_lights.gain_without_worst(reference, each):.3g}"]
        rows.append(row + [""] * (len(head) - len(row)))
    width, height = bench_lights.RESOLUTION
    return (
        f"## Noise against time, {width} x {height}\n\nThe error is the root of the mean squared deviation from the "
        "expected picture, told from pictures of several seeds. The gain: how many times lower the mean squared error "
        "is in the same time than in the room's first line; the interval where other seeds and pixels would mostly "
        "put it, as far as these tell (bootstrap); and the gain without the worst "
        f"{bench_lights.WORST:.0%} of the pixels.\n\n" + table(head, rows)
    )


def flicker_section(results: list[bench_flicker.Flicker]) -> str:
    """How much noise changes the photon ring and ordinary edges from frame to frame."""
    rows = [
        [
            each.ring_samples,
            f"{each.samples:.1f}",
            f"{each.ring:.4f} ± {each.ring_error:.4f}",
            f"{each.edge:.4f} ± {each.edge_error:.4f}",
        ]
        for each in results
    ]
    head = ["photon ring samples", "samples a pixel", "photon ring", "mesh edges"]
    return "## Flicker of an animation, over the contrast\n\n" + table(head, rows)


def sky_section(by: str, results: list[bench_sky.SkyFlicker]) -> str:
    """How much noise changes the light of a starry image from frame to frame."""
    rows = [
        [
            "on" if each.sky_filter else "off",
            f"{100 * each.picture:.2f} ± {100 * each.picture_error:.2f} %",
            f"{100 * each.squares:.0f} %",
        ]
        for each in results
    ]
    head = ["sky filter", "the whole picture", "4 x 4 pixels"]
    return f"## Flicker of an image of the sky by {by}, over its light, 16 samples\n\n" + table(head, rows)


def stars_section(way: str, results: list[bench_lens_stars.StarFlicker]) -> str:
    """How much noise changes the light of stars from frame to frame in Cycles, where the engine's have none."""
    rows = [
        [
            each.samples,
            "on" if each.sky.sky_filter else "off",
            f"{100 * each.sky.picture:.2f} ± {100 * each.sky.picture_error:.2f} %",
            f"{100 * each.sky.squares:.0f} %",
            f"{100 * each.star:.1f} %",
            f"{100 * each.pops:.1f} % of {each.images}",
            f"{each.light:.4f} ± {each.light_error:.4f}",
        ]
        for each in results
    ]
    head = [
        "samples",
        "sky filter",
        "the whole picture",
        "4 x 4 pixels",
        "a single image",
        "pops",
        "light over the engine's",
    ]
    return f"## Flicker of stars {way} in Cycles, over their light\n\n" + table(head, rows)


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=OUTPUT, help="folder")
    parser.add_argument("--relay-full-hd", action="store_true", help="1920 x 1080 by the relay camera: minutes more")
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")

    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})  # one core for all but the room
    log.info("rays")
    y = bench_trace.yardstick_time(HERE / "kerr_yardstick.c")
    ordinary, hard = list(bench_trace.ordinary()), list(bench_trace.hard())
    log.info("tables")
    tables, lookups = bench_table.report(y)
    log.info("connections")
    sections = [rays_section(ordinary, hard, y), "## Deflection tables\n\n" + tables, connect_section()]
    log.info("intersections")
    sections.append(intersect_section())
    log.info("room")
    os.sched_setaffinity(0, cores)
    sections.append(room_section(bench_room.measure()))
    log.info("viewport")
    sections.append(viewport_section(bench_viewport.measure()))
    log.info("lens")
    sections.append(lens_section(bench_lens.measure()))
    sections.append(lens_sky_section(bench_lens_sky_time.measure()))
    log.info("relay camera")
    resolution = bench_relay.FULL_HD if args.relay_full_hd else bench_relay.RESOLUTION
    cases = [case for case in bench_relay.CASES if case.always or args.relay_full_hd]
    costs = {case.name: bench_relay.measure(case, resolution) for case in cases}
    sections.append(relay_section(costs, resolution))
    log.info("lights")
    sections.append(lights_section(bench_lights.measure_all()))
    log.info("flicker")
    sections.append(flicker_section(bench_flicker.measure()))
    log.info("sky")
    sections.append(sky_section("the engine", bench_sky.measure()))
    sections.append(sky_section("lenses in Cycles", bench_lens_sky.measure()))
    sections.append(sky_section("the relay camera", bench_lens_sky.measure(relay=True)))
    sections.append(stars_section("through lenses", bench_lens_stars.measure()))
    sections.append(
        stars_section("by the relay camera", bench_lens_stars.measure(settings=((16, 0.0), (16, 1.0)), relay=True))
    )

    args.output.mkdir(parents=True, exist_ok=True)
    head = f"# Bentlight, measured\n\n{date.today()}, {processor()}, {bentlight_native.instruction_set()}.\n"
    (args.output / "rays.svg").write_text(rays_chart(ordinary, hard, lookups))
    (args.output / "bench.md").write_text("\n".join([head, *sections]))
    log.info("%s", args.output / "bench.md")


if __name__ == "__main__":
    main()
