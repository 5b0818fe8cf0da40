"""What cannot be rendered fails the operator and says why, naming the object; no file is written."""

import bpy
import numpy as np
import pytest

from blender_addon import final
from tests.engine import stage

NAN, INFINITY = float("nan"), float("inf")


def failure(tmp_path) -> str:
    """The error of a render that has to fail."""
    with pytest.raises(RuntimeError) as caught:
        stage.render(tmp_path)
    assert not list(tmp_path.glob("*.exr")), "a failed render wrote a file"
    return str(caught.value)


def add_hole(location=(0.0, 0.0, 0.0), **settings) -> bpy.types.Object:
    bpy.ops.bentlight.black_hole_add(location=location)
    for name, value in settings.items():
        setattr(bpy.context.object.bentlight, name, value)
    return bpy.context.object


def add_wormhole(place=(0.0, 0.0, 0.0), exit_place=(10.0, 0.0, 0.0), throat_radius=0.5) -> bpy.types.Object:
    bpy.ops.bentlight.wormhole_add(throat_radius=throat_radius, location=place, exit_location=exit_place)
    return bpy.context.object


def add_cube(**settings) -> bpy.types.Object:
    """A cube of size 2."""
    vertices = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return stage.add_mesh("Cube", vertices, faces, **settings)


def test_no_camera(tmp_path):
    assert "no camera" in failure(tmp_path).lower()


@pytest.mark.parametrize(
    ("settings", "distance", "inside"),
    [
        ({"mass": 1.0}, 0.499, True),
        ({"mass": 1.0}, 0.51, False),
        ({"mass": 1.0, "chart": "OBLATE"}, 1.99, True),
        ({"mass": 1.0, "chart": "OBLATE"}, 2.01, False),
        ({"mass": 1.0, "spin": 0.8}, 1.59, True),  # on the axis: r+ = 1 + 0.6
        ({"mass": 1.0, "spin": 0.8}, 1.61, False),
    ],
)
def test_a_camera_inside_a_horizon(settings, distance, inside, tmp_path):
    add_hole((1, 2, 3), **settings)
    stage.add_camera((1, 2, 3 + distance))
    if inside:
        assert "The camera is inside the horizon of black hole 'Black Hole'" in failure(tmp_path)
    else:
        stage.render(tmp_path)


def test_a_camera_inside_a_throat(tmp_path):
    add_wormhole()
    stage.add_camera((0.1, 0, 0.2))
    assert "The camera is inside the throat of wormhole 'Wormhole'" in failure(tmp_path)


def test_scale_must_be_uniform_and_positive(tmp_path):
    stage.add_camera((0, 0, 9))
    hole = add_hole()
    for scale in ((1, 2, 1), (-1, -1, -1), (1, 1, -1)):
        hole.scale = scale
        assert "Black hole 'Black Hole': its scale must be uniform and positive" in failure(tmp_path)
    hole.scale = (0, 0, 0)
    assert "Black hole 'Black Hole' has scale 0" in failure(tmp_path)
    hole.scale = (0.5, 0.5, 0.5)
    hole.rotation_euler = (1, 2, 3)
    stage.render(tmp_path)


def test_transforms_that_are_not_finite(tmp_path):
    stage.add_camera((0, 0, 9))
    hole = add_hole()
    hole.delta_location = (np.nan, 0, 0)
    assert "Black hole 'Black Hole': its transform or its settings are not finite" in failure(tmp_path)
    bpy.data.objects.remove(hole)
    square = stage.add_square(1.0)
    square.delta_location = (np.nan, 0, 0)
    assert "Object 'Square': its transform is not finite" in failure(tmp_path)
    square.delta_location, square.scale = (0, 0, 0), (1e30, 1e30, 1e30)
    assert "Object 'Square'" in failure(tmp_path)
    bpy.data.objects.remove(square)
    bpy.context.scene.camera.delta_location = (np.nan, 0, 0)
    assert "Camera 'Camera' has a transform that is not finite" in failure(tmp_path)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        *[("tolerance", value, "Ray Tolerance must lie between 1e-12 and 0.1") for value in (NAN, INFINITY, 0.0, 0.2)],
        *[("clamp_indirect", value, "Clamp Indirect must lie between 0 and") for value in (NAN, INFINITY, -1.0)],
        *[("samples", value, "Samples must lie between 1 and") for value in (0, -5)],
        *[(name, -1, "must lie between 0 and") for name in ("seed", "max_bounces", "transparent_bounces")],
    ],
)
def test_settings_out_of_range(name, value, message, tmp_path):
    """The user interface keeps to the ranges, scripts and files need not."""
    stage.add_camera((0, 0, 9))
    bpy.context.scene.bentlight[name] = value
    said = failure(tmp_path)
    assert "Scene 'Scene': " in said and message in said and f"not {value:g}" in said


