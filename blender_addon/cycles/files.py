"""Where the Cycles bridge keeps what it makes. No .blend file depends on it: whatever is missing is made again."""

from __future__ import annotations

import hashlib
import tempfile
from pathlib import Path

import bpy
import numpy as np
from bentlight_native import write_exr

_PACKAGE = __package__.rpartition(".")[0]


def named_by_content(stem: str, pixels: np.ndarray) -> Path:
    """(height, width, channels) float32 from the top as an image in the folder of the tables; made if missing."""
    path = folder("tables") / f"{stem}_{hashlib.sha256(pixels.tobytes()).hexdigest()[:16]}.exr"
    if not path.is_file():
        write_exr(path, {f"{i:02}": pixels[..., i] for i in range(pixels.shape[-1])}, {})
    return path


def folder(name: str) -> Path:
    """The folder `name` of this user, for this extension; made if it is missing."""
    try:
        path = bpy.utils.extension_path_user(_PACKAGE, path=name, create=True)
    except ValueError:  # registered from a checkout, not installed
        path = bpy.utils.user_resource("DATAFILES", path=f"bentlight/{name}", create=True)
    chosen = Path(path or Path(tempfile.gettempdir(), "bentlight", name))
    chosen.mkdir(parents=True, exist_ok=True)
    return chosen
