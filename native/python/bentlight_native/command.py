"""The command `bentlight`: merges parts of pictures that several machines have rendered.

Run as `bentlight`, `python -m bentlight_native`, or in Blender `blender --command bentlight`.
"""

import argparse
import sys
from collections.abc import Sequence

from .parts import Part, PartError, merge, read_part, write_part, write_picture


def run_command(arguments: Sequence[str] | None = None) -> int:
    """Do what the arguments (None: the program's own) say; returns the exit status: 0, or 1 with an error printed."""
    options = _parser().parse_args(arguments)
    try:
        wholes = _merge(options.parts)
        missing = sum(part.missing() for part in wholes)
        if missing and not (options.part or options.incomplete):
            raise PartError(f"{missing} pixel samples are missing; --incomplete makes a picture of what there is")
        if options.part:
            if len(wholes) > 1:
                raise PartError("parts of several layers or views do not fit into one part; merge each by itself")
            write_part(options.output, wholes[0])
        else:
            write_picture(options.output, wholes)
    except (PartError, OSError, MemoryError) as error:
        sys.stderr.write(f"bentlight: {error or type(error).__name__}\n")
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bentlight", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    command = commands.add_parser("merge", help="make one picture of its parts", description=_merge.__doc__)
    command.add_argument("parts", nargs="+", metavar="PART", help="files that --bentlight-samples or -tile made")
    command.add_argument("-o", "--output", required=True, help="the OpenEXR file to write, with all passes")
    kind = command.add_mutually_exclusive_group()
    kind.add_argument("--part", action="store_true", help="write a part again, to be merged with others later")
    kind.add_argument("--incomplete", action="store_true", help="write a picture even if samples are missing")
    return parser


def _merge(paths: Sequence[str]) -> list[Part]:
    """Merges parts of a picture, each weighed by its samples, bit for bit as if one machine had rendered it."""
    groups: dict[tuple[str, str], Part] = {}
    for path in paths:
        part = read_part(path)
        key = part.picture.layer, part.picture.view
        if key not in groups:
            groups[key] = part
            continue
        if part.picture.scene != groups[key].picture.scene:
            sys.stderr.write(f"bentlight: warning: {path}: the scene is not to the last bit that of the others\n")
        try:
            groups[key] = merge((groups[key], part))
        except PartError as error:
            raise PartError(f"{path}: {error}") from None
    return list(groups.values())
