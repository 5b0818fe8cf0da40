"""Where Bentlight's camera rays go, against where Cycles' go: same pixels, same directions and starting points."""

import bpy
import numpy as np
import pytest
from bentlight_native import Scene

from blender_addon.sync.camera import read_camera
from tests.engine import stage
from tests.engine.stage import blender  # noqa: F401 (a fixture)

JITTER = 0.005  # pixels: half of Cycles' narrowest pixel filter
CYCLES_DIRECTION = 1e-6  # float32: eight units in the last place of 1

FISHEYE = {"type": "PANO", "fisheye_fov": 2.5}
CAMERAS = {
    "wide": (36, 20, {}, {}),
    "tall": (20, 36, {}, {}),
    "shift": (30, 20, {"shift_x": 0.2, "shift_y": -0.1}, {}),
    "vertical fit": (30, 20, {"sensor_fit": "VERTICAL", "shift_y": 0.1, "shift_x": 0.1}, {}),
    "horizontal fit": (20, 30, {"sensor_fit": "HORIZONTAL", "sensor_width": 20.0}, {}),
    "pixel aspect": (24, 20, {"shift_x": 0.1, "lens": 20.0}, {"pixel_aspect_x": 1.5}),
    "tall pixels": (24, 20, {"shift_x": 0.1}, {"pixel_aspect_y": 2.0}),
    "percentage": (65, 43, {"shift_y": 0.1}, {"resolution_percentage": 35}),
    "equirectangular": (24, 16, {"type": "PANO", "panorama_type": "EQUIRECTANGULAR"}, {}),
    "part of a panorama": (
        24, 16,
        {"type": "PANO", "panorama_type": "EQUIRECTANGULAR", "latitude_min": -0.5, "latitude_max": 1.0,
         "longitude_min": -1.0, "longitude_max": 0.3, "shift_x": 0.2, "shift_y": 0.1},
        {},
    ),
    "equidistant": (24, 16, FISHEYE | {"panorama_type": "FISHEYE_EQUIDISTANT"}, {}),
    "equisolid": (24, 16, FISHEYE | {"panorama_type": "FISHEYE_EQUISOLID", "shift_x": 0.1}, {}),
    "equisolid, tall": (
        16, 24, FISHEYE | {"panorama_type": "FISHEYE_EQUISOLID", "sensor_fit": "HORIZONTAL", "sensor_width": 30.0}, {}
    ),
    "equisolid, wide pixels": (
        16, 24, FISHEYE | {"panorama_type": "FISHEYE_EQUISOLID", "shift_y": 0.1}, {"pixel_aspect_x": 2.0}
    ),
    "lens polynomial": (24, 16, FISHEYE | {"panorama_type": "FISHEYE_LENS_POLYNOMIAL"}, {}),
    "mirror ball": (24, 24, {"type": "PANO", "panorama_type": "MIRRORBALL"}, {}),
    "cube face": (24, 16, {"type": "PANO", "panorama_type": "EQUIANGULAR_CUBEMAP_FACE"}, {}),
    "cylinder": (
        24, 16,
        {"type": "PANO", "panorama_type": "CENTRAL_CYLINDRICAL", "central_cylindrical_radius": 0.7,
         "central_cylindrical_range_u_min": -1.0},
        {},
    ),
}  # fmt: skip


def make_camera(width, height, lens, settings) -> bpy.types.Object:
    """A camera that is turned, moved, scaled and mirrored, for which no two axes are the same."""
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = width, height
    for name, value in settings.items():
        setattr(render, name, value)
    return stage.add_camera((0.3, -0.2, 0.5), (0.4, -0.3, 0.9), **lens)


def native_rays(camera: bpy.types.Object, offset=(0.0, 0.0)):
    """Bentlight's rays through the centers of all pixels, moved by `offset` pixels."""
    bpy.context.view_layer.update()
    render = bpy.context.scene.render
    data = read_camera(camera, render, np.array(camera.matrix_world), camera.data.shift_x)
    scene = Scene()
    scene.set_camera(data.kind, data.world_from_camera, data.window, data.clip_start, data.clip_end, **data.panorama)
    scene.commit()
    x, y = np.meshgrid(np.arange(data.width) + 0.5 + offset[0], np.arange(data.height) + 0.5 + offset[1])
    rays = scene.camera_rays(np.stack([x.ravel() / data.width, y.ravel() / data.height], axis=1))
    shape = (data.height, data.width, 3)
    return rays.origins.reshape(shape), rays.directions.reshape(shape)


def cycles_picture(tmp_path) -> np.ndarray:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 2 * JITTER
    return stage.render(tmp_path)["Combined"][..., :3]


def show_vector(tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, shader: bpy.types.NodeSocket) -> None:
    """Connects a vector to a color, mapped from [-1, 1] to [0, 1]."""
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "MULTIPLY_ADD"
    node.inputs[1].default_value = node.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(socket, node.inputs[0])
    tree.links.new(node.outputs[0], shader)


@pytest.mark.parametrize("name", CAMERAS)
def test_directions_are_those_of_cycles(name, tmp_path):
    camera = make_camera(*CAMERAS[name])
    camera.scale = (2.0, 0.5, 3.0)
    tree = stage.set_world((0, 0, 0)).node_tree
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    show_vector(tree, coordinates.outputs["Generated"], background.inputs["Color"])
    picture = cycles_picture(tmp_path)
    cycles = 2 * picture - 1
    _, ours = native_rays(camera)
    assert ours.shape == cycles.shape
    around = [native_rays(camera, (dx, dy))[1] for dx in (-JITTER, JITTER) for dy in (-JITTER, JITTER)]
    seen = np.isfinite(ours).all(axis=2)
    sure = seen & np.isfinite(around).all(axis=(0, 3))
    outside = ~seen & ~np.isfinite(around).any(axis=(0, 3))
    assert (picture[outside] == 0).all()
    assert sure.sum() + outside.sum() >= 0.98 * seen.size
    reach = np.max([np.abs(other - ours) for other in around], axis=0)
    assert (np.abs(cycles - ours) <= 1.01 * reach + CYCLES_DIRECTION)[sure].all()


@pytest.mark.parametrize("sensor_fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
def test_orthographic_positions_are_those_of_cycles(sensor_fit, tmp_path):
    camera = make_camera(
        30, 20, {"type": "ORTHO", "ortho_scale": 0.8, "shift_x": 0.1, "shift_y": 0.05, "sensor_fit": sensor_fit}, {}
    )
    material = stage.emission((1, 1, 1))
    tree = material.node_tree
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    shader = next(node for node in tree.nodes if node.type == "EMISSION")
    show_vector(tree, geometry.outputs["Position"], shader.inputs["Color"])
    stage.add_square(20, (0, 0, -1), material)
    cycles = 2 * cycles_picture(tmp_path) - 1
    origins, directions = native_rays(camera)
    ours = origins + directions * ((-1 - origins[..., 2:]) / directions[..., 2:])
    pixel = 0.8 / 20
    assert np.abs(cycles - ours).max() <= JITTER * pixel * 3 + 3e-6
