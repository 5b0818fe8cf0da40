"""Where the Cycles bridge keeps what it makes. No .blend file depends on it: whatever is missing is made again."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy

_PACKAGE = __package__.rpartition(".")[0]


def folder(name: str) -> Path:
    """The folder `name` of this user, for this extension; made if it is missing."""
    try:
        path = bpy.utils.extension_path_user(_PACKAGE, path=name, create=True)
    except ValueError:  # registered from a checkout, not installed
        path = bpy.utils.user_resource("DATAFILES", path=f"bentlight/{name}", create=True)
    chosen = Path(path or Path(tempfile.gettempdir(), "bentlight", name))
    chosen.mkdir(parents=True, exist_ok=True)
    return chosen
