"""Camera rays against closed forms, Blender's own projection, and what Cycles sees through every lens."""

import os

import bpy
import numpy as np
import OpenEXR
import pytest
from bentlight_native import Scene
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector
from scenes import add, diffuse, look_at, new_scene, perspective, quad, render

PANORAMA_NAMES = [
    "longitude_min",
    "longitude_max",
    "latitude_min",
    "latitude_max",
    "fisheye_fov",
    "fisheye_lens",
    *(f"fisheye_polynomial_k{i}" for i in range(5)),
    "central_cylindrical_range_u_min",
    "central_cylindrical_range_u_max",
    "central_cylindrical_range_v_min",
    "central_cylindrical_range_v_max",
    "central_cylindrical_radius",
]
RNG = np.random.default_rng(7)
POINTS = RNG.uniform(0, 1, (500, 2))
POSE = look_at((1.0, -2.0, 0.5), (0.2, 0.3, 0.1))


def test_perspective():
    scene = Scene()
    left, right, bottom, top = -0.3, 0.6, -0.2, 0.5
    scene.set_camera("PERSPECTIVE", POSE, (left, right, bottom, top), 0.1, 50.0)
    rays = scene.camera_rays(POINTS)
    in_camera = rays.directions @ POSE[:3, :3]
    plane = in_camera[:, :2] / -in_camera[:, 2:]
    expected = np.column_stack([left + POINTS[:, 0] * (right - left), bottom + POINTS[:, 1] * (top - bottom)])
    assert np.abs(plane - expected).max() < 1e-14
    assert np.abs(np.linalg.norm(rays.directions, axis=1) - 1).max() < 1e-15
    assert (rays.origins == POSE[:3, 3]).all()
    assert np.abs(rays.depth_per_length + in_camera[:, 2]).max() < 1e-15
    assert np.abs(rays.length_min * rays.depth_per_length - 0.1).max() < 1e-15
    assert np.abs(rays.length_max * rays.depth_per_length - 50).max() < 1e-13


def test_orthographic():
    scene = Scene()
    scene.set_camera("ORTHOGRAPHIC", POSE, (-2, 3, -1, 1.5), 0.0, 9.0)
    rays = scene.camera_rays(POINTS)
    local = (rays.origins - POSE[:3, 3]) @ POSE[:3, :3]
    assert (
        np.abs(local - np.column_stack([-2 + 5 * POINTS[:, 0], -1 + 2.5 * POINTS[:, 1], 0 * POINTS[:, 0]])).max()
        < 1e-14
    )
    assert np.abs(rays.directions + POSE[:3, 2]).max() < 1e-15
    assert (rays.length_max == 9).all() and (rays.depth_per_length == 1).all()


def test_scale_of_the_matrix_is_ignored():
    plain, scaled = Scene(), Scene()
    plain.set_camera("PERSPECTIVE", POSE, (-1, 1, -1, 1))
    scaled.set_camera("PERSPECTIVE", POSE @ np.diag([2.0, 0.5, 7.0, 1.0]), (-1, 1, -1, 1))
    assert np.abs(plain.camera_rays(POINTS).directions - scaled.camera_rays(POINTS).directions).max() < 1e-15


@pytest.mark.parametrize(
    "kind, shape, parameters",
    [
        ("FISHEYE_EQUIDISTANT", lambda r: r * 1.5, {"fisheye_fov": 3.0}),
        ("FISHEYE_EQUISOLID", lambda r: 2 * np.arcsin(r * 18 / (2 * 12)),
         {"fisheye_fov": 6.0, "fisheye_lens": 12, "sensor_width": 36, "sensor_height": 36}),
        ("FISHEYE_LENS_POLYNOMIAL", lambda r: 0.09 * r * 18 + 1e-4 * (r * 18) ** 3,
         {"fisheye_fov": 2.5, "sensor_width": 36, "sensor_height": 36, "fisheye_polynomial_k1": -0.09,
          "fisheye_polynomial_k3": -1e-4}),
    ],
)  # fmt: skip
def test_fisheye_angle(kind, shape, parameters):
    """The angle to the axis is a function of the distance from the center, where it is within the field of view."""
    scene = Scene()
    scene.set_camera(kind, np.eye(4), (0, 1, 0, 1), **parameters)
    rays = scene.camera_rays(POINTS)
    u = 2 * POINTS - 1
    r = np.hypot(*u.T)
    inside = np.where(r * 18 / 24 <= 1, shape(np.minimum(r, 4 / 3)), np.inf) <= parameters["fisheye_fov"] / 2
    assert (np.isnan(rays.directions[:, 0]) == ~inside).all() and 0.2 < inside.mean() < 1
    angle = np.arccos(-rays.directions[inside, 2])
    assert np.abs(angle - shape(r[inside])).max() < 1e-12
    turned = np.arctan2(rays.directions[inside, 1], rays.directions[inside, 0])
    assert np.abs(np.exp(1j * turned) - np.exp(1j * np.arctan2(u[inside, 1], u[inside, 0]))).max() < 1e-12


