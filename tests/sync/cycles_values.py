"""What Cycles makes of many node trees at once: one emissive quad of one pixel for every value.

Each row of the picture has its own material, each column its own UV, constant over the quad; so the exact place of a
sample within the pixel does not matter.
"""

import bpy
import numpy as np


def render_rows(materials, uvs, path):
    """Radiance (materials, values, 3) of each material at each of `uvs` (values, 2)."""
    return render_emission(_quads(materials, uvs), len(materials), len(uvs), path)


def render_emission(quads, rows, columns, path, pixel=1.0):
    """The radiance (rows, columns, 3) of an object that fills, seen from above, that many pixels from the origin."""
    scene = bpy.data.scenes.new("values")
    scene.collection.objects.link(quads)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = max(rows, columns) * pixel
    camera.location = (columns * pixel / 2, rows * pixel / 2, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = columns, rows, 100
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.cycles.filter_width = 0.01
    return read_render(scene, path)


def render_world(world, camera_data, rotation, width, height, path):
    """What a camera sees of a world and nothing else, one sample in the middle of each pixel: as read_render."""
    scene = bpy.data.scenes.new(world.name)
    scene.world = world
    world.cycles.sampling_method = "NONE"  # its map takes long to build
    camera = bpy.data.objects.new("camera", camera_data)
    camera.rotation_euler = rotation
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.filter_width = 1, False, 0.01
    return read_render(scene, path)


def read_render(scene, path):
    """Renders a scene; its linear pixels (height, width, 3) from the bottom up."""
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)[..., :3]


def _quads(materials, uvs):
    rows, columns = len(materials), len(uvs)
    row, column = np.divmod(np.arange(rows * columns), columns)
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    vertices = (np.stack([column, row, 0 * row], 1)[:, None] + corner).reshape(-1, 3)
    mesh = bpy.data.meshes.new("quads")
    mesh.from_pydata(vertices, [], np.arange(len(vertices)).reshape(-1, 4))
    layer = mesh.uv_layers.new(name="UV")
    layer.uv.foreach_set("vector", np.repeat(np.asarray(uvs, np.float32)[column], 4, axis=0).ravel())
    mesh.polygons.foreach_set("material_index", row.astype(np.int32))
    for material in materials:
        mesh.materials.append(material)
    return bpy.data.objects.new("quads", mesh)
