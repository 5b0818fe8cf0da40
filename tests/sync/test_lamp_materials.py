"""Every kind of lamp, a shining mesh and an image of the sky on diffuse, rough metal and glass, against Cycles:
Z-tests, and means within 1 %.

Tiles in a row, seen from above: diffuse (half in the shadow of a bar), rough metal, glass; and a glass pane before the
lamp.
"""

import math

import bpy
import numpy as np
import pytest

from tests.engine import cycles_pictures, stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)
from tests.images.image_statistics import block_means, compare

SEEDS, SAMPLES = 6, 256
SAMPLES_BEHIND = 768  # rough glass is noisy in Cycles
HEIGHT = 6  # pixels, of tiles and pictures
ROW = ("diffuse", "metal", "glass")
EXACT = 3e-4  # relative: what Cycles' BSDFs are off by in single precision, where a picture has hardly any noise
NO_SHADOW = {"use_shadow": False}

POINT = {"energy": 60.0, "shadow_soft_size": 0.0}
SPOT = POINT | {"spot_size": 1.6, "spot_blend": 0.6}
SPHERE, SOFT = (
    {"shadow_soft_size": 0.5, "use_soft_falloff": False},
    {"shadow_soft_size": 0.5, "use_soft_falloff": True},
)
AREA, SUN = {"energy": 60.0, "size": 1.2}, {"energy": 3.0}
LAMPS = {
    "point": ("POINT", POINT),
    "point, a sphere": ("POINT", POINT | SPHERE),
    "point, soft": ("POINT", POINT | SOFT),
    "point without shadows": ("POINT", POINT | NO_SHADOW),
    "spot": ("SPOT", SPOT),
    "spot, a sphere": ("SPOT", SPOT | SPHERE),
    "spot, soft": ("SPOT", SPOT | SOFT | {"spot_blend": 0.0}),
    "sun": ("SUN", SUN | {"angle": 0.0}),
    "wide sun": ("SUN", SUN | {"angle": 0.6}),
    "square": ("AREA", AREA),
    "rectangle": ("AREA", AREA | {"shape": "RECTANGLE", "size_y": 0.4}),
    "disk": ("AREA", AREA | {"shape": "DISK"}),
    "ellipse": ("AREA", AREA | {"shape": "ELLIPSE", "size_y": 0.4}),
    "spread": ("AREA", AREA | {"spread": 1.8}),
}


def shader(kind: str, **inputs) -> bpy.types.Material:
    material = bpy.data.materials.new(kind)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(f"ShaderNodeBsdf{kind}"), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    if kind in ("Anisotropic", "Glass"):
        node.distribution = "GGX"
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def build_tiles(names) -> None:
    """Squares of size 1 side by side, the middle one at the origin."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = HEIGHT * len(names), HEIGHT
    scene.cycles.blur_glossy = scene.cycles.light_sampling_threshold = scene.bentlight.light_threshold = 0.0
    scene.bentlight.max_bounces = 2
    stage.set_world((0, 0, 0))
    stage.add_camera((0, 0, 8), type="ORTHO", ortho_scale=len(names))
    materials = {
        "diffuse": shader("Diffuse"),
        "metal": shader("Anisotropic", Color=(0.9, 0.7, 0.4, 1), Roughness=0.6),
        "glass": shader("Glass", Color=(1, 0.9, 1, 1), Roughness=0.5, IOR=1.5),
    }
    for i, name in enumerate(names):
        stage.add_square(1.0, (i - (len(names) - 1) / 2, 0, 0), materials[name], name)
    bar = stage.add_square(0.3, (-0.75, -0.2, 0.5), shader("Diffuse", Color=(0, 0, 0, 1)), "bar")
    bar.visible_camera = False


def add_lamp(kind, settings, behind=False) -> bpy.types.Object:
    """2.2 above the tiles, or as much below, turned to them."""
    side = -1 if behind else 1
    rotation = (math.pi - 0.15 if behind else -0.15, 0.1, 0.4)
    lamp = stage.add_light(kind, (0.1, 0.3, side * 2.2), rotation, **settings)
    lamp.scale = (1.4, 0.8, 1.2) if kind in ("SPOT", "AREA") else (1, 1, 1)
    lamp.visible_camera = False
    return lamp


def compare_tiles(names, samples, tmp_path) -> None:
    theirs, ours = cycles_pictures.noisy_pictures(tmp_path, SEEDS, samples)
    for i, name in enumerate(names):
        tile = np.s_[:, :, i * HEIGHT : (i + 1) * HEIGHT]
        a, b = block_means(theirs[tile], 2).mean(axis=0), block_means(ours[tile], 2).mean(axis=0)
        comparison = compare(theirs[tile], ours[tile], block=2)
        same = np.abs(b - a).max() <= EXACT * a.max()
        assert same or not comparison.differs(), (name, str(comparison))
        assert a.mean() > 0 and comparison.precision < 0.004
        assert comparison.mean_b == pytest.approx(comparison.mean_a, rel=0.01), (name, str(comparison))


@pytest.mark.parametrize("name", LAMPS)
def test_lamp_before(name, tmp_path):
    build_tiles(ROW)
    add_lamp(*LAMPS[name])
    compare_tiles(ROW, SAMPLES, tmp_path)


@pytest.mark.parametrize("name", LAMPS)
def test_lamp_behind(name, tmp_path):
    build_tiles(("glass",))
    add_lamp(*LAMPS[name], behind=True)
    compare_tiles(("glass",), SAMPLES_BEHIND, tmp_path)


def add_shining_ball() -> None:
    """80 triangles that shine more on one side than on the other."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.5, location=(0.1, 0.3, 2.2))
    ball = bpy.context.object
    ball.visible_camera = False
    for strength in (3.0, 12.0):
        ball.data.materials.append(stage.emission((1.0, 0.8, 0.6), strength))
    for face in ball.data.polygons:
        face.material_index = int(face.center.x > 0.1)


def add_sky_image() -> None:
    """A bright cloud in a gray sky, off the zenith. Cycles finds it by scattering: by connections it sees 1 % more in
    glass than by scattering (test_caustics_cycles.py tells why)."""
    image = bpy.data.images.new("Sky", 64, 32, float_buffer=True)
    pixels = np.full((32, 64, 4), 0.1, np.float32)
    pixels[22:28, 16:30, :3] = 4.0, 3.0, 2.0
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    world = stage.set_world((0, 0, 0))
    world.cycles.sampling_method = "NONE"
    tree = world.node_tree
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    sky.image = image
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])


@pytest.mark.parametrize("add", [add_shining_ball, add_sky_image])
def test_other_lights(add, tmp_path):
    build_tiles(ROW)
    add()
    compare_tiles(ROW, SAMPLES, tmp_path)
