"""The images of deflection angles that lenses look up: two a kind of space, the same for all masses and radii.

They lie in the extension's user folder and are made where they are missing or damaged, in a fifth of a second.
"""

from __future__ import annotations

import contextlib
import functools
import logging
from pathlib import Path

import bentlight_native

from ..report import RenderError
from . import files

log = logging.getLogger(__name__)


def paths(kind: str) -> tuple[Path, Path]:
    """Images of the total and of the outward angles, for kind 'schwarzschild' or 'ellis'. May not be there yet."""
    return tuple(
        files.folder("tables") / f"{kind}_{name}_{bentlight_native.MAP_VERSION}.exr" for name in ("total", "outward")
    )


def ensured(kind: str) -> tuple[Path, Path]:
    """The same, made if they are missing."""
    found = paths(kind)
    if not all(path.is_file() for path in found):
        _bake(kind)
    return found


def check() -> None:
    """Removes images that are damaged, so that they are made anew."""
    for kind in ("schwarzschild", "ellis"):
        found = paths(kind)
        if all(path.is_file() for path in found):
            try:
                bentlight_native.SampledTable.read(_unit(kind), *found)
            except (OSError, ValueError) as error:
                log.warning("%s; made anew", error)
                for path in found:
                    with contextlib.suppress(OSError):
                        path.unlink()


def _unit(kind: str) -> bentlight_native.Spacetime:
    return getattr(bentlight_native.Spacetime, kind)(1.0)


@functools.cache
def _sampled(kind: str) -> bentlight_native.SampledTable:
    return bentlight_native.SampledTable.from_table(bentlight_native.DeflectionTable(_unit(kind)))


def _bake(kind: str) -> None:
    table = _sampled(kind)
    try:
        table.write(*paths(kind))
    except OSError as error:
        raise RenderError("Deflection tables cannot be written: {}", error) from None
    log.info("deflection tables of %s: error %.1g rad at most", kind, max(table.measured))
