"""Attributes of meshes and instances: what is refused, and which one counts."""

import numpy as np
import pytest
from bentlight_native import ProgramBuilder
from scenes import look_at, new_scene, perspective, quad, render

VALUES = np.ones((2, 3, 3), np.float32)


@pytest.mark.parametrize(
    ("mesh", "attribute", "values"),
    [
        (1, 0, VALUES),
        (0, -1, VALUES),
        (0, 0, VALUES[:1]),
        (0, 0, VALUES[..., :0]),
        (0, 0, np.ones((2, 3, 5), np.float32)),
        (0, 0, VALUES * np.float32(np.nan)),
        (0, 0, VALUES[:, :2]),
    ],
)
def test_bad_attributes_are_refused(mesh, attribute, values):
    scene = new_scene()
    scene.add_mesh(*quad())
    with pytest.raises(ValueError):
        scene.set_mesh_attribute(mesh, attribute, values)


def test_an_instance_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="no instance 0"):
        new_scene().set_instance_attribute(0, 0, (1, 2, 3, 4))


def test_the_mesh_counts_before_the_instance_and_the_last_value_before_the_first():
    scene, builder = new_scene(), ProgramBuilder()
    for number in (3, 7):
        color = builder.emit("attribute", immediates=(number,))[0]
        builder.emit("emission", builder.constant(1), color, builder.constant(1))
    index = scene.add_mesh(*quad())
    instance = scene.add_instance(index, np.eye(4), materials=np.array([scene.add_material(builder.build())], np.int32))
    scene.set_mesh_attribute(index, 3, 9 * VALUES)
    scene.set_mesh_attribute(index, 3, VALUES * np.array([1, 2, 4], np.float32))
    scene.set_instance_attribute(instance, 3, (50, 50, 50, 1))
    scene.set_instance_attribute(instance, 7, (0.25, 0.5, 0.75, 1))
    perspective(scene, look_at((0, 0, 1), (0, 0, 0), up=(0, 1, 0)), half=0.1)
    scene.commit()
    image = render(scene, 2, 2, 1, names=("combined",))[0]["combined"][..., :3]
    np.testing.assert_allclose(image, np.broadcast_to([1.25, 2.5, 4.75], (2, 2, 3)), rtol=1e-6)
