"""Cryptomatte: names as numbers, and what Blender's own node makes of our layers, from a render and from files."""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest
from bentlight_native import run_command

from blender_addon.sync.cryptomatte import murmur_hash, name_as_float
from examples.compositor import new_tree
from tests.engine import pass_scene, stage
from tests.engine.cycles_pictures import NARROW

INDEX, MATERIAL_INDEX = ("Object Index", "Material Index") if bpy.app.version >= (5, 0, 0) else ("IndexOB", "IndexMA")
FLOOR, BALL, KNOB, PANE, GLOW = OBJECTS = range(1, 6)


@pytest.fixture
def scene() -> bpy.types.Scene:
    """The scene of all passes, with an index for each object, mattes of all kinds, and pixels that are points."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 60, 42
    pass_scene.build()
    for index, name in zip(OBJECTS, ("Floor", "Ball", "Knob", "Pane", "Glow"), strict=True):
        bpy.data.objects[name].pass_index = index
    bpy.data.materials["Pane"].node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 1.0
    layer = scene.view_layers[0]
    layer.use_pass_object_index = layer.use_pass_material_index = True
    layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = layer.use_pass_cryptomatte_asset = True
    scene.bentlight.samples, scene.bentlight.pixel_filter, scene.render.filter_size = 1, "GAUSSIAN", NARROW
    return scene


def matte_of(layer: str, name: str, folder: Path, file: Path | None = None) -> np.ndarray:
    """(height, width): what the compositor's node makes of a layer of the scene's render, or of a file."""
    scene = bpy.context.scene
    tree, output = new_tree(scene, "Matte")
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    if file:
        node.source, node.image = "IMAGE", bpy.data.images.load(str(file))
    else:
        node.source, node.scene = "RENDER", scene
    node.layer_name, node.matte_id = f"ViewLayer.{layer}", name
    assert (node.layer_name, node.matte_id) == (f"ViewLayer.{layer}", name), "the node knows the layer"
    tree.links.new(node.outputs["Matte"], output.inputs[0])
    stage.set_multilayer(scene)
    scene.render.use_compositing, scene.render.filepath = True, str(folder / "matte.exr")
    with stage.counted_renders() as count:
        bpy.ops.render.render(write_still=True)
    assert bool(count) == (file is None)
    scene.render.use_compositing = False
    (combined,) = [p for name, p in stage.read_exr(folder / "matte.exr").items() if name.endswith("Combined")][:1]
    return combined[..., 0]


def masks(passes: dict[str, np.ndarray]) -> dict[tuple[str, str], np.ndarray]:
    """By layer and name, where each is seen: by the passes of indices, which know nothing of names."""
    objects, materials = passes[INDEX][..., 0], passes[MATERIAL_INDEX][..., 0]
    return {
        ("CryptoObject", "Ball"): objects == BALL,
        ("CryptoMaterial", "Pane"): materials == bpy.data.materials["Pane"].pass_index,
        ("CryptoAsset", "Floor"): (objects == FLOOR) | (objects == PANE),  # its child
    }


def assert_mattes(expected: dict[tuple[str, str], np.ndarray], folder: Path, file: Path | None = None) -> None:
    for (layer, name), mask in expected.items():
        assert 20 < mask.sum() < mask.size - 20
        np.testing.assert_array_equal(matte_of(layer, name, folder, file), mask, err_msg=f"{layer} {name}")


def assert_manifests(file: Path, expected: dict[tuple[str, str], np.ndarray]) -> None:
    """Each layer's says the number of every name that its pixels have, and no other number of that name; it is found
    as the specification has it, by the hash of the layer's own name."""
    passes = stage.read_exr(file)
    with OpenEXR.File(str(file)) as opened:
        header = {key: value for part in opened.parts for key, value in part.header.items()}
    for layer, name in expected:
        prefix = f"cryptomatte/{murmur_hash(f'ViewLayer.{layer}'.encode()):08x}"[:-1]
        assert header[f"{prefix}/name"] == f"ViewLayer.{layer}"
        assert (header[f"{prefix}/hash"], header[f"{prefix}/conversion"]) == ("MurmurHash3_32", "uint32_to_float32")
        numbers = {key: int(bits, 16) for key, bits in json.loads(header[f"{prefix}/manifest"]).items()}
        ranks = [passes[f"ViewLayer.{layer}{i:02}"] for i in range(3)]
        seen = {bits for rank in ranks for bits in np.unique(np.ascontiguousarray(rank[..., 0::2]).view(np.uint32))}
        assert numbers[name] in seen and seen - {0} <= set(numbers.values())
        assert len(seen) >= 3


