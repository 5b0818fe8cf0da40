"""Scattering against Cycles: each BSDF, tilted to several angles under a sky that is different in every direction.

Cycles' means and variances come from many equal pixels, ours from samples of the BSDF and the compiled world.
"""

import bentlight_native
import bpy
import numpy as np
import pytest
from cycles_values import read_render
from value_cases import empty_tree, new

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_material, compile_world

COSINES = (1.0, 0.8, 0.5, 0.25)
PIXELS = 24  # of each material and cosine
SAMPLES = 128  # of each pixel
OUR_SAMPLES = 150_000

# What the two renderers' tables of the energy of rough lobes may differ by, relative (see microfacet_energy.h).
TABLE_ERROR = {"GGX": 0.0, "MULTI_GGX": 0.004, "glass": 0.015}


def diffuse(tree, roughness):
    return new(tree, "BsdfDiffuse", {"Color": (0.8, 0.5, 0.9, 1), "Roughness": roughness})


def glossy(tree, roughness, distribution):
    inputs = {"Color": (0.9, 0.6, 0.3, 1), "Roughness": roughness}
    return new(tree, "BsdfAnisotropic", inputs, distribution=distribution)


def glass(tree, roughness, distribution="GGX"):
    inputs = {"Color": (0.9, 0.6, 1, 1), "Roughness": roughness, "IOR": 1.45}
    return new(tree, "BsdfGlass", inputs, distribution=distribution)


def principled(tree, distribution="MULTI_GGX", **inputs):
    inputs = {"Base Color": (0.8, 0.4, 0.1, 1), "Roughness": 0.4} | inputs
    return new(tree, "BsdfPrincipled", inputs, distribution=distribution)


def mixed(tree):
    a, b, c = diffuse(tree, 0), glossy(tree, 0.3, "GGX"), new(tree, "BsdfTransparent", {0: (0.3, 0.9, 0.5, 1)})
    first = new(tree, "MixShader", {0: 0.3, 1: a.outputs[0], 2: b.outputs[0]})
    dim = new(tree, "MixShader", {0: 0.6, 1: first.outputs[0], 2: c.outputs[0]})
    light = new(tree, "Emission", {0: (0.2, 0.1, 0.05, 1), 1: 2.0})
    return new(tree, "AddShader", {0: dim.outputs[0], 1: light.outputs[0]})


TINTED_PLASTIC = {"Specular Tint": (0.2, 0.9, 1, 1), "Specular IOR Level": 0.9, "Diffuse Roughness": 0.5}
CASES = {
    "diffuse": (lambda t: diffuse(t, 0), 0),
    "oren_nayar": (lambda t: diffuse(t, 0.7), 1e-4),
    "mirror": (lambda t: glossy(t, 0, "GGX"), 0),
    "glossy": (lambda t: glossy(t, 0.3, "GGX"), 0),
    "glossy_multiple": (lambda t: glossy(t, 0.7, "MULTI_GGX"), TABLE_ERROR["MULTI_GGX"]),
    "glass_smooth": (lambda t: glass(t, 0), 0),
    "glass_rough": (lambda t: glass(t, 0.4), 0),
    "glass_multiple": (lambda t: glass(t, 0.4, "MULTI_GGX"), TABLE_ERROR["glass"]),
    "plastic": (principled, TABLE_ERROR["MULTI_GGX"]),
    "plastic_single": (lambda t: principled(t, "GGX"), TABLE_ERROR["MULTI_GGX"]),
    "smooth_plastic": (lambda t: principled(t, Roughness=0.0, IOR=1.8), TABLE_ERROR["MULTI_GGX"]),
    "tinted_plastic": (
        lambda t: principled(
            t, **{"Specular Tint": (0.2, 0.9, 1, 1), "Specular IOR Level": 0.9, "Diffuse Roughness": 0.5}
        ),
        TABLE_ERROR["MULTI_GGX"],
    ),
    "metal": (lambda t: principled(t, Metallic=1.0), TABLE_ERROR["MULTI_GGX"]),
    "tinted_metal": (
        lambda t: principled(t, Metallic=1.0, **{"Specular Tint": (0.3, 1, 0.7, 1)}),
        TABLE_ERROR["MULTI_GGX"],
    ),
    "half_metal": (lambda t: principled(t, Metallic=0.5, Alpha=0.6), TABLE_ERROR["MULTI_GGX"]),
    "transmission": (lambda t: principled(t, **{"Transmission Weight": 1.0}), TABLE_ERROR["glass"]),
    "transmission_smooth": (
        lambda t: principled(t, Roughness=0.0, **{"Transmission Weight": 0.7}),
        TABLE_ERROR["glass"],
    ),
    "emitting": (lambda t: principled(t, **{"Emission Strength": 1.5, "Alpha": 0.5}), TABLE_ERROR["MULTI_GGX"]),
    "mixed": (mixed, 0),
}


