"""Paper that panels are drawn on where there is no window."""

from __future__ import annotations

from types import SimpleNamespace

import bpy

REGION = SimpleNamespace(width=297)  # pixels, at scale 1, of the Properties editor in Blender's first window, 1920 wide


class Paper:
    """A layout that keeps the labels that are drawn on it, and is every part of itself."""

    def __init__(self) -> None:
        self.labels: list[tuple[str, bool]] = []

    def label(self, text: str = "", translate: bool = True, **_options) -> None:
        self.labels.append((text, translate))

    def __getattr__(self, name: str):
        return lambda *_arguments, **_options: self

    def of(self, cls: type, context: bpy.types.Context) -> list[str]:
        """What a panel writes by itself: Blender translates all else."""
        self.draw(cls, context)
        return [text for text, translate in self.labels if not translate]

    def draw(self, cls: type, context: bpy.types.Context) -> None:
        """Lets a panel draw itself on this."""
        ours = [base for base in reversed(cls.__mro__) if base.__module__.startswith("blender_addon")]
        own = {name: value for base in ours for name, value in vars(base).items() if not name.startswith(("__", "bl_"))}
        cls.draw(type("Drawn", (), {**own, "layout": self, "column": lambda _: self})(), context)
