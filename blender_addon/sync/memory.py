"""What was read from Blender and need not be read again, while a viewport is open: meshes, and pixels of images.

A full reading with a memory gives what one without gives. No bpy here: Blender's data comes in as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from .attributes import AttributeKey
from .scene_data import MeshData


class Memory:
    """Of one depsgraph. Between two readings `forget` must be told of every update; `begin` starts a reading."""

    def __init__(self) -> None:
        self._meshes: dict[Hashable, MeshData | None] = {}
        self._images: dict[str, Any] = {}
        self._seen: set[Hashable] = set()

    def forget(self, updates: Any) -> None:
        """Forgets what depsgraph.updates names."""
        for update in updates:
            kind, name = type(update.id).__name__, update.id.name_full
            if kind == "Image":
                self._images.pop(name, None)
            elif update.is_updated_geometry:
                for key in [key for key in self._meshes if key[0] == name]:
                    del self._meshes[key]

    def begin(self) -> None:
        """Drops what the last reading had no use for: Blender may have put something else in its place."""
        self._meshes = {key: data for key, data in self._meshes.items() if key in self._seen}
        self._seen = set()

    def mesh(self, obj: Any, wanted: dict[int, AttributeKey], read: Callable[[], MeshData | None]) -> MeshData | None:
        """An evaluated object's mesh with the wanted attributes; None if there is nothing of it.

        By object and data: two objects that share data do not share what is remembered, but data that is new in the
        place of old data is never taken for it, as its object is new or was updated.
        """
        key = (obj.name_full, obj.data.as_pointer(), tuple(sorted(wanted.items())))
        if key not in self._meshes:
            self._meshes[key] = read()
        self._seen.add(key)
        return self._meshes[key]

    def image(self, image: Any, read: Callable[[], Any]) -> Any:
        """The pixels of an image, as images.py has them. Those of moving images change without an update."""
        if image.source in {"SEQUENCE", "MOVIE"}:
            return read()
        name = image.name_full
        if name not in self._images:
            self._images[name] = read()
        return self._images[name]
