"""Where things are a frame before and a frame after: what motion vectors are told from. No bpy here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator

import bentlight_native
import numpy as np

from . import native
from .change import same
from .scene_data import InstanceData, SceneData


def set_motion(scene: bentlight_native.Scene, frame: SceneData, before: SceneData, after: SceneData) -> None:
    """Tells a native scene, built from `frame`, where things are in the frames around. Raises RenderError where those
    cannot be seen."""
    scene.set_motion(_moment(frame, before), _moment(frame, after))


def _moment(frame: SceneData, other: SceneData) -> bentlight_native.Moment:
    """Things that are not there at the other moment stand, and shapes of another number of vertices do not change."""
    native.check_camera(other.spacetimes, other.camera)
    view = bentlight_native.Scene()
    native.set_spacetimes(view, other.spacetimes)
    native.set_camera(view, other.camera)
    view.commit()
    there = dict(_by_identity(other))
    places, vertices = [], [None] * len(frame.meshes)
    for identity, instance in _by_identity(frame):
        moved = there.get(identity)
        places.append((moved or instance).world_from_mesh)
        if moved:
            old, new = frame.meshes[instance.mesh], other.meshes[moved.mesh]
            if old.vertices.shape == new.vertices.shape and not same(old.vertices, new.vertices):
                vertices[instance.mesh] = new.vertices
    return bentlight_native.Moment(view, np.array(places), vertices)


def _by_identity(scene: SceneData) -> Iterator[tuple[Hashable, InstanceData]]:
    """Instances by what tells them apart at all times: names, the number that Blender gives each of those that are
    scattered, and how many alike came before."""
    seen: Counter[tuple[str, str, float]] = Counter()
    for instance in scene.instances:
        identity = instance.name, instance.carrier, instance.random
        yield (*identity, seen[identity]), instance
        seen[identity] += 1
