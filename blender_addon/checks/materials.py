"""What of materials and the world cannot be rendered as it is: compiles them as a render does, but for their images."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import bpy

from ..report import RenderError
from ..sync.images import ImageTable, Pixels
from ..sync.material import compile_material, compile_world
from .finding import Finding

# What changes every now and then without changing any material.
_HARMLESS = {
    "Scene",
    "Object",
    "Mesh",
    "Camera",
    "PointLight",
    "AreaLight",
    "SunLight",
    "SpotLight",
    "Collection",
    "Action",
}


class _NoPixels(ImageTable):
    """Images are not read: nothing is rendered."""

    def index_of(self, image: Any, warn: Callable[[str], None]) -> int:
        """Any index."""
        return 0

    def tiles_of(self, image: Any, warn: Callable[[str], None]) -> tuple[int, list[int]]:
        """Any index, and the tiles' numbers."""
        return 0, [tile.number for tile in image.tiles]

    def index_of_made(self, key: Hashable, make: Callable[[], Pixels]) -> int:
        """Any index."""
        return 0


class MaterialChecks:
    """Remembers each material's warnings until it may have changed."""

    def __init__(self) -> None:
        self._warnings: dict[tuple[str, str], list[str]] = {}

    def forget(self, depsgraph: bpy.types.Depsgraph | None) -> None:
        """After a change; see changes.listen."""
        kinds = {type(update.id).__name__ for update in depsgraph.updates} if depsgraph else set()
        if not kinds or kinds - _HARMLESS:
            self._warnings.clear()

    def findings(self, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> list[Finding]:
        """Of all materials of rendered objects, and of the world."""
        override = view_layer.material_override
        used = {
            slot.material.name_full: slot.material
            for obj in view_layer.objects
            if not obj.hide_render and obj.bentlight.made_for_cycles == "NOTHING"
            for slot in obj.material_slots
            if slot.material is not None
        }
        materials = [override] if override else list(used.values())
        found = [
            _finding(text, "MATERIAL", material.name)
            for material in materials
            for text in self._of("MATERIAL", material, compile_material)
        ]
        if scene.world is not None:
            found += [
                _finding(text, "WORLD", scene.world.name) for text in self._of("WORLD", scene.world, compile_world)
            ]
        return found

    def _of(self, kind: str, owner: bpy.types.ID, compile_: Callable) -> list[str]:
        key = kind, owner.name_full
        if key not in self._warnings:
            try:
                self._warnings[key] = compile_(owner, _NoPixels()).warnings
            except RenderError as error:
                self._warnings[key] = [str(error)]
        return self._warnings[key]


def _finding(text: str, kind: str, owner: str) -> Finding:
    """With the node that the warning names: Compiler.warn writes "OWNER, node 'NAME': ..."."""
    _, found, rest = text.partition(f"'{owner}', node '")
    return Finding(text, kind, owner, node=rest.partition("': ")[0] if found else "")
