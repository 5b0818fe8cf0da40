"""Where things are in the frames before and after: what the channel 'vector' is told from.

`MotionMethods` gives its method to `Scene`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core


class Moment(NamedTuple):
    """Another moment of a scene.

    view: a committed scene with the camera and the spacetime objects of the moment; nothing else of it matters.
    world_from_mesh: (n, 4, 4), of the instances, in the order in which they were added; the rest stand.
    vertices: for each mesh (m, 3) float32, as many as it has, or None for the same; the rest are the same.
    """

    view: _core.Scene
    world_from_mesh: ArrayLike = ()
    vertices: Sequence[NDArray[np.float32] | None] = ()


class MotionMethods:
    """The method of `Scene` that concerns motion."""

    def set_motion(self, before: Moment | None = None, after: Moment | None = None) -> None:
        """Say where things are a frame before and after; without, they are unknown and 'vector' is 0. Takes no commit.

        The scene must have its meshes and instances. Their views must not be edited as long as it is rendered.
        """
        if before is None or after is None:
            self._set_motion(None, None)
            self._views = ()
            return
        self._set_motion(*map(_arguments, (before, after)))
        self._views = (before.view, after.view)  # which the core does not keep alive


def _arguments(moment: Moment) -> tuple:
    matrices = np.ascontiguousarray(moment.world_from_mesh, dtype=np.float64).reshape(-1, 4, 4)
    vertices = [None if v is None else np.ascontiguousarray(v, dtype=np.float32) for v in moment.vertices]
    return moment.view, matrices, vertices
