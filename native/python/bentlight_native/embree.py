"""Finding Embree 4, the ray-triangle library that Blender ships."""

from __future__ import annotations

import glob
import importlib.util
import os
import sys
from collections.abc import Iterable

from . import _core

_FILE_PATTERNS = {
    "win32": ("embree4.dll",),
    "darwin": ("libembree4*.dylib",),
}.get(sys.platform, ("libembree4*.so*",))


def _package_folders() -> list[str]:
    """Folders of installed packages that carry Embree: the bpy wheel's, Blender's own, and embreex's."""
    folders = []
    for name, beside in (("bpy", ("lib", "")), ("embreex", (os.path.join("..", "embreex.libs"), ""))):
        module = sys.modules.get(name)
        origin = getattr(module, "__file__", None)
        if module is None:
            spec = importlib.util.find_spec(name)
            origin = spec.origin if spec else None
        if origin:
            folders += [os.path.join(os.path.dirname(os.path.abspath(origin)), folder) for folder in beside]
    binary = getattr(getattr(sys.modules.get("bpy"), "app", None), "binary_path", "")
    if binary:
        root = os.path.dirname(os.path.realpath(binary))
        folders += [
            os.path.join(root, "lib"),
            os.path.join(root, "blender.shared"),
            os.path.normpath(os.path.join(root, "..", "Resources", "lib")),
        ]
    return folders


def embree_candidates() -> list[str]:
    """Files and names to try, best first: Blender's own copy, embreex's, then the system's (Debian: libembree4-4)."""
    files = [
        file
        for folder in _package_folders()
        for pattern in _FILE_PATTERNS
        for file in sorted(glob.glob(os.path.join(folder, pattern)))
    ]
    return [*files, "libembree4.so.4", "libembree4.4.dylib", "embree4.dll"]


def load_embree(paths: Iterable[str] | None = None) -> None:
    """Bind Embree 4, once: a copy already loaded by the process, else the first of `paths` that works.

    Without `paths`, embree_candidates() are tried. Does nothing after the first success. Raises OSError, which names
    all that was tried, when no Embree 4 is found or only another version.
    """
    if _core.embree_copy()[0] is None:
        _core.load_embree(list(embree_candidates() if paths is None else paths))


def embree_version() -> tuple[str, str]:
    """Version of the Embree in use, e.g. "4.4.0", and where it came from. Loads it if need be."""
    load_embree()
    return _core.embree_copy()