@pytest.mark.parametrize(
    ("owner", "name", "title"),
    [
        ("bentlight", "tolerance", "Ray Tolerance"),
        ("bentlight", "clamp_indirect", "Clamp Indirect"),
        ("render", "filter_size", "Filter Size"),
    ],
)
def test_the_user_interface_lets_nan_through(owner, name, title, tmp_path):
    stage.add_camera((0, 0, 9))
    setattr(getattr(bpy.context.scene, owner), name, NAN)
    assert f"Scene 'Scene': {title} must lie between" in failure(tmp_path)


@pytest.mark.parametrize("value", [NAN, INFINITY, -INFINITY])
@pytest.mark.parametrize("name", ["mass", "spin", "sphere_radius"])
def test_black_holes_that_are_not_finite(name, value, tmp_path):
    stage.add_camera((0, 0, 9))
    hole = add_hole()
    hole.bentlight[name] = value
    assert "Black hole 'Black Hole': its transform or its settings are not finite" in failure(tmp_path)
    bpy.data.objects.remove(hole)
    add_hole(**{name: NAN})  # through the interface, which redraws the empty
    assert "Black hole 'Black Hole': its transform or its settings are not finite" in failure(tmp_path)


@pytest.mark.parametrize("value", [NAN, INFINITY, -INFINITY])
@pytest.mark.parametrize("name", ["throat_radius", "sphere_radius"])
def test_wormholes_that_are_not_finite(name, value, tmp_path):
    stage.add_camera((0, 0, 9))
    add_wormhole().bentlight[name] = value
    assert "Wormhole 'Wormhole': its transform or its settings are not finite" in failure(tmp_path)


@pytest.mark.parametrize("spin", [1.0, -1.0, 1.5, -3.0])
def test_a_spin_that_is_not_below_the_mass(spin, tmp_path):
    stage.add_camera((0, 0, 9))
    add_hole(mass=0.5).bentlight["spin"] = spin
    assert "Black hole 'Black Hole': its spin must be smaller than its mass" in failure(tmp_path)


def test_sizes_that_are_not_positive(tmp_path):
    stage.add_camera((0, 0, 9))
    hole = add_hole()
    hole.bentlight["mass"] = -1.0
    assert "Black hole 'Black Hole': its mass must not be negative" in failure(tmp_path)
    bpy.data.objects.remove(hole)
    mouth = add_wormhole()
    for radius in (0.0, -1.0):
        mouth.bentlight["throat_radius"] = radius
        assert "Wormhole 'Wormhole': its throat radius must be positive" in failure(tmp_path)


def test_exits_of_wormholes(tmp_path):
    stage.add_camera((0, 0, 9))
    mouth = add_wormhole()
    other = mouth.bentlight.exit
    other.bentlight.kind = "NONE"
    assert "its exit 'Wormhole.001' is not a wormhole mouth that is rendered" in failure(tmp_path)
    other.bentlight.kind = "WORMHOLE"
    other.hide_render = True
    assert "its exit 'Wormhole.001' is not a wormhole mouth that is rendered" in failure(tmp_path)
    other.hide_render = False
    other.bentlight.throat_radius = 0.6
    assert "must have one throat radius, not 0.5 and 0.6" in failure(tmp_path)
    other.bentlight.throat_radius = 0.5
    other.bentlight.exit = None
    assert "its exit 'Wormhole.001' leads elsewhere" in failure(tmp_path)
    mouth.bentlight.exit = None
    assert "Wormhole 'Wormhole' has no exit" in failure(tmp_path)
    mouth.bentlight.exit = other
    stage.render(tmp_path)


def test_overlaps(tmp_path):
    stage.add_camera((0, 0, 9))
    mouth = add_wormhole(exit_place=(0.45, 0, 0))
    assert "Wormhole 'Wormhole' and 'Wormhole.001' overlap" in failure(tmp_path)
    mouth.bentlight.exit.location.x = 6
    hole = add_hole((3, 0, 4), mass=0.1)
    stage.render(tmp_path)
    mouth.bentlight.sphere_radius = hole.bentlight.sphere_radius = 3.0
    message = failure(tmp_path)
    assert "The spheres of influence of" in message and "'Wormhole'" in message and "'Black Hole'" in message
    hole.bentlight.sphere_radius = 0.04
    assert "does not reach out of its horizon" in failure(tmp_path)


