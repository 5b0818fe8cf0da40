"""What passes tell things apart by: names, indices and light groups. No bpy here."""

from __future__ import annotations

from collections.abc import Sequence

import bentlight_native

from .cryptomatte import name_as_float
from .scene_data import SceneData, Visibility


def matte_names(data: SceneData, kind: str) -> set[str]:
    """All names in the mattes of a kind: 'object', 'material' or 'asset'."""
    if kind == "material":
        return {name for name, _ in data.material_labels if name}
    shown = [item for item in data.instances if not item.visibility & Visibility.IMMATERIAL]
    return {item.name if kind == "object" else item.asset for item in shown}


def group_index(name: str, light_groups: Sequence[str]) -> int:
    """The core's number of a light group; -1 if it has no pass."""
    return light_groups.index(name) if name in light_groups else -1


def set_labels(scene: bentlight_native.Scene, data: SceneData, light_groups: Sequence[str]) -> None:
    """Gives a native scene, built from `data`, its labels; light_groups: those with a pass."""

    def group(item: object) -> int:
        return group_index(item.light_group, light_groups)

    scene.set_labels(
        [(name_as_float(item.name), name_as_float(item.asset)) for item in data.instances],
        [(group(item), item.is_disk) for item in data.instances],
        [(name_as_float(name), index) for name, index in data.material_labels],
        [group(item) for item in data.lamps],
        [group(item) for item in data.suns],
        group_index(data.world_group, light_groups),
    )
