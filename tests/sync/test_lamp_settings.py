"""What lamps can be told, against Cycles: a lamp without size lights a wall by one sample as exactly as by many."""

import bpy
import numpy as np
import pytest
from texture_cases import ies_text

from blender_addon import final
from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import compare


def wall(material=None, name="Wall", location=(0, 0, 0), size=9.0) -> bpy.types.Object:
    return stage.add_square(size, location, material or diffuse(), name)


def diffuse() -> bpy.types.Material:
    material = stage.emission((0, 0, 0), name="White")
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output.inputs["Surface"])
    return material


def differing(theirs: np.ndarray, ours: np.ndarray) -> np.ndarray:
    """Which pixels are not the same: a color changes by its slope over half of the pixel filter, and Cycles reckons in
    single precision."""
    slope = np.zeros_like(theirs)
    for axis in (0, 1):
        for shift in (-1, 1):
            slope = np.maximum(slope, np.abs(np.roll(theirs, shift, axis) - theirs))
    return (np.abs(ours - theirs) > cycles_pictures.NARROW * slope + 2e-4 * theirs + 1e-5 * theirs.max()).any(axis=2)


def stand(kind="POINT", **settings) -> bpy.types.Object:
    """A camera and a lamp before a wall; no bounces, black surroundings."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.bentlight.max_bounces = scene.cycles.max_bounces = 0
    scene.cycles.light_sampling_threshold = scene.bentlight.light_threshold = 0
    stage.add_camera((0, 0, 5))
    stage.set_world((0, 0, 0))
    lamp = stage.add_light(kind, (0.5, 0.3, 2.5), (0.3, 0.1, 0.5), **({"shadow_soft_size": 0.0} | settings))
    lamp.data.energy = 100.0
    return lamp


def agree(tmp_path) -> np.ndarray:
    """Asserts that both pictures are the same and not black; returns ours. Edges may fall on either side of a pixel."""
    theirs, ours = cycles_pictures.point_pictures(tmp_path)
    assert theirs.max() > 0.01
    off = differing(theirs, ours)
    assert off.sum() <= 0.005 * off.size, f"{off.sum()} pixels, e.g. {ours[off][:2]} for {theirs[off][:2]}"
    return ours


# ---- Node trees ----


class Tree:
    """The node tree of a lamp, emptied but for an emission whose color is to be linked."""

    def __init__(self, lamp: bpy.types.Object) -> None:
        lamp.data.use_nodes = True
        self.tree = lamp.data.node_tree
        self.tree.nodes.clear()
        output, self.emission = self.new("OutputLight"), self.new("Emission")
        self.link(self.emission.outputs[0], output.inputs["Surface"])

    def new(self, kind: str) -> bpy.types.Node:
        return self.tree.nodes.new(f"ShaderNode{kind}")

    def link(self, source, target) -> None:
        self.tree.links.new(source, target)

    def checker(self, vector, scale: float) -> None:
        node = self.new("TexChecker")
        node.inputs["Scale"].default_value = scale
        node.inputs["Color1"].default_value, node.inputs["Color2"].default_value = (1, 0.3, 0, 1), (0, 0.2, 1, 1)
        if vector is not None:
            self.link(vector, node.inputs["Vector"])
        self.link(node.outputs["Color"], self.emission.inputs["Color"])


def test_a_plain_tree_multiplies_the_lamp(tmp_path):
    wall()
    lamp = stand()
    lamp.data.color, lamp.data.exposure = (1.0, 0.5, 0.2), 0.5
    emission = Tree(lamp).emission
    emission.inputs["Color"].default_value, emission.inputs["Strength"].default_value = (0.5, 1, 0.7, 1), 3.0
    agree(tmp_path)


@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
@pytest.mark.parametrize("output", ["UV", "Normal"])
def test_a_lamp_without_size_projects_its_texture(kind, output, tmp_path):
    wall()
    tree = Tree(stand(kind, **({"spot_size": 1.4, "spot_blend": 0.3} if kind == "SPOT" else {})))
    tree.checker(tree.new("TexCoord").outputs[output], 7.0)
    ours = agree(tmp_path)
    assert (ours[..., 0] > 2 * ours[..., 2]).any() and (ours[..., 2] > 2 * ours[..., 0]).any()


@pytest.mark.parametrize("output", ["Incoming", "Normal", "Position"])
def test_geometry_of_a_lamp(output, tmp_path):
    wall()
    tree = Tree(stand())
    tree.checker(tree.new("NewGeometry").outputs[output], 3.3)
    agree(tmp_path)


def test_a_measured_luminaire(tmp_path):
    """In the axes of the lamp, which is turned. Cycles 4.5 took what is beyond the first and last angles for dark,
    which makes its curves between the outermost ones overshoot: there it is brighter."""
    wall()
    tree = Tree(stand())
    luminaire = tree.new("TexIES")
    luminaire.mode, luminaire.ies = "INTERNAL", bpy.data.texts.new("measured")
    luminaire.ies.from_string(ies_text((0, 60, 120, 180), range(0, 181, 12)))
    tree.link(luminaire.outputs["Fac"], tree.emission.inputs["Strength"])
    if bpy.app.version >= (5, 0, 0):
        ours = agree(tmp_path)
    else:
        theirs, ours = cycles_pictures.point_pictures(tmp_path)
        assert (ours < 1.005 * theirs).all() and np.isclose(ours, theirs, rtol=5e-3).mean() > 0.3
    assert ours.max() > 1.5 * np.median(ours)


@pytest.mark.parametrize("output", ["Quadratic", "Linear", "Constant"])
@pytest.mark.parametrize("kind", ["POINT", "SUN"])
def test_light_falloff(kind, output, tmp_path):
    wall()
    lamp = stand(kind, **({"angle": 0.0} if kind == "SUN" else {}))
    lamp.data.energy = 3.0
    tree = Tree(lamp)
    node = tree.new("LightFalloff")
    node.inputs["Strength"].default_value, node.inputs["Smooth"].default_value = 2.0, 1.5
    tree.link(node.outputs[output], tree.emission.inputs["Strength"])
    agree(tmp_path)


@pytest.mark.parametrize("shape", ["RECTANGLE", "ELLIPSE"])
@pytest.mark.parametrize("output", ["UV", "Object", "Generated"])
def test_textured_area_lights_look_as_in_cycles(shape, output, tmp_path):
    lamp = stand("AREA", shape=shape, size=3.0, size_y=2.0)
    lamp.rotation_euler, lamp.location = (np.pi - 0.3, 0.2, 0.4), (0, 0, 0)
    lamp.scale = (1.2, 0.8, 1.0)
    tree = Tree(lamp)
    scale = tree.new("Mapping")
    scale.inputs["Scale"].default_value = scale.inputs["Location"].default_value = (0.4, 0.4, 0.4)
    tree.link(tree.new("TexCoord").outputs[output], scale.inputs["Vector"])
    tree.link(scale.outputs["Vector"], tree.emission.inputs["Color"])
    agree(tmp_path)


@pytest.mark.parametrize("soft", [False, True])
@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_lamps_with_a_radius_look_as_in_cycles(kind, soft, tmp_path):
    """Sphere or disk, whole or dimmed by a cone that is an ellipse; what is behind shows beside it."""
    lamp = stand(kind, use_soft_falloff=soft)
    lamp.data.shadow_soft_size = 1.4
    lamp.location, lamp.rotation_euler, lamp.scale = (0.2, 0.1, 2), (np.pi - 0.35, 0.2, 0.5), (1.3, 0.9, 1.1)
    if kind == "SPOT":
        lamp.data.spot_size, lamp.data.spot_blend = 1.0, 0.8
    stage.set_world((0.05, 0.1, 0.2))
    theirs, ours = cycles_pictures.point_pictures(tmp_path)
    assert theirs.max() > 0.5 and differing(theirs, ours).sum() <= 6  # the rim is a polygon's


def test_an_unknown_node_is_named_once(capfd, tmp_path):
    wall()
    tree = Tree(stand())
    tree.link(tree.new("Wireframe").outputs["Fac"], tree.emission.inputs["Strength"])
    stage.render(tmp_path)
    said = [line for line in "".join(capfd.readouterr()).splitlines() if "not supported" in line]
    assert len(said) == 1 and "Light 'Point'" in said[0] and "Wireframe" in said[0]


SUN_COORDINATES = [("TexCoord", "UV"), ("TexCoord", "Object"), ("TexCoord", "Generated"), ("TexCoord", "Normal")]
SUN_COORDINATES += [("NewGeometry", "Normal"), ("NewGeometry", "Position"), ("NewGeometry", "Incoming")]


@pytest.mark.parametrize(("node", "output"), SUN_COORDINATES)
def test_textured_suns_look_as_in_cycles(node, output, tmp_path):
    """Its disk itself, wide and turned, under a texture that varies over it."""
    lamp = stand("SUN", angle=0.6)
    lamp.rotation_euler, lamp.scale = (np.pi - 0.1, 0.1, 0.4), (1.2, 0.8, 1.0)
    tree = Tree(lamp)
    scale = tree.new("Mapping")
    scale.inputs["Scale"].default_value = scale.inputs["Location"].default_value = (0.4, 0.4, 0.4)
    tree.link(tree.new(node).outputs[output], scale.inputs["Vector"])
    tree.link(scale.outputs["Vector"], tree.emission.inputs["Color"])
    ours = agree(tmp_path)
    lit = ours[ours.max(axis=2) > 0]
    assert len(lit) > 50 and np.ptp(lit, axis=0).max() > 0.03 * lit.max()


@pytest.mark.parametrize("angle", [0.0, 0.8])
def test_textured_suns_light_as_in_cycles(angle, tmp_path):
    """The pattern of a texture in the sky's own directions lights a wall by connections and by chance."""
    wall()
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 6, 6
    lamp = stand("SUN", angle=angle)
    lamp.data.energy = 3.0
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 6, 6
    tree = Tree(lamp)
    tree.checker(tree.new("TexCoord").outputs["UV"], 3.0)
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, seeds=6, samples=64)
    comparison = compare(theirs, ours, block=2)
    exact = abs(ours.mean() / theirs.mean() - 1) < 1e-5
    assert exact or not comparison.differs(), str(comparison)
    assert comparison.mean_b == pytest.approx(comparison.mean_a, rel=0.01)