@pytest.mark.parametrize("scale", [(0, 0, 0), (0, 1, 0), (0, 1, 1)])
def test_an_object_scaled_to_zero_size(scale, tmp_path):
    stage.add_camera((0, 0, 5))
    square = stage.add_square(1.0)
    square.rotation_euler = (1, 2, 3)
    square.scale = scale
    assert "Object 'Square' has zero size" in failure(tmp_path)
    square.hide_render = True  # which is how to hide it
    stage.render(tmp_path)
    square.hide_render, square.scale = False, (1, 1, 1)
    stage.render(tmp_path)


def test_a_parent_scaled_to_a_line(tmp_path):
    """The child's matrix has only parallel columns, rounded to float32 each."""
    stage.add_camera((0, 0, 5))
    cube = add_cube()
    cube.parent = stage.add_square(1.0, (3, 0, 0))
    cube.rotation_euler, cube.parent.rotation_euler = (1, 2, 3), (3, 1, 2)
    cube.parent.scale = (0, 0, 0.7)
    cube.parent.hide_render = True
    assert "Object 'Cube' has zero size" in failure(tmp_path)


@pytest.mark.parametrize(
    "vertices",
    [
        [(1, 2, 3)] * 3,
        [(0.1, 0.7, 0.3), (0.2, 1.4, 0.6), (0.37, 2.59, 1.11)],  # on a line, but for rounding
        [(0, 0, 0), (1, 0, 0), (1, 0, 0)],
    ],
)
def test_a_mesh_of_zero_size(vertices, tmp_path):
    stage.add_camera((0, 0, 5))
    stage.add_mesh("Thin", vertices, [(0, 1, 2)])
    assert "Object 'Thin' has zero size" in failure(tmp_path)


def test_a_modifier_that_leaves_zero_size(tmp_path):
    """Geometry nodes that set every position to the origin."""
    stage.add_camera((0, 0, 5))
    tree = bpy.data.node_groups.new("gather", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    kinds = "NodeGroupInput", "GeometryNodeSetPosition", "NodeGroupOutput", "FunctionNodeInputVector"
    start, gather, end, origin = (tree.nodes.new(kind) for kind in kinds)
    tree.links.new(start.outputs[0], gather.inputs["Geometry"])
    tree.links.new(origin.outputs[0], gather.inputs["Position"])
    tree.links.new(gather.outputs[0], end.inputs[0])
    modifier = stage.add_square(1.0).modifiers.new("gather", "NODES")
    modifier.node_group = tree
    assert "Object 'Square' has zero size" in failure(tmp_path)
    modifier.show_render = False
    stage.render(tmp_path)


def test_a_few_triangles_without_area_do_no_harm(capfd, tmp_path):
    stage.add_camera((0, 0, 5))
    stage.add_mesh("mixed", [(-9, -9, 0), (9, -9, 0), (0, 9, 0)], [(0, 1, 1)] * 5000 + [(0, 1, 2)])
    assert warnings(capfd, tmp_path) == []


def test_what_is_flattened_to_a_plane_is_seen(tmp_path):
    """A cube of scale 0 along z is a square."""
    stage.add_camera((0, 0, 5))
    cube = add_cube(material=stage.emission((0.25, 0.5, 1.0)))
    cube.scale = (3, 3, 0)
    cube.location.z = 1
    bpy.context.view_layer.use_pass_z = True
    passes = stage.render(tmp_path)
    np.testing.assert_allclose(passes["Combined"][20:28, 28:36, :3], np.broadcast_to((0.25, 0.5, 1), (8, 8, 3)))
    np.testing.assert_allclose(passes["Depth"][20:28, 28:36], 4, atol=1e-5)


def test_instances_scaled_to_zero_are_left_out(capfd, tmp_path):
    stage.add_camera((0, 0, 5))
    square = stage.add_square(1.0)
    group = bpy.data.collections.new("group")
    group.objects.link(square)
    bpy.context.scene.collection.objects.unlink(square)
    for scale in (0, 1):
        bpy.ops.object.collection_instance_add(collection="group")
        bpy.context.object.scale = (scale,) * 3
    said = warnings(capfd, tmp_path)
    assert len(said) == 1 and "Object 'Square': instances of zero size are left out" in said[0]


def test_meshes_without_faces_get_a_warning(capfd, tmp_path):
    """Unless they are there to carry something else: instances, a black hole."""
    stage.add_camera((0, 0, 5))
    stage.add_mesh("nothing", [], [])
    stage.add_mesh("edge", [], []).data.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    carrier = stage.add_mesh("carrier", [(0, 0, 0), (1, 0, 0)], [])
    carrier.instance_type = "VERTS"
    stage.add_square(1.0).parent = carrier
    stage.add_mesh("handle", [(9, 9, 9)], []).bentlight.kind = "BLACK_HOLE"
    bpy.ops.curve.primitive_bezier_curve_add()
    said = warnings(capfd, tmp_path)
    assert [line.split("'")[1] for line in said if "has no faces" in line] == ["edge", "nothing"]
    assert len(said) == 2


def assert_a_missing_image_is_named(tree: bpy.types.NodeTree, texture: str, shader: str, tmp_path) -> None:
    """Of an image texture, put on the color of the tree's shader."""
    node = tree.nodes.new(texture)
    node.image = bpy.data.images.new("nowhere", 4, 4)
    node.image.source = "FILE"
    node.image.filepath = str(tmp_path / "lost.hdr")
    shader_node = next(item for item in tree.nodes if item.type == shader)
    tree.links.new(node.outputs["Color"], shader_node.inputs["Color"])
    message = failure(tmp_path)
    assert "'nowhere'" in message and "lost.hdr" in message


def test_a_missing_image_file(tmp_path):
    stage.add_camera((0, 0, 5))
    material = stage.emission((1, 1, 1))
    stage.add_square(1.0, material=material)
    assert_a_missing_image_is_named(material.node_tree, "ShaderNodeTexImage", "EMISSION", tmp_path)


def test_a_missing_environment_image(tmp_path):
    stage.add_camera((0, 0, 5))
    tree = stage.set_world((1, 1, 1)).node_tree
    assert_a_missing_image_is_named(tree, "ShaderNodeTexEnvironment", "BACKGROUND", tmp_path)


def test_a_bug_is_reported_not_swallowed(tmp_path, monkeypatch):
    stage.add_camera()

    def broken(*_arguments, **_settings):
        raise KeyError("a slip of the pen")

    monkeypatch.setattr(final, "read_scene", broken)
    assert "KeyError: 'a slip of the pen'" in failure(tmp_path)


def warnings(capfd, tmp_path) -> list[str]:
    capfd.readouterr()
    stage.render(tmp_path)
    return [line for line in capfd.readouterr().out.splitlines() if line.startswith("Warning:")]


def test_broken_triangles_and_lamps_without_size_are_left_out(capfd, tmp_path):
    stage.add_camera((0, 0, 5))
    broken = stage.add_square(1.0, (0, 0, 1), name="broken")
    broken.data.vertices[0].co = (np.nan, 0, 0)
    stage.add_mesh("endless", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 1e30, 0)], [(0, 1, 2), (0, 1, 3)])
    stage.add_light("AREA", size=1.0).scale = (0, 0, 0)
    said = warnings(capfd, tmp_path)
    for text in ("'broken': 2 triangles have vertices", "'endless': 1 triangles have vertices"):
        assert len([line for line in said if f"{text} that are not finite or beyond 1e18" in line]) == 1
    assert len([line for line in said if "'Area' has zero size" in line]) == 1
    assert len(said) == 3


