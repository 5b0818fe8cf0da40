"""Pictures by Cycles with lenses: directions in the sky against the core, ray by ray; rooms against the engine."""

import bpy
import numpy as np
import objects
import pytest
import rendering
from agreement import by_core, only_shader, show_directions
from bentlight_native import FATES
from image_statistics import compare

SPACES = ["isotropic", "areal", "kerr", "wormhole"]
SEEDS = 4


def directions(scene: bpy.types.Scene) -> np.ndarray:
    """(pixels, 3), zero where black."""
    return rendering.render(scene, "CYCLES").reshape(-1, 3)


def add_spacetime(kind: str, radius: float = 2.0) -> list[bpy.types.Object]:
    """A hole at the origin, turned and scaled; of a wormhole also the other mouth, of another size and far away."""
    if kind == "wormhole":
        bpy.ops.bentlight.wormhole_add(throat_radius=0.4, location=(0, 0, 0), exit_location=(90, 3, 7))
        found = [obj for obj in bpy.context.scene.objects if obj.bentlight.kind == "WORMHOLE"]
        far = found[0].bentlight.exit if found[0].location.length < 1 else found[0]
        far.rotation_euler, far.scale, far.bentlight.throat_radius = (0.3, 0.5, 1.2), (2, 2, 2), 0.2
        far.bentlight.sphere_radius = 0.7
        hole = far.bentlight.exit
    else:
        bpy.ops.bentlight.black_hole_add(mass=0.15, spin=0.9 if kind == "kerr" else 0, location=(0, 0, 0))
        found = [bpy.context.object]
        hole = found[0]
        hole.scale, hole.rotation_euler = (1.5,) * 3, (0.5, 0.3, 0.2)
        if kind == "areal":
            hole.bentlight.chart = "OBLATE"
    bpy.context.view_layer.update()
    hole.bentlight.sphere_radius = radius / hole.matrix_world.median_scale
    return found


@pytest.mark.parametrize("kind", SPACES)
@pytest.mark.parametrize("place", ["outside", "inside"])
def test_every_pixel_shows_the_direction_of_the_core(kind, place, scene):
    """The same jittered camera rays, taken from a picture without a hole; errors as float32 makes them."""
    show_directions(scene)
    start = (0.3, -8, 1.3) if place == "outside" else (0.2, -1.4, 0.4)
    objects.camera(start, (0, 0, 0), lens_mm=50 if place == "outside" else 18)
    ahead = directions(scene)
    holes = add_spacetime(kind)
    assert bpy.ops.bentlight.cycles_setup() == {"FINISHED"}
    shown = directions(scene)
    core = by_core(holes, scene.camera.location, ahead)
    turned = by_core(holes, scene.camera.location, ahead + 1e-6 * np.roll(ahead, 1, axis=1))
    factor = 1 + np.linalg.norm(turned["direction"] - core["direction"], axis=1) / 1e-6
    escaped, lit = core["fate"] == FATES.index("escaped"), np.abs(shown).max(axis=1) > 0
    clear = np.where(escaped & (turned["fate"] == core["fate"]), factor < 1e4, True)
    assert (escaped == lit)[clear].all()
    both = escaped & lit & clear
    assert both.sum() > len(both) / 3
    assert (np.linalg.norm(core["direction"] - ahead, axis=1)[both] > 0.05).mean() > 0.15  # or nothing is bent
    error = np.linalg.norm(shown - core["direction"], axis=1)[both] / factor[both]
    assert np.sqrt(np.mean(error**2)) < 7e-7  # as osl/lens_table.h says
    assert error.max() < 1e-5


def test_lenses_beside_each_other(scene):
    """Three holes of different kinds, one behind the other."""
    show_directions(scene)
    objects.camera((0, -9, 0.8), (0, 0, 0), lens_mm=40)
    ahead = directions(scene)
    holes = []
    for spin, place, radius in ((0, (-0.4, 0, 0), 1.5), (0.7, (0.9, 3.4, 0.3), 1.4), (0, (0.3, 7, 0), 2.0)):
        bpy.ops.bentlight.black_hole_add(mass=0.1, spin=spin, location=place)
        bpy.context.object.bentlight.sphere_radius = radius
        holes.append(bpy.context.object)
    bpy.ops.bentlight.cycles_setup()
    shown = directions(scene)
    core = by_core(holes, scene.camera.location, ahead)
    both = (core["fate"] == FATES.index("escaped")) & (np.abs(shown).max(axis=1) > 0)
    assert ((core["fate"] == FATES.index("escaped")) == (np.abs(shown).max(axis=1) > 0)).mean() > 0.999
    assert (core["borders"][both] > 2).any()
    error = np.linalg.norm(shown - core["direction"], axis=1)[both]
    assert np.median(error) < 2e-6
    assert np.percentile(error, 99) < 2e-4


