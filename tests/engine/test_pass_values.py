"""Passes in flat space: data by single points as Cycles has them, light by Z-tests, sums that must hold."""

import bpy
import numpy as np
import pytest

from blender_addon.passes import PASSES
from tests.engine import pass_scene, stage
from tests.engine.cycles_pictures import NARROW
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare

NAMES = {item.channel: item.name for item in PASSES}
KINDS = ("diffuse", "glossy", "transmission")
SEEDS, SAMPLES = 6, 12


@pytest.fixture
def scene(blender) -> bpy.types.Scene:  # noqa: F811
    """The scene of all passes, set up alike for both engines, with the toggles of Blender's own passes on."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 60, 42
    pass_scene.build()
    layer = scene.view_layers[0]
    for item in PASSES:
        if item.toggle.startswith("use_"):
            setattr(layer, item.toggle, True)
    mist = scene.world.mist_settings
    mist.start, mist.depth, mist.falloff = 4, 5, "INVERSE_QUADRATIC"
    scene.world.light_settings.distance = 1.5
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.bentlight.use_adaptive_sampling = False
    scene.cycles.sample_clamp_indirect = 0
    scene.cycles.blur_glossy = scene.bentlight.blur_glossy = 0
    scene.cycles.max_bounces = scene.bentlight.max_bounces = 3
    scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = scene.cycles.transmission_bounces = 3
    return scene


def both(scene, tmp_path, samples: int, seed: int = 0) -> list[dict[str, np.ndarray]]:
    """Every pass by Cycles and by Bentlight."""
    scene.cycles.samples = scene.bentlight.samples = samples
    scene.cycles.seed = scene.bentlight.seed = seed
    found = []
    for scene.render.engine in ("CYCLES", "BENTLIGHT"):
        found.append(stage.render(tmp_path))
    return found


def make_points(scene) -> None:
    """Pixels see one point each, and nothing is there by chance."""
    scene.cycles.pixel_filter_type, scene.bentlight.pixel_filter = "BOX", "GAUSSIAN"
    scene.cycles.filter_width = scene.render.filter_size = NARROW
    pane = bpy.data.materials["Pane"].node_tree.nodes
    next(node for node in pane if node.type == "BSDF_PRINCIPLED").inputs["Alpha"].default_value = 1.0


def add_aovs(scene) -> None:
    """A color and a number that each material, and the sky, makes of the place."""
    for name, kind in (("tint", "COLOR"), ("height", "VALUE")):
        aov = scene.view_layers[0].aovs.add()
        aov.name, aov.type = name, kind
    for owner in (*bpy.data.materials, scene.world):
        nodes, links = owner.node_tree.nodes, owner.node_tree.links
        place = nodes.new("ShaderNodeTexCoord").outputs["Generated"]
        split = nodes.new("ShaderNodeSeparateXYZ")
        links.new(place, split.inputs[0])
        for name, output, socket in (("tint", place, "Color"), ("height", split.outputs["Z"], "Value")):
            node = nodes.new("ShaderNodeOutputAOV")
            node.aov_name = name
            links.new(output, node.inputs[socket])


def test_data_is_that_of_cycles(scene, tmp_path):
    make_points(scene)
    add_aovs(scene)
    layer = scene.view_layers[0]
    layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = layer.use_pass_cryptomatte_asset = True
    cycles, ours = both(scene, tmp_path, 1)
    assert set(cycles) == set(ours)
    exact = [NAMES["object_index"], NAMES["material_index"]]
    exact += [name for name in ours if name.startswith("Crypto")]
    for name in exact:
        assert np.array_equal(cycles[name], ours[name]), name
    for name in [*(NAMES[c] for c in ("depth", "mist", "normal", "position", "uv")), "tint", "height"]:
        wrong = (np.abs(cycles[name] - ours[name]) > 2e-3).any(axis=-1)  # the filter is not infinitely narrow
        assert wrong.mean() < 0.01, name
    to_camera = np.array(scene.camera.location) - ours[NAMES["position"]]
    cosine = (ours[NAMES["normal"]] * to_camera).sum(axis=-1) / np.linalg.norm(to_camera, axis=-1)
    for name in (NAMES[f"{kind}_color"] for kind in KINDS):  # both estimate reflection, otherwise towards grazing
        wrong = (np.abs(cycles[name] - ours[name]) > 2e-3).any(axis=-1)
        assert wrong[cosine > 0.5].mean() < 0.01, name
    assert 0.1 < ours[NAMES["mist"]].mean() < 0.9 and ours[NAMES["uv"]][..., 2].mean() > 0.05


def test_light_is_that_of_cycles(scene, tmp_path):
    """Of light what it brings to the picture: colors, which test_data compares, are estimates from tables."""
    scene.cycles.pixel_filter_type = scene.bentlight.pixel_filter = "BOX"
    channels = [f"{kind}_{part}" for kind in KINDS for part in ("direct", "indirect")]
    channels += ["emission", "environment", "ambient_occlusion", "mist"]
    pictures = [[], []]
    for seed in range(SEEDS):
        for engine, passes in enumerate(both(scene, tmp_path, SAMPLES, seed)):
            values = [
                passes[NAMES[c]] * (passes[NAMES[f"{c.split('_')[0]}_color"]] if "direct" in c else 1) for c in channels
            ]
            values += [passes[f"Combined_{group.name}"] for group in scene.view_layers[0].lightgroups]
            pictures[engine].append([np.broadcast_to(v, (*v.shape[:2], 3)) for v in values])
    cycles, ours = (np.moveaxis(np.array(p), 1, 0) for p in pictures)
    channels += [group.name for group in scene.view_layers[0].lightgroups]
    for name, a, b in zip(channels, cycles, ours, strict=True):
        if name == "transmission_direct":  # no lobe here refracts lamps' light towards the camera at once; see below
            assert np.abs(a).mean() < 1e-4 and np.abs(b).mean() < 1e-4
            continue
        lit = compare(a, b, block=6)
        assert not lit.differs(), f"{name}: {lit.differs()}; {lit}"


def frosted_pane() -> None:
    """A pane of rough refraction before the camera, a lamp behind it, and nothing else."""
    scene = bpy.context.scene
    stage.add_camera((0, 0, 4))
    stage.set_world((0, 0, 0))
    frosted = stage.emission((1, 1, 1), name="Frosted")
    nodes, links = frosted.node_tree.nodes, frosted.node_tree.links
    shader = nodes.new("ShaderNodeBsdfRefraction")
    shader.inputs["Color"].default_value = (0.9, 0.7, 0.5, 1)
    shader.inputs["Roughness"].default_value, shader.inputs["IOR"].default_value = 0.5, 1.3
    links.new(shader.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"])
    pane = stage.add_square(4, (0, 0, 0), frosted)
    pane.rotation_euler.z = 0.3  # no pixel's middle is on its diagonal, where Cycles meets it twice
    lamp = stage.add_light("AREA", (0.5, 0.3, -2), (np.pi, 0, 0), energy=100, size=1.5)
    lamp.visible_camera = False
    scene.cycles.max_bounces = scene.bentlight.max_bounces = 3


def test_light_that_is_refracted_at_once_is_that_of_cycles(blender, tmp_path):  # noqa: F811
    """Transmission Direct: drawn at the lamp or by the lobe, alone in its pass, and all of the picture."""
    frosted_pane()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 36, 24
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = scene.bentlight.use_adaptive_sampling = False
    scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = scene.bentlight.blur_glossy = 0
    scene.cycles.pixel_filter_type = scene.bentlight.pixel_filter = "BOX"
    layer = scene.view_layers[0]
    layer.use_pass_transmission_direct = layer.use_pass_transmission_color = True
    layer.use_pass_transmission_indirect = layer.use_pass_glossy_direct = layer.use_pass_diffuse_direct = True
    pictures = [[], []]
    for seed in range(SEEDS):
        for engine, passes in enumerate(both(scene, tmp_path, SAMPLES, seed)):
            direct = passes[NAMES["transmission_direct"]] * passes[NAMES["transmission_color"]]
            pictures[engine].append(direct)
            np.testing.assert_allclose(direct, passes["Combined"][..., :3], rtol=1e-4, atol=1e-6)
            others = ("transmission_indirect", "glossy_direct", "diffuse_direct")
            assert not any(passes[NAMES[name]].any() for name in others)
    lit = compare(*map(np.array, pictures))
    assert lit.mean_a.min() > 0.05 and lit.precision < 0.01
    assert not lit.differs(), f"{lit.differs()}; {lit}"


def test_parts_add_up_to_the_whole(scene, tmp_path):
    """To float32 rounding: light by lobes with emission and environment, and light groups."""
    scene.bentlight.clamp_indirect, scene.bentlight.samples = 0.5, 4
    passes = stage.render(tmp_path)
    whole = passes["Combined"][..., :3]
    lobes = sum(
        (passes[NAMES[f"{kind}_direct"]] + passes[NAMES[f"{kind}_indirect"]]) * passes[NAMES[f"{kind}_color"]]
        for kind in KINDS
    )
    lobes += passes[NAMES["emission"]] + passes[NAMES["environment"]]
    groups = sum(passes[f"Combined_{group.name}"] for group in scene.view_layers[0].lightgroups)
    np.testing.assert_allclose(lobes, whole, rtol=2e-5, atol=1e-6)
    np.testing.assert_allclose(groups, whole, rtol=2e-5, atol=1e-6)
    for group in scene.view_layers[0].lightgroups:
        assert passes[f"Combined_{group.name}"].mean() > 0.01, "each group has light"


def test_a_transparent_film_has_no_sky_in_its_groups(scene, tmp_path):
    scene.render.film_transparent, scene.bentlight.samples = True, 2
    passes = stage.render(tmp_path)
    groups = sum(passes[f"Combined_{group.name}"] for group in scene.view_layers[0].lightgroups)
    np.testing.assert_allclose(groups, passes["Combined"][..., :3], rtol=2e-5, atol=1e-6)


def test_light_passes_follow_light_from_the_camera_alone(scene, tmp_path, capfd):
    """What lamps' own paths bring cannot be told apart, and the user is told so."""
    scene.bentlight.samples, scene.bentlight.integrator = 1, "BIDIRECTIONAL"
    told = stage.render(tmp_path)["Combined"]
    assert capfd.readouterr().out.count("light is followed from the camera alone: the pass 'Diff") == 1
    scene.bentlight.integrator = "PATH"
    assert np.array_equal(told, stage.render(tmp_path)["Combined"])