def make_material(name):
    material = bpy.data.materials.new(name)
    tree = empty_tree(material)
    shader = CASES[name][0](tree)
    new(tree, "OutputMaterial", {"Surface": shader.outputs[0]})
    return material


def make_world():
    """Radiance 0.5 + 0.45 (x, y, z) of the direction, so that every lobe's direction matters."""
    world = bpy.data.worlds.new("directions")
    tree = empty_tree(world)
    place = new(tree, "TexCoord").outputs["Generated"]
    inputs = {0: place, "Scale": (0.45, 0.45, 0.45), "Location": (0.5, 0.5, 0.5)}
    background = new(tree, "Background", {"Color": new(tree, "Mapping", inputs).outputs[0]})
    new(tree, "OutputWorld", {"Surface": background.outputs[0]})
    return world


def tilted_quads(materials):
    """One quad a pixel that seems as large as it from above; columns by cosine, rows by material and side."""
    vertices, faces, rows = [], [], []
    for row in range(len(materials) * 2):
        for column in range(len(COSINES) * PIXELS):
            cosine = COSINES[column // PIXELS]
            slope = np.sqrt(1 - cosine**2) / cosine
            flip = row % 2 == 1
            corners = [(0, 0, 0), (1, 0, -slope), (1, 1, -slope), (0, 1, 0)]
            start = len(vertices)
            vertices += [(column + x, row + y, z) for x, y, z in corners]
            face = [start, start + 1, start + 2, start + 3]
            faces.append(face[::-1] if flip else face)
            rows.append(row // 2)
    mesh = bpy.data.meshes.new("quads")
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("material_index", np.array(rows, np.int32))
    for material in materials:
        mesh.materials.append(material)
    quads = bpy.data.objects.new("quads", mesh)
    quads.visible_diffuse = quads.visible_glossy = quads.visible_transmission = False
    quads.visible_shadow = False
    return quads


def render_cycles(materials, world, path):
    """(materials, front and back, cosines, pixels, 3)"""
    scene = bpy.data.scenes.new("albedo")
    scene.world = world
    # Light sampling finds light through rough glass that Cycles' own BSDF sampling never does, and more than came in.
    world.cycles.sampling_method = "NONE"
    scene.collection.objects.link(tilted_quads(materials))
    rows, columns = 2 * len(materials), len(COSINES) * PIXELS
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", max(rows, columns)
    camera.location = (columns / 2, rows / 2, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = columns, rows
    cycles = scene.cycles
    cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = SAMPLES, False, False
    cycles.filter_width, cycles.blur_glossy, cycles.light_sampling_threshold = 0.01, 0.0, 0.0
    cycles.sample_clamp_indirect = 0.0
    return read_render(scene, path).reshape(len(materials), 2, len(COSINES), PIXELS, 3)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """Cycles' pixels, our scene, and the index of each material in it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials, world = [make_material(name) for name in CASES], make_world()
    pixels = render_cycles(materials, world, tmp_path_factory.mktemp("cycles") / "albedo.exr")
    scene, images = bentlight_native.Scene(), ImageTable()
    scene.set_world(compile_world(world, images).program)
    indices = [scene.add_material(compile_material(material, images).program) for material in materials]
    return dict(zip(CASES, pixels, strict=True)), scene, dict(zip(CASES, indices, strict=True))


@pytest.mark.parametrize("name", CASES)
def test_scattered_light_is_that_of_cycles(rendered, name):
    pixels, scene, indices = rendered
    u = np.random.default_rng(11).random((OUR_SAMPLES, 3))
    worst = 0.0
    for side in (0, 1):
        for k, cosine in enumerate(COSINES):
            normal = (np.sqrt(1 - cosine**2), 0, cosine)
            point = {"normal": normal, "geometric_normal": normal, "backfacing": float(side)}
            drawn = scene.draw_bsdf(indices[name], u, **point)
            ours = drawn.weight * scene.sky(drawn.wi) * (drawn.lobe != 0)[:, None]
            ours = ours + scene.shade(indices[name], **point)["emission"]
            theirs = pixels[name][side, k]
            variance = ours.var(axis=0) / OUR_SAMPLES + theirs.var(axis=0, ddof=1) / PIXELS
            difference = np.abs(ours.mean(axis=0) - theirs.mean(axis=0))
            excess = difference - CASES[name][1] * theirs.mean(axis=0)
            worst = max(worst, (excess / np.sqrt(variance + 1e-12)).max())
    assert worst < 4.5
