"""Where the Cycles bridge keeps what it makes. No .blend file depends on it: whatever is missing is made again."""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
from bentlight_native import write_exr

from ..report import RenderError

_PACKAGE = __package__.rpartition(".")[0]
_KEPT_S = 30 * 24 * 3600.0
_PASSING = 8  # files of images that change from frame to frame


def named_by_content(stem: str, pixels: np.ndarray) -> Path:
    """(height, width, channels) float16 or float32, top row first, as an image in the folder of the tables.

    Made if missing; those of the same stem that nobody has asked for in a month are removed then. Raises RenderError if
    it cannot be written.
    """
    path, is_new = _written(folder("tables"), stem, pixels)
    if is_new:
        _remove([old for old in path.parent.glob(f"{stem}_*.exr") if time.time() - _asked_for(old) > _KEPT_S])
    return path


def passing(stem: str, pixels: np.ndarray) -> Path:
    """As named_by_content, for what is another image in the next frame: in this Blender's own folder, where the last
    few of the same stem stay that were asked for."""
    path, is_new = _written(Path(bpy.app.tempdir), stem, pixels)
    if is_new:
        _remove(sorted(path.parent.glob(f"{stem}_*.exr"), key=_asked_for)[:-_PASSING])
    return path


def _written(where: Path, stem: str, pixels: np.ndarray) -> tuple[Path, bool]:
    """The image, and whether it was missing."""
    path = where / f"{stem}_{hashlib.sha256(pixels.tobytes()).hexdigest()[:16]}.exr"
    if path.is_file():
        with contextlib.suppress(OSError):  # another user's
            os.utime(path)
        return path, False
    try:
        write_exr(path, {f"{i:02}": pixels[..., i] for i in range(pixels.shape[-1])}, {})
    except OSError as error:
        raise RenderError("'{}' cannot be written: {}", path.name, error) from None
    return path, True


def _asked_for(path: Path) -> float:
    """When it was, in seconds; now, if another Blender has been quicker and removed it."""
    try:
        return path.stat().st_mtime
    except OSError:
        return time.time()


def _remove(paths: list[Path]) -> None:
    for path in paths:
        with contextlib.suppress(OSError):
            path.unlink()


def folder(name: str) -> Path:
    """The folder `name` of this user, for this extension; made if it is missing."""
    try:
        path = bpy.utils.extension_path_user(_PACKAGE, path=name, create=True)
    except ValueError:  # registered from a checkout, not installed
        path = bpy.utils.user_resource("DATAFILES", path=f"bentlight/{name}", create=True)
    chosen = Path(path or Path(tempfile.gettempdir(), "bentlight", name))
    chosen.mkdir(parents=True, exist_ok=True)
    return chosen