def test_blenders_node_finds_names_in_a_render(scene, tmp_path):
    assert_mattes(masks(stage.render(tmp_path)), tmp_path)


def test_blenders_node_finds_names_in_a_file(scene, tmp_path):
    """By the metadata and manifest alone: the scene that made the file is gone."""
    expected = masks(stage.render(tmp_path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert_manifests(tmp_path / "render.exr", expected)
    render = bpy.context.scene.render
    render.engine, render.resolution_x, render.resolution_y = "BENTLIGHT", 60, 42
    assert_mattes(expected, tmp_path, tmp_path / "render.exr")


def test_blenders_node_finds_names_in_a_merged_file(scene, tmp_path, monkeypatch):
    """A file that no Blender wrote, of two parts."""
    expected, parts = masks(stage.render(tmp_path)), []
    for number in (1, 2):
        folder = tmp_path / str(number)
        scene.render.filepath = str(folder / "part_")
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["blender", "-b", "--", f"--bentlight-tile={number}/2"])
            bpy.ops.render.render(write_still=True)
        parts += map(str, folder.glob("*.part.exr"))
    merged = tmp_path / "merged.exr"
    assert run_command(["merge", *parts, "-o", str(merged)]) == 0
    assert_manifests(merged, expected)
    assert_mattes(expected, tmp_path, merged)


def test_coverage_is_a_matte(scene, tmp_path):
    """Of many samples a pixel: the node's matte is the coverage in the passes, 1 within an object, ordered, at most 1
    in all."""
    layer, scene.bentlight.samples, scene.bentlight.pixel_filter = "CryptoObject", 8, "BOX"
    bpy.data.materials["Pane"].node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.6
    passes = stage.render(tmp_path)
    pairs = np.concatenate([passes[f"{layer}{i:02}"] for i in range(3)], axis=-1).reshape(42, 60, 6, 2)
    coverage = (pairs[..., 1] * (pairs[..., 0] == np.float32(name_as_float("Ball")))).sum(axis=-1)
    np.testing.assert_allclose(matte_of(layer, "Ball", tmp_path), coverage, atol=1e-6)
    inside = passes[INDEX][..., 0] == BALL
    whole = inside[1:-1, 1:-1].copy()
    for rows, columns in ((slice(0, -2), slice(1, -1)), (slice(2, None), slice(1, -1)), (slice(1, -1), slice(0, -2))):
        whole &= inside[rows, columns]
    behind_nothing = coverage[1:-1, 1:-1][whole & (pairs[1:-1, 1:-1, 1, 1] == 0)]
    assert len(behind_nothing) > 20
    np.testing.assert_allclose(behind_nothing, 1, atol=1e-6)
    opaque = ~(pairs[..., 0] == np.float32(name_as_float("Pane"))).any(axis=-1)  # others are seen through it by chance
    assert pairs[opaque, :, 1].sum(axis=-1).max() <= 1 + 1e-6 and (np.diff(pairs[..., 1], axis=-1) <= 0).all()


def test_hashes_are_those_of_the_specification():
    """MurmurHash3_x86_32 of known texts; a name whose hash has no usual exponent is kept from being one."""
    assert murmur_hash(b"") == 0 and murmur_hash(b"hello") == 0x248BFA47
    assert murmur_hash(b"The quick brown fox jumps over the lazy dog") == 0x2E4FF723
    assert name_as_float("") == 0
    values = np.array([name_as_float(f"object {i}") for i in range(4096)], np.float32)
    assert np.isfinite(values).all() and (np.abs(values) >= np.finfo(np.float32).tiny).all()
