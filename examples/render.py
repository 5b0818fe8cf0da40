"""Renders any .blend file without a window: render.py FILE.blend -o OUT.png|OUT.exr [--engine BENTLIGHT|CYCLES] ...

Exit codes: 0 the picture is complete; 1 it could not be rendered (the reason is on the last line); 2 wrong arguments.
A .exr holds every pass of the first view layer's render; a .png the picture as the scene's color management shows it.
The output appears under its name only when it is complete.
"""

import argparse
import logging
import sys
from pathlib import Path

import bpy
import common

log = logging.getLogger("bentlight.render")


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    """Reads the command line."""
    parser = argparse.ArgumentParser(prog="render.py", description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, metavar="FILE.blend")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.png|OUT.exr")
    parser.add_argument("--engine", help="BENTLIGHT, CYCLES ...; default: what the file says")
    parser.add_argument("--frame", type=int, help="default: the file's current frame")
    parser.add_argument("--samples", type=common.positive, help="light paths a pixel")
    parser.add_argument("--resolution", type=common.resolution, metavar="WxH")
    args = parser.parse_args(arguments)
    if args.output.suffix not in common.FORMATS:
        parser.error(f"{args.output}: the output's name must end in {' or '.join(common.FORMATS)}")
    return args


def render_file(args: argparse.Namespace) -> None:
    """Opens the file, applies what the command line overrides, and renders. Raises RuntimeError with the reason."""
    if not args.file.is_file():
        raise RuntimeError(f"{args.file}: no such file")
    common.register()
    bpy.ops.wm.open_mainfile(filepath=str(args.file.resolve()))
    scene = bpy.context.scene
    if args.engine:
        try:
            scene.render.engine = args.engine
        except TypeError as error:
            raise RuntimeError(f"unknown engine {args.engine!r}") from error
    if args.samples:
        scene.bentlight.samples = scene.cycles.samples = args.samples
    if args.resolution:
        scene.render.resolution_x, scene.render.resolution_y = args.resolution
        scene.render.resolution_percentage = 100
    if args.frame is not None:
        scene.frame_set(args.frame)
    if scene.camera is None:
        raise RuntimeError(f"{args.file}: the scene {scene.name!r} has no camera")
    common.render(scene, args.output.resolve())


def main() -> int:
    """Runs the command line; returns the exit code."""
    args = parse()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    try:
        render_file(args)
    except (RuntimeError, OSError) as error:
        log.error("render.py: %s", error)
        return 1
    log.info("%s", args.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
