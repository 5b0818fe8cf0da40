"""Light linking: which objects a lamp lights, and which hold its light up, as sets of the core.

An object may name a collection of receivers and one of blockers. A collection whose entries say "Include" holds those
entries alone, one without any holds all objects but those that are excluded. Objects that are in the same collections
form a set, of which there can be 64.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy
from bentlight_native import Influence

from ..report import Reporter

_SETS = 64
_ALL = 2**_SETS - 1


class LightLinking:
    """The sets of a scene's objects."""

    def __init__(self, objects: Iterable[bpy.types.Object], reporter: Reporter) -> None:
        objects = list(objects)
        self._receivers = _Links([o.light_linking.receiver_collection for o in objects], objects, reporter)
        self._blockers = _Links([o.light_linking.blocker_collection for o in objects], objects, reporter)

    def influence(self, obj: bpy.types.Object) -> Influence:
        """Whom an object lights, if it shines."""
        linking = obj.light_linking
        return Influence(
            self._receivers.mask_of(linking.receiver_collection), self._blockers.mask_of(linking.blocker_collection)
        )

    def sets_of(self, obj: bpy.types.Object) -> tuple[int, int]:
        """The set of receivers and that of blockers that an object is in."""
        return self._receivers.set_of(obj), self._blockers.set_of(obj)


class _Links:
    def __init__(self, collections: list, objects: list[bpy.types.Object], reporter: Reporter) -> None:
        self._members = {c.name_full: _Members(c) for c in collections if c}
        self._sets: dict[frozenset[str], int] = {}
        for obj in objects if self._members else ():
            signature = self._signature(obj)
            if signature not in self._sets and len(self._sets) == _SETS:
                reporter.warn("Light linking: more than {} combinations of collections; some lights go astray", _SETS)
                break
            self._sets.setdefault(signature, len(self._sets))

    def _signature(self, obj: bpy.types.Object) -> frozenset[str]:
        return frozenset(name for name, members in self._members.items() if members.has(obj))

    def set_of(self, obj: bpy.types.Object) -> int:
        return self._sets.get(self._signature(obj), 0) if self._members else 0

    def mask_of(self, collection: bpy.types.Collection | None) -> int:
        if collection is None:
            return _ALL
        return sum(1 << index for signature, index in self._sets.items() if collection.name_full in signature)


class _Members:
    def __init__(self, collection: bpy.types.Collection) -> None:
        self._included: set[str] = set()
        self._excluded: set[str] = set()
        entries = zip(collection.objects, collection.collection_objects, strict=True)
        for obj, entry in entries:
            self._add(entry, [obj])
        for child, entry in zip(collection.children, collection.collection_children, strict=True):
            self._add(entry, child.all_objects)

    def _add(self, entry: bpy.types.CollectionObject | bpy.types.CollectionChild, objects: Iterable) -> None:
        into = self._included if entry.light_linking.link_state == "INCLUDE" else self._excluded
        into.update(obj.name_full for obj in objects)

    def has(self, obj: bpy.types.Object) -> bool:
        name = obj.original.name_full
        return name not in self._excluded and (name in self._included or not self._included)