def test_lamps_of_all_sizes_need_no_warning(capfd, tmp_path):
    stage.add_camera((0, 0, 5))
    stage.add_light("POINT", shadow_soft_size=0.0)
    stage.add_light("SPOT", shadow_soft_size=0.0)
    stage.add_light("SUN", angle=0.0)
    stage.add_light("AREA", size=1.0, spread=1.0)
    assert warnings(capfd, tmp_path) == []


def test_what_is_not_supported_is_said(capfd, tmp_path):
    stage.add_camera((0, 0, 5))
    light = stage.add_light("AREA", size=1.0)
    light.data.spread = 0.0
    said = " ".join(warnings(capfd, tmp_path))
    assert "spread" in said


@pytest.mark.parametrize(
    ("spin", "size", "sampling", "said"),
    [
        (0.999, 0.0, "BOTH", "of lamps without size that light is missing"),
        (0.999, 0.1, "CONNECTIONS", "their light is missing. Set Light Sampling to Both"),
        (0.999, 0.1, "BOTH", ""),  # scattering brings it
        (0.3, 0.0, "BOTH", ""),  # all rays are found
    ],
)
def test_light_that_is_lost_is_told(capfd, tmp_path, spin, size, sampling, said):
    """Of a lamp just above the horizon of a hole that spins fast, on a square below."""
    stage.add_camera((3, 0, 3))
    stage.add_square(4.0, (3, 0, -2))
    stage.add_light("POINT", (1.6 if spin > 0.5 else 3, 0, 0), shadow_soft_size=size)
    add_hole(mass=1.0, spin=spin)
    scene = bpy.context.scene
    scene.bentlight.light_sampling, scene.bentlight.samples, scene.bentlight.max_bounces = sampling, 1, 0
    scene.render.resolution_x = scene.render.resolution_y = 24
    found = warnings(capfd, tmp_path)
    told = [line for line in found if "of the bent rays to lights were not found" in line]
    assert len(told) == bool(said) and all(said in line for line in told), found
    assert all(0.1 < float(line.split()[1]) < 60 for line in told)
