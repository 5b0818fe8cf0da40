"""What moves while the shutter is open, slice by slice of its time. No bpy here.

Each slice has maps of its own, of the scene as it is in the slice's middle, while Cycles moves its objects on through
the slice. So rays may neither start their last leg behind where an object will be, nor miss where it comes from: the
core sees what moves also where it is at the slice's beginning and end, and legs start earlier there. Where space is
flat that is exact; else what comes into sight behind an object within a slice is seen by straight rays from there on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..sync.scene_data import CameraData, InstanceData, MeshData, SceneData
from ..sync.standing import by_key

_LEAST = 1e-6  # of an object's motion between slices, over its distance from the world's origin: less is rounding


@dataclass
class Slice:
    """A part of the shutter's time. number: from 0, of `count`. change: how the camera's matrix changes from its
    beginning to its end, (4, 4)."""

    number: int = 0
    count: int = 1
    change: np.ndarray = field(default_factory=lambda: np.zeros((4, 4)))


def camera_change(cameras: Sequence[CameraData], number: int) -> np.ndarray:
    """The change of a camera's matrix (4, 4) over slice `number`, from how it is in the middles of all slices."""
    matrices = [camera.world_from_camera for camera in cameras]
    return np.gradient(matrices, axis=0)[number] if len(matrices) > 1 else np.zeros((4, 4))


def swept(moments: Sequence[SceneData], number: int) -> tuple[SceneData, np.ndarray]:
    """The scene of slice `number` with what moves added as it is at the slice's beginning and end; and the largest
    motion of each instance between the middles of neighboring slices. Accretion disks, in which no leg ends, stand
    still in each slice."""
    here = moments[number]
    near = [by_key(moments[i]) if 0 <= i < len(moments) else {} for i in (number - 1, number + 1)]
    meshes, travel = list(here.meshes), []
    added: list[InstanceData] = []
    added_travel: list[float] = []
    for key, (instance, mesh) in by_key(here).items():
        others = [before_or_after[key] for before_or_after in near if key in before_or_after]
        moves = [] if instance.is_disk else [_motion(instance, mesh, *other) for other in others]
        farthest = max((move.distance for move in moves), default=0.0)
        travel.append(farthest)
        if farthest <= _LEAST * np.abs(instance.world_from_mesh[:3, 3]).max(initial=1.0):
            continue
        if len(moves) == 1:  # the first or the last slice: as if it went on
            moves.append(_Motion(-moves[0].turn, -moves[0].shape if moves[0].shape is not None else None, farthest))
        for move in moves:
            index = instance.mesh
            if move.shape is not None:
                index = len(meshes)
                meshes.append(MeshData((mesh.vertices + move.shape / 2).astype(np.float32), mesh.triangles))
            added.append(replace(instance, mesh=index, world_from_mesh=instance.world_from_mesh + move.turn / 2))
            added_travel.append(farthest)
    scene = replace(here, meshes=meshes, instances=[*here.instances, *added])
    return scene, np.array(travel + added_travel)


@dataclass
class _Motion:
    """To another moment: of the instance's matrix, of its mesh's vertices unless they stay, and the farthest way."""

    turn: np.ndarray
    shape: np.ndarray | None
    distance: float


def _motion(instance: InstanceData, mesh: MeshData, other: InstanceData, other_mesh: MeshData) -> _Motion:
    turn = other.world_from_mesh - instance.world_from_mesh
    same_points = mesh is other_mesh or mesh.vertices.shape != other_mesh.vertices.shape
    shape = None if same_points else other_mesh.vertices.astype(np.float64) - mesh.vertices
    if not turn.any() and shape is None:
        return _Motion(turn, None, 0.0)
    points = mesh.vertices @ turn[:3, :3].T + turn[:3, 3]
    if shape is not None:
        points = points + shape @ other.world_from_mesh[:3, :3].T
    return _Motion(turn, shape, float(np.linalg.norm(points, axis=1).max(initial=0.0)))
