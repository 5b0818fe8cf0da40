"""What motion vectors are told from: instances of three frames, matched by what they are, not by their order."""

from types import SimpleNamespace

import numpy as np

from blender_addon.sync.motion import set_motion
from blender_addon.sync.scene_data import CameraData, InstanceData, MeshData, SceneData

CAMERA = CameraData("PERSPECTIVE", np.eye(4), 4, 3, (-1.0, 1.0, -1.0, 1.0), 0.1, 100.0)
TRIANGLE = np.array([[0, 1, 2]], np.uint32)


def mesh(height: float, count: int = 3) -> MeshData:
    return MeshData(np.array([(i, i % 2, height) for i in range(count)], np.float32), TRIANGLE)


def placed(x: float, mesh: int, **settings) -> InstanceData:
    matrix = np.eye(4)
    matrix[0, 3] = x
    return InstanceData(**{"name": "Leaf", **settings}, mesh=mesh, world_from_mesh=matrix)


def moments(frame: SceneData, before: SceneData, after: SceneData) -> list:
    """What a native scene is told."""
    told = []
    set_motion(SimpleNamespace(set_motion=lambda *given: told.extend(given)), frame, before, after)
    return told


def places(moment) -> list[float]:
    return [float(matrix[0, 3]) for matrix in moment.world_from_mesh]


def test_scattered_instances_keep_their_number():
    """One of a flock falls away before, all are listed otherwise after: each is found again by its random number."""
    frame = SceneData(CAMERA, [mesh(0)], [placed(i, 0, carrier="Tree", random=i / 4) for i in range(3)])
    before = SceneData(CAMERA, [mesh(0)], [placed(10 + i, 0, carrier="Tree", random=i / 4) for i in (1, 2)])
    after = SceneData(CAMERA, [mesh(0)], [placed(20 + i, 0, carrier="Tree", random=i / 4) for i in (2, 0, 1)])
    told = moments(frame, before, after)
    assert [places(moment) for moment in told] == [[0, 11, 12], [20, 21, 22]]
    assert all(moment.vertices == [None] for moment in told)


def test_shapes_are_told_where_they_changed_and_kept_their_vertices():
    meshes = [mesh(0), mesh(0), mesh(0)]
    names = ("Stiff", "Soft", "Growing")
    frame = SceneData(CAMERA, meshes, [placed(0, i, name=name) for i, name in enumerate(names)])
    other = SceneData(
        CAMERA,
        [mesh(0, 4), mesh(0.5), mesh(0)],
        [placed(0, i, name=name) for i, name in ((0, "Growing"), (1, "Soft"), (2, "Stiff"))],
    )
    (before, _) = moments(frame, other, frame)
    assert before.vertices[0] is None and before.vertices[2] is None
    assert np.array_equal(before.vertices[1], other.meshes[1].vertices)