# ---- Whom a lamp lights ----


def two_lobes() -> bpy.types.Material:
    """Diffuse and rough glossy."""
    material = stage.emission((0, 0, 0), name="Two")
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    mix, diffuse, glossy = (tree.nodes.new(f"ShaderNode{n}") for n in ("MixShader", "BsdfDiffuse", "BsdfAnisotropic"))
    diffuse.inputs["Color"].default_value, glossy.inputs["Color"].default_value = (1, 0.2, 0.1, 1), (0.1, 0.2, 1, 1)
    glossy.inputs["Roughness"].default_value, glossy.distribution = 0.6, "GGX"
    tree.links.new(diffuse.outputs[0], mix.inputs[1])
    tree.links.new(glossy.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return material


@pytest.mark.parametrize("hidden", ["diffuse", "glossy", "transmission", "camera"])
def test_ray_visibility_of_a_lamp(hidden, tmp_path):
    wall(two_lobes())
    setattr(stand(), f"visible_{hidden}", False)
    agree(tmp_path)


@pytest.mark.parametrize(("lamp_casts", "screen_casts"), [(True, True), (False, True), (True, False)])
def test_cast_shadow_and_shadow_visibility(lamp_casts, screen_casts, tmp_path):
    wall()
    lamp = stand()
    lamp.data.use_shadow = lamp_casts
    screen = wall(name="Screen", location=(1, 0, 1), size=2.0)
    screen.visible_shadow, screen.visible_camera = screen_casts, False
    ours = agree(tmp_path)
    assert (ours.max(axis=2) == 0).any() == (lamp_casts and screen_casts)


def collection(*members: tuple[bpy.types.Object, str], child: tuple = ()) -> bpy.types.Collection:
    """Objects with their link states; `child`: the same in a collection inside, with its own state in front."""
    made = bpy.data.collections.new("Links")
    for obj, _ in members:
        made.objects.link(obj)
    for entry, (_, state) in zip(made.collection_objects, members, strict=True):
        entry.light_linking.link_state = state
    if child:
        made.children.link(collection(*((obj, "INCLUDE") for obj in child[1:])))
        made.collection_children[0].light_linking.link_state = child[0]
    return made


@pytest.mark.parametrize("case", ["include", "exclude", "both", "child"])
@pytest.mark.parametrize("links", ["receiver_collection", "blocker_collection"])
def test_light_linking(links, case, tmp_path):
    """Three walls and two screens before them; of two lamps one is linked."""
    walls = [wall(name=f"Wall {i}", location=(1.6 * i - 1.6, 0, 0), size=1.5) for i in range(3)]
    screens = [wall(name=f"Screen {i}", location=(i - 0.5, 0.8, 1), size=0.8) for i in range(2)]
    for screen in screens:
        screen.visible_camera = False
    lamp = stand()
    lamp.data.color = (1, 0.1, 0)
    other = stage.add_light("POINT", (-0.5, -0.5, 3), shadow_soft_size=0.0, energy=0.0, color=(0, 0.3, 1))
    target = walls if links == "receiver_collection" else screens
    states = {
        "include": collection((target[0], "INCLUDE")),
        "exclude": collection((target[1], "EXCLUDE")),
        "both": collection((target[0], "INCLUDE"), (target[1], "EXCLUDE")),
        "child": collection((target[0], "INCLUDE"), child=("EXCLUDE", target[1])),
    }
    everyone = agree(tmp_path)
    setattr(lamp.light_linking, links, states[case])
    assert differing(everyone, agree(tmp_path)).sum() > 20
    other.data.energy, lamp.data.energy = 30.0, 0.0  # one sample would draw either
    agree(tmp_path)


def test_a_lamp_stops_at_its_bounces(tmp_path):
    """In a corner, with bounces allowed but not of this lamp's light."""
    wall()
    upright = wall(name="Upright", location=(-2, 0, 0))
    upright.rotation_euler = (0, np.pi / 2, 0)
    lamp = stand()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 12, 12
    scene.bentlight.max_bounces = 3
    pictures = {}
    for lamp.data.cycles.max_bounces in (0, 1, 1024):
        theirs, ours = cycles_pictures.noisy_pictures(tmp_path, seeds=6, samples=64)
        comparison = compare(theirs, ours)
        assert not comparison.differs(), str(comparison)
        pictures[lamp.data.cycles.max_bounces] = ours.mean()
    assert pictures[0] < 0.98 * pictures[1] < pictures[1] < pictures[1024]


def test_portals_give_no_light(tmp_path):
    wall()
    stand("AREA", size=2.0).data.cycles.is_portal = True
    assert (stage.render(tmp_path)["Combined"][..., :3] == 0).all()


@pytest.mark.parametrize("radius", [0.0, 0.5])
@pytest.mark.parametrize("scale", [(0, 0, 0), (1, 1, 0), (-1e-3, 1e-3, 1e-3)])
def test_a_point_shines_however_its_object_is_scaled(scale, radius, tmp_path):
    wall()
    lamp = stand()
    lamp.scale = scale
    if radius:  # itself, as a sphere
        lamp.location, lamp.data.shadow_soft_size, lamp.data.use_soft_falloff = (0.3, 0.2, 0.6), radius, False
        bpy.data.objects["Wall"].hide_render = True
        theirs, ours = cycles_pictures.point_pictures(tmp_path)
        assert theirs.max() > 1 and differing(theirs, ours).sum() <= 6  # the rim is a polygon's
    else:
        agree(tmp_path)


@pytest.mark.parametrize(("kind", "scale"), [("SUN", (0, 0, 1)), ("SUN", (0, 0, 0)), ("SPOT", (0, 0, 0))])
def test_flattened_suns_and_spots_shine(kind, scale, tmp_path):
    wall()
    lamp = stand(kind)
    lamp.rotation_euler, lamp.scale = (0, 0, 0), scale
    assert stage.render(tmp_path)["Combined"][12, 16, 0] > 0


@pytest.mark.parametrize(("settings", "scale"), [({}, (1, 0, 1)), ({}, (1, 1, 0)), ({"size": 0.0}, (1, 1, 1))])
def test_an_area_light_without_an_area_is_dark(settings, scale, capfd, tmp_path):
    wall()
    stand("AREA", **settings).scale = scale
    assert (stage.render(tmp_path)["Combined"][..., :3] == 0).all()
    assert "zero size" in "".join(capfd.readouterr())


@pytest.mark.parametrize(("energy", "warns"), [(0.0, False), (-5.0, True)])
@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
def test_power_that_is_none(kind, energy, warns, capfd, tmp_path):
    wall()
    stand(kind).data.energy = energy
    assert (stage.render(tmp_path)["Combined"][..., :3] == 0).all()
    assert ("negative" in "".join(capfd.readouterr())) == warns


@pytest.mark.parametrize("energy", [float("inf"), float("nan")])
def test_power_that_is_not_finite_is_an_error(energy, tmp_path):
    stand().data.energy = energy
    with pytest.raises(RuntimeError, match="'Point': its power is not finite"):
        stage.render(tmp_path)


# ---- The engine's setting ----


@pytest.mark.parametrize("value", ["BOTH", "SCATTERING", "CONNECTIONS"])
def test_light_sampling_reaches_the_core(value):
    scene = bpy.context.scene
    assert scene.bentlight.light_sampling == "BOTH"
    scene.bentlight.light_sampling = value
    assert final.render_settings(scene, bpy.context.view_layer, False).light_sampling == value


def test_ways_of_light_sampling_agree(tmp_path):
    """The same means; what the noise of each should be is known in tests/native/test_weights.py."""
    wall()
    stand("AREA", size=2.0).visible_camera = False
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 12, 12
    pictures = {}
    for way in ("BOTH", "SCATTERING", "CONNECTIONS"):
        scene.bentlight.light_sampling = way
        (pictures[way],) = cycles_pictures.noisy_pictures(tmp_path, seeds=6, samples=64, engines=("BENTLIGHT",))
    for way in ("SCATTERING", "CONNECTIONS"):
        comparison = compare(pictures["BOTH"], pictures[way])
        assert not comparison.differs(), str(comparison)
