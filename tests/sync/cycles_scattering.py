"""What Cycles scatters from each of many materials at once, tilted to several angles under a sky that is different in
every direction, and the same by our BSDFs.

Cycles' means come from renders with different seeds, ours from samples of the BSDF and the compiled world. A render's
pixels would not do as independent samples: Cycles spreads its error as blue noise, so that neighbors make up for each
other, and their mean varies by a third less than their variance says.
"""

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import bentlight_native
import bpy
import numpy as np
from cycles_values import read_render
from value_cases import empty_tree, new

from blender_addon.sync.images import ImageTable
from blender_addon.sync.material import compile_material, compile_world

SEEDS = 8
PIXELS = 4  # of each material and cosine
SAMPLES = 128  # of each pixel
OUR_SAMPLES = 150_000
VIEW = np.array([0.0, 0.0, 1.0])  # towards the camera


@dataclass(frozen=True)
class Scattered:
    """Independent estimates of the radiance towards the camera, for image_statistics.welch_z."""

    cycles: np.ndarray  # (SEEDS, 3)
    ours: np.ndarray  # (OUR_SAMPLES, 3)


def sky(directions: np.ndarray) -> np.ndarray:
    """Radiance (..., 3) from unit vectors: different in every direction, so that every lobe's direction matters."""
    return 0.5 + 0.45 * directions


def geometric_normal(cosine: float) -> np.ndarray:
    """Of the quad that is seen under this cosine."""
    return np.array([np.sqrt(1 - cosine**2), 0, cosine])


class Comparison:
    """Materials by name, made by functions of a node tree that return their surface shader."""

    def __init__(self, shaders: dict[str, Callable], cosines: tuple[float, ...], path) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        materials, world = [_make_material(*item) for item in shaders.items()], _make_world()
        means = _render_cycles(materials, cosines, world, path)
        self._cosines, self._cycles = cosines, dict(zip(shaders, means, strict=True))
        self._scene, images = bentlight_native.Scene(), ImageTable()
        self._scene.set_world(compile_world(world, images).program)
        indices = [self._scene.add_material(compile_material(material, images).program) for material in materials]
        self._indices = dict(zip(shaders, indices, strict=True))

    def scattered(self, name: str, side: int, cosine: float) -> Scattered:
        """`side` 1: seen from behind; `cosine`: of the angle between the normal and the direction to the camera."""
        normal, column = geometric_normal(cosine), self._cosines.index(cosine)
        point = {"normal": normal, "geometric_normal": normal, "backfacing": float(side)}
        index, scene = self._indices[name], self._scene
        random = np.random.default_rng([zlib.crc32(name.encode()), side, column])
        drawn = scene.draw_bsdf(index, random.random((OUR_SAMPLES, 3)), **point)
        ours = drawn.weight * scene.sky(drawn.wi) * (drawn.lobe != 0)[:, None]
        return Scattered(self._cycles[name][:, side, column], ours + scene.shade(index, **point)["emission"])


def _make_material(name, build):
    material = bpy.data.materials.new(name)
    tree = empty_tree(material)
    new(tree, "OutputMaterial", {"Surface": build(tree).outputs[0]})
    return material


def _make_world():
    """The function sky() in nodes."""
    world = bpy.data.worlds.new("directions")
    tree = empty_tree(world)
    place = new(tree, "TexCoord").outputs["Generated"]
    inputs = {0: place, "Scale": (0.45, 0.45, 0.45), "Location": (0.5, 0.5, 0.5)}
    background = new(tree, "Background", {"Color": new(tree, "Mapping", inputs).outputs[0]})
    new(tree, "OutputWorld", {"Surface": background.outputs[0]})
    return world


def _tilted_quads(materials, cosines):
    """One quad a pixel that seems as large as it from above; columns by cosine, rows by material and side."""
    vertices, faces, rows = [], [], []
    for row in range(len(materials) * 2):
        for column in range(len(cosines) * PIXELS):
            cosine = cosines[column // PIXELS]
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


def _render_cycles(materials, cosines, world, path):
    """(materials, seeds, front and back, cosines, 3)"""
    scene = bpy.data.scenes.new("albedo")
    scene.world = world
    # Light sampling finds light through rough glass that Cycles' own BSDF sampling never does, and more than came in.
    world.cycles.sampling_method = "NONE"
    scene.collection.objects.link(_tilted_quads(materials, cosines))
    rows, columns = 2 * len(materials), len(cosines) * PIXELS
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
    renders = []
    for seed in range(SEEDS):
        cycles.seed = seed
        renders.append(read_render(scene, path).reshape(len(materials), 2, len(cosines), PIXELS, 3).mean(axis=3))
    return np.stack(renders, axis=1).astype(float)
