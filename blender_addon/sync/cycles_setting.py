"""Settings that Cycles' add-on, which users may switch off, has in Blender's data. No bpy here."""

from __future__ import annotations

from typing import Any


def cycles_setting(owner: Any, name: str, default: Any) -> Any:
    """A setting of an object or a lamp; Cycles' own default, which the caller knows, if its add-on is switched off."""
    return getattr(getattr(owner, "cycles", None), name, default)