@pytest.mark.parametrize(
    "change, word",
    [
        ({"kind": "PINHOLE"}, "PINHOLE"),
        ({"world_from_camera": np.zeros((4, 4))}, "singular"),
        ({"world_from_camera": np.full((4, 4), np.nan)}, "NaN"),
        ({"world_from_camera": np.eye(3)}, "shape"),
        ({"viewplane": (1, 1, 0, 1)}, "viewplane"),
        ({"viewplane": (0, 1, 0, np.inf)}, "viewplane"),
        ({"clip_start": -1.0}, "clip"),
        ({"clip_end": 0.0}, "clip"),
        ({"kind": "FISHEYE_EQUIDISTANT", "fisheye_fov": 0.0}, "fisheye_fov"),
        ({"kind": "FISHEYE_EQUISOLID", "fisheye_lens": 0.0}, "fisheye_lens"),
        ({"kind": "FISHEYE_EQUISOLID", "sensor_width": np.nan}, "sensor"),
        ({"kind": "FISHEYE_LENS_POLYNOMIAL", "fisheye_polynomial_k2": np.nan}, "finite"),
        ({"kind": "EQUIRECTANGULAR", "latitude_max": np.inf}, "finite"),
        ({"kind": "CENTRAL_CYLINDRICAL", "central_cylindrical_radius": 0.0}, "radius"),
    ],
)
def test_bad_cameras_are_named(change, word):
    arguments = {"kind": "PERSPECTIVE", "world_from_camera": np.eye(4), "viewplane": (-1, 1, -1, 1), **change}
    with pytest.raises(ValueError, match=word):
        Scene().set_camera(**arguments)


def test_clip_range():
    """Surfaces before clip_start and behind clip_end are not there; depth is measured along the view axis."""
    scene = new_scene((1, 1, 1))
    for z in (-1.0, -2.0, -3.0):
        at = np.eye(4)
        at[2, 3] = z
        add(scene, quad(9, 9), diffuse((0, 0, 0)), at=at)
    for start, end, depth in [(0, 9, 1), (1.5, 9, 2), (1.5, 1.9, 1e10), (2.5, 3.5, 3), (0, 0.9, 1e10)]:
        perspective(scene, half=1.0, clip_start=start, clip_end=end)
        scene.commit()
        channels, _ = render(scene, samples=1)
        assert channels["depth"] == pytest.approx(depth, rel=1e-6)
        assert (channels["combined"][..., 0] == (1 if depth == 1e10 else 0)).all()


@pytest.fixture
def blender():
    """A Blender scene of 16 x 16 pixels with a camera, rendered by Cycles through pixel centers, one sample."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.filter_width = 0.01
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x = scene.render.resolution_y = 16
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
    layer.cycles.denoising_store_passes = True
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.matrix_world = Matrix(POSE)
    bpy.context.view_layer.update()
    return scene


def cycles_passes(scene, folder):
    """{pass: (height, width, components)} of a render, rows from the bottom."""
    path = os.path.join(folder, "passes.exr")
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    planes = {}
    for part in OpenEXR.File(path, separate_channels=True).parts:
        for name, channel in part.channels.items():
            planes[tuple(name.split(".")[-2:])] = channel.pixels[::-1]
    names = {name for name, _ in planes}
    return {
        name: np.stack([planes[name, c] for c in "XYZRGBAV" if (name, c) in planes], -1).astype(float) for name in names
    }


def blender_sphere(radius):
    """Adds a diffuse sphere of albedo 0.8 to the Blender scene; returns its vertices and triangles."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, segments=64, ring_count=32)
    mesh = bpy.context.object.data
    mesh.materials.append(bpy.data.materials.new("Diffuse"))
    if not mesh.materials[0].node_tree:
        mesh.materials[0].use_nodes = True  # Blender 5 has nodes always
    nodes, links = mesh.materials[0].node_tree.nodes, mesh.materials[0].node_tree.links
    shader = nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = 0.8, 0.8, 0.8, 1
    links.new(shader.outputs[0], nodes["Material Output"].inputs["Surface"])
    mesh.calc_loop_triangles()
    vertices = np.array([v.co[:] for v in mesh.vertices], np.float32)
    return vertices, np.array([t.vertices[:] for t in mesh.loop_triangles], np.uint32)


