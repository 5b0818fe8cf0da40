"""Passes that say what a pixel shows, seen past a hole: by the core's own rays to the surfaces that they meet."""

import bpy
import numpy as np
import pytest
from bentlight_native import FATES, Scene, Spacetime

from blender_addon.sync.cryptomatte import name_as_float
from tests.engine import pass_scene, stage
from tests.engine.test_pass_values import NAMES
from tests.engine.test_passes_curved import DISTANCE, MASS, hole_before_the_camera, pixel_centers, slopes

# Squares across z: name, size, middle, index of the object, index of its material. The wall is seen twice, too.
SQUARES = [
    ("Wall", 40.0, (0.3, 0.2, -8.0), 3, 11),
    ("Tile", 1.2, (1.5, 0.4, 1.5), 5, 12),
    ("Back", 3.0, (0, 0, -4), 7, 13),
]
SPACES = {
    "schwarzschild": ({}, Spacetime.schwarzschild(MASS, "isotropic")),
    "kerr": ({"spin": 0.9}, Spacetime.kerr(MASS, 0.9 * MASS)),
}
REACH = 0.03  # in pixels: rays of a pixel are up to half of its filter, 0.015, from its middle across and up
MIST = 8.0, 14.0  # start and depth


def material(name: str, index: int) -> bpy.types.Material:
    """Shines; tells AOVs its place in the world."""
    made = stage.emission((0.5, 0.6, 0.7), name=name)
    made.pass_index = index
    nodes, links = made.node_tree.nodes, made.node_tree.links
    place, node = nodes.new("ShaderNodeNewGeometry").outputs["Position"], nodes.new("ShaderNodeOutputAOV")
    node.aov_name = "place"
    links.new(place, node.inputs["Color"])
    return made


def build(**settings) -> None:
    """A hole before the camera, squares in front of it and behind."""
    scene = bpy.context.scene
    for name, size, middle, index, material_index in SQUARES:
        square = stage.add_square(size, middle, material(f"{name} paint", material_index), name)
        square.pass_index = index
        pass_scene.add_uv(square)
    hole_before_the_camera(**settings)
    layer, mist = scene.view_layers[0], scene.world.mist_settings
    for name in ("uv", "object_index", "material_index", "mist", "position", "normal", "cryptomatte_object"):
        setattr(layer, f"use_pass_{name}", True)
    layer.use_pass_cryptomatte_material = True
    layer.aovs.add().name = "place"
    mist.start, mist.depth, mist.falloff = *MIST, "LINEAR"
    scene.bentlight.tolerance = 1e-6


def traced(space: Spacetime) -> dict[str, np.ndarray]:
    """(48, 64, ...): what the rays through the middles of pixels meet, by index in SQUARES (-1: nothing); where; and
    how long they are."""
    core = Scene()
    for _name, size, middle, _index, _material in SQUARES:
        corners = size / 2 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) + middle
        mesh = core.add_mesh(corners.astype(np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
        core.add_instance(mesh, np.eye(4))
    core.set_spacetime(space, np.eye(4))
    core.commit()
    slope = slopes(pixel_centers()).reshape(-1, 2)
    rays = np.concatenate([slope, -np.ones((len(slope), 1))], axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    hits = core.intersect(np.tile([0.0, 0.0, DISTANCE], (len(rays), 1)), rays, 1e-6, angular_tolerance=1e-9)
    hit = hits["fate"] == FATES.index("hit")
    met = np.where(hit, hits["instance"], -1)
    return {
        "met": met.reshape(48, 64),
        "place": hits["position"].reshape(48, 64, 3),
        "length": hits["length"].reshape(48, 64),
    }


def same_around(met: np.ndarray) -> np.ndarray:
    """Pixels whose neighbors, too, show what they show."""
    found = np.ones(met.shape, bool)
    for axis in (0, 1):
        for step in (-1, 1):
            found &= np.roll(met, step, axis) == met
    return found


def steps(values: np.ndarray) -> np.ndarray:
    """(48, 64): how far values are from those of neighbors, at most; (48, 64, n)."""
    found = [np.abs(np.roll(values, step, axis) - values).max(axis=-1) for axis in (0, 1) for step in (-1, 1)]
    return np.max(found, axis=0)


@pytest.mark.parametrize("name", SPACES)
def test_passes_tell_what_bent_rays_meet(name, tmp_path):
    settings, space = SPACES[name]
    build(**settings)
    passes, truth = stage.render(tmp_path), traced(space)
    met = truth["met"]
    clear = same_around(met)
    on = clear & (met >= 0)
    assert [(on & (met == i)).sum() > 30 for i in range(len(SQUARES))] == [True] * len(SQUARES)
    assert clear.mean() > 0.8
    objects, materials = (np.array([0] + [square[i] for square in SQUARES]) for i in (3, 4))
    assert np.array_equal(passes[NAMES["object_index"]][..., 0][clear], objects[met + 1][clear])
    assert np.array_equal(passes[NAMES["material_index"]][..., 0][clear], materials[met + 1][clear])
    for kind, ending in (("Object", ""), ("Material", " paint")):
        numbers = np.float32([0.0] + [name_as_float(square[0] + ending) for square in SQUARES])
        assert np.array_equal(passes[f"Crypto{kind}00"][..., 0][clear], numbers[met + 1][clear])
        assert (passes[f"Crypto{kind}00"][..., 1][on] == 1).all()

    middles = np.array([square[2] for square in SQUARES])[met]
    uv = np.where(on[..., None], 0.5 + 0.2 * (truth["place"] - middles)[..., :2], 0)
    place = truth["place"]
    mist = np.where(met >= 0, np.clip((truth["length"] - MIST[0]) / MIST[1], 0, 1), 1)[..., None]
    compared = {"uv": uv, "position": place, "place": place, "mist": mist}
    for channel, expected in compared.items():
        seen = passes[NAMES.get(channel, channel)][..., : expected.shape[-1]]
        error, off = np.abs(seen - expected).max(axis=-1), REACH * steps(expected)
        assert (error < off + 2e-5)[on].all(), channel
    far = (truth["length"] / (DISTANCE - place[..., 2]))[on & (met == 0)]
    assert far.max() > 1.25 and mist[on].min() < 0.1, "rays are bent"