def test_bending_grows_from_nothing_at_the_seam(scene):
    """Toward the sphere's edge the chord, and so the bending, goes to zero: there is no step."""
    show_directions(scene)
    objects.camera((0, -40, 0), (0, 0, 0), lens_mm=50)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.02
    scene.camera.location.x = 2.0  # pixels 0.0003 apart, across the edge
    ahead = directions(scene)
    add_spacetime("isotropic")
    bpy.ops.bentlight.cycles_setup()
    bent = np.linalg.norm(directions(scene) - ahead, axis=1).reshape(64, 64)[32]
    b = 2.0 + 0.02 * ((np.arange(64) + 0.5) / 64 - 0.5)
    assert bent[b > 2.0001].max() < 1e-6
    mu = 0.15 * 1.5 / 2 / 2.0  # M / 2R, for the index of refraction (1 + mu)^3 / (1 - mu)
    curvature = mu * (3 / (1 + mu) + 1 / (1 - mu))  # of a ray along the sphere, times R: it lengthens chords
    cosine = np.sqrt(np.maximum(1 - (b / 2) ** 2, 0))
    inside = b < 1.9999
    assert np.abs(bent / (2 * curvature / (1 - curvature) * cosine + 1e-30) - 1)[inside].max() < 0.02
    assert bent[inside][-1] < 0.04 * curvature


def show_places(half_width: float) -> None:
    """Before the camera, behind the hole, a wall whose color is the place on it in the world."""
    material = bpy.data.materials.new("Places")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    place, light, output = (nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "Emission", "OutputMaterial"))
    links.new(place.outputs["Position"], light.inputs["Color"])
    links.new(light.outputs["Emission"], output.inputs["Surface"])
    side = 2 * half_width
    objects.quad("Wall", (-half_width, 4, -half_width), (side, 0, 0), (0, 0, side), material)


@pytest.mark.parametrize("kind", ["isotropic", "kerr"])
def test_a_soft_edge_turns_rays_less_and_less(kind, scene):
    """By the part of the core's bending that smoothstep keeps; and without spin their distance from the hole stays as
    it was, so that they gain and lose no light. Further in nothing changes."""
    show_directions(scene)
    objects.camera((0.3, -8, 1.3), (0, 0, 0), lens_mm=50)
    ahead = directions(scene)
    (hole,) = add_spacetime(kind)
    soft = hole.bentlight.lens_soft_edge = 0.3
    hole.bentlight.lens_radius = hole.bentlight.sphere_radius
    bpy.ops.bentlight.cycles_setup()
    shown = directions(scene)
    core = by_core([hole], scene.camera.location, ahead)["direction"]
    b = np.linalg.norm(np.cross(scene.camera.location, ahead), axis=1) / 2.0
    inside = ((1 - b) / soft).clip(0, 1)
    kept = (inside**2 * (3 - 2 * inside))[:, None]
    outer = b > 0.65  # rays do not fall in
    expected = (1 - kept) * ahead + kept * core
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    fading = (inside > 0) & (inside < 1)
    assert fading.mean() > 0.15 and (np.linalg.norm(core - expected, axis=1)[fading] > 0.02).mean() > 0.3
    error = np.linalg.norm(shown - expected, axis=1)[outer]
    assert np.sqrt(np.mean(error**2)) < 7e-7 and error.max() < 1e-5  # as without a soft edge
    if kind == "isotropic":
        show_places(30)
        after = np.linalg.norm(np.cross(directions(scene), shown), axis=1) / 2.0
        assert np.abs(after - b)[outer].max() < 2e-5


def room(scene: bpy.types.Scene, kind: str) -> None:
    """Diffuse walls under a shining plate and a blue sky, around a hole."""
    scene.render.resolution_x, scene.render.resolution_y = 60, 36
    objects.set_world((0.3, 0.4, 0.6))
    colors = {"White": (0.8, 0.8, 0.8), "Red": (0.7, 0.2, 0.1)}
    white, red = (only_shader(name, "ShaderNodeBsdfDiffuse", color) for name, color in colors.items())
    lamp = only_shader("Lamp", "ShaderNodeEmission", (6, 6, 6))
    objects.quad("Floor", (-4, -4, -1.3), (8, 0, 0), (0, 8, 0), white)
    objects.quad("Wall", (-4, 3, -1.3), (8, 0, 0), (0, 0, 4), red)
    objects.quad("Plate", (-1, -1, 2.5), (0, 2, 0), (2, 0, 0), lamp)
    objects.box("Box", (2.2, 0.5, -0.7), (1, 1, 1.2), red)
    objects.camera((0, -6, 0.5), (0, 0, 0), lens_mm=30)
    add_spacetime(kind, radius=1.2)
    cycles = scene.cycles
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.use_light_tree = False
    scene.bentlight.max_bounces = cycles.max_bounces = cycles.diffuse_bounces = 4
    scene.bentlight.pixel_filter = "BOX"
    cycles.filter_width = scene.render.filter_size = 1


@pytest.mark.parametrize("kind", ["isotropic", "kerr", "wormhole"])
def test_rooms_are_lit_as_by_the_engine(kind, scene):
    """All light goes through lenses as through the engine's spheres: from shining meshes and the world, and bounced."""
    room(scene, kind)
    ours = np.stack([rendering.render(scene, "BENTLIGHT", seed, 32) for seed in range(SEEDS)])
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.cycles_setup()
    cycles = np.stack([rendering.render(scene, "CYCLES", seed, 32) for seed in range(SEEDS)])
    comparison = compare(cycles, ours)
    assert comparison.precision < 0.01
    assert not comparison.differs(), str(comparison)