def viewplane(scene):
    """The camera's frame at distance 1 (perspective) or in scene units, from Blender itself."""
    corners = np.array([corner[:] for corner in scene.camera.data.view_frame(scene=scene)])
    if scene.camera.data.type == "PERSP":
        corners = corners / -corners[:, 2:]
    return corners[:, 0].min(), corners[:, 0].max(), corners[:, 1].min(), corners[:, 1].max()


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit, size", [("AUTO", (16, 9)), ("HORIZONTAL", (9, 16)), ("VERTICAL", (16, 9))])
def test_agrees_with_world_to_camera_view(blender, kind, fit, size):
    """Points along our rays lie where Blender projects them to, with shift and every sensor fit."""
    data = blender.camera.data
    data.type, data.sensor_fit, data.lens, data.ortho_scale = kind, fit, 35.0, 3.0
    data.shift_x, data.shift_y = 0.13, -0.21
    blender.render.resolution_x, blender.render.resolution_y = size
    scene = Scene()
    scene.set_camera({"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC"}[kind], POSE, viewplane(blender))
    rays = scene.camera_rays(POINTS[:50])
    for point, origin, direction in zip(POINTS, rays.origins, rays.directions, strict=False):
        seen = world_to_camera_view(blender, blender.camera, Vector(origin + 2.5 * direction))
        assert np.abs(np.array(seen[:2]) - point).max() < 3e-6  # Blender computes in float32


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_passes_agree_with_cycles(blender, tmp_path, kind):
    """Depth, position, normal and the denoising passes of a sphere and the emptiness around it."""
    blender.camera.data.type = kind
    blender.camera.data.ortho_scale = 3.0
    sphere = blender_sphere(0.85)  # no pixel's center lies within its jitter of the outline
    cycles = cycles_passes(blender, tmp_path)
    scene = new_scene()
    add(scene, sphere, diffuse((0.8, 0.8, 0.8)))
    scene.set_camera({"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC"}[kind], POSE, viewplane(blender), 0.1, 100.0)
    scene.commit()
    ours, _ = render(scene, samples=1, filter_width=0.01)
    empty = cycles["Depth"][..., 0] > 1e9
    assert ((ours["depth"][..., 0] > 1e9) == empty).all() and 0.1 < empty.mean() < 0.9
    # Samples lie anywhere in the middle hundredth of a pixel, and facets have edges: compare medians and most pixels.
    for name, ours_name in [
        ("Depth", "depth"),
        ("Position", "position"),
        ("Normal", "normal"),
        ("Denoising Normal", "denoising_normal"),
        ("Denoising Albedo", "denoising_albedo"),
    ]:
        difference = np.abs(cycles[name] - ours[ours_name]).max(-1)
        assert np.median(difference[~empty]) < 2e-3, name
        assert (difference[~empty] < 0.03).mean() > 0.97, name
        assert (difference[empty] == 0).all(), name


@pytest.mark.parametrize(
    "kind",
    [
        "EQUIRECTANGULAR",
        "EQUIANGULAR_CUBEMAP_FACE",
        "MIRRORBALL",
        "FISHEYE_EQUIDISTANT",
        "FISHEYE_EQUISOLID",
        "FISHEYE_LENS_POLYNOMIAL",
        "CENTRAL_CYLINDRICAL",
    ],
)
def test_panoramas_agree_with_cycles(blender, tmp_path, kind):
    """Directions from Cycles' Position pass inside a large sphere, and alpha 1 where the lens has no ray."""
    data = blender.camera.data
    data.type = "PANO"
    lens = data if hasattr(data, "fisheye_fov") else data.cycles
    lens.panorama_type = kind
    lens.longitude_min, lens.latitude_max = -2.0, 0.7
    lens.fisheye_fov = 2.9
    lens.central_cylindrical_range_v_max, lens.central_cylindrical_radius = 1.4, 1.2
    sphere = blender_sphere(50)
    cycles = cycles_passes(blender, tmp_path)
    scene = new_scene()
    parameters = {name: getattr(lens, name) for name in PANORAMA_NAMES}
    sensor = {"sensor_width": data.sensor_width, "sensor_height": data.sensor_width}  # a square image
    scene.set_camera(kind, POSE, (0, 1, 0, 1), **parameters, **sensor)
    add(scene, sphere, diffuse((0, 0, 0)))
    scene.commit()
    centers = (np.stack(np.meshgrid(np.arange(16), np.arange(16)), -1).reshape(-1, 2) + 0.5) / 16
    rays = scene.camera_rays(centers)
    seen = cycles["Position"].reshape(-1, 3) - POSE[:3, 3]
    empty = cycles["Depth"].ravel() > 1e9
    assert (np.isnan(rays.directions[:, 0]) == empty).all()
    seen = seen[~empty] / np.linalg.norm(seen[~empty], axis=1, keepdims=True)
    assert np.abs(seen - rays.directions[~empty]).max() < 5e-3 * 2 * np.pi / 16  # half the filter's width in angle
    ours, _ = render(scene, samples=1, filter_width=0.01)
    assert (ours["combined"][..., 3] == cycles["Combined"][..., 3]).all()
    assert ours["depth"].ravel()[~empty] == pytest.approx(cycles["Depth"].ravel()[~empty], rel=5e-3)
