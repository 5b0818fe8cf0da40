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


def named_by_content(stem: str, pixels: np.ndarray) -> Path:
    """(height, width, channels) float16 or float32, top row first, as an image in the folder of the tables.

    Made if missing; those of the same stem that nobody has asked for in a month are removed then. Raises RenderError if
    it cannot be written.
    """
    path = folder("tables") / f"{stem}_{hashlib.sha256(pixels.tobytes()).hexdigest()[:16]}.exr"
    if path.is_file():
        with contextlib.suppress(OSError):  # another user's
            os.utime(path)
        return path
    try:
        write_exr(path, {f"{i:02}": pixels[..., i] for i in range(pixels.shape[-1])}, {})
    except OSError as error:
        raise RenderError("'{}' cannot be written: {}", path.name, error) from None
    _remove_old(path.parent, stem)
    return path


def _remove_old(where: Path, stem: str) -> None:
    for path in where.glob(f"{stem}_*.exr"):
        with contextlib.suppress(OSError):  # another Blender may have been quicker
            if time.time() - path.stat().st_mtime > _KEPT_S:
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
