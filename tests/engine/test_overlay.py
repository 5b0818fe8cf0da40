"""Circles, outlines and rays that viewports draw, against closed forms, golden data and the core's own way of meeting
meshes. Drawing itself is tested in the true window."""

import csv
import math
from pathlib import Path

import bentlight_native
import bpy
import numpy as np
import pytest

from blender_addon.overlay import circles, contents, fans, rays
from blender_addon.report import RenderError
from blender_addon.sync import native
from blender_addon.sync.scene_data import CameraData, SpacetimeData
from tests.engine import stage

GOLDEN = Path(__file__).parents[1] / "data" / "golden" / "kerr_radii.csv"


def golden_rows() -> list[dict[str, str]]:
    with GOLDEN.open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def rotation(seed: int = 5) -> np.ndarray:
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return matrix * np.sign(np.linalg.det(matrix))


def placed(scale: float = 2.0, place=(1.0, -2.0, 3.0), turn: np.ndarray | None = None, **settings) -> SpacetimeData:
    matrix = np.eye(4)
    matrix[:3, :3] = scale * (rotation() if turn is None else turn)
    matrix[:3, 3] = place
    return SpacetimeData(settings.pop("name", "any"), world_from_spacetime=matrix, **settings)


def own(item: SpacetimeData, points: np.ndarray) -> np.ndarray:
    matrix = np.linalg.inv(item.world_from_spacetime)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


FAR = np.array([0.3, -0.5, 0.8, 0.0])


@pytest.mark.parametrize("row", golden_rows(), ids=lambda row: row["id"])
def test_kerr_radii_in_the_oblate_chart(row):
    a, mass = float(row["a"]), 0.7
    item = placed(kind="BLACK_HOLE", mass=mass, spin=-a, chart="OBLATE")
    expected = {
        "Horizon": row["r_plus"],
        "Photon Orbit, Prograde": row["r_photon_prograde"],
        "Photon Orbit, Retrograde": row["r_photon_retrograde"],
        "Last Stable Orbit": row["r_isco_prograde"],
        "Disk, Inner Edge": "8",
        "Disk, Outer Edge": "20",
    }
    found = {mark.name: mark for mark in circles.marks(item, (8.0, 20.0))}
    assert set(found) == set(expected)
    for name, radius in expected.items():
        r = float(radius)
        assert found[name].equator == pytest.approx(mass * math.hypot(r, a), rel=1e-10), name
        if name == "Horizon":
            assert found[name].pole == pytest.approx(mass * r, rel=1e-12)
            continue
        points = own(item, circles.line(item, found[name], FAR))
        assert np.abs(points[:, 2]).max() < 1e-12  # in the plane of the equator
        np.testing.assert_allclose(np.hypot(*points[:, :2].T), found[name].equator, rtol=1e-12)


@pytest.mark.parametrize(
    ("chart", "drawn"), [("OBLATE", lambda r: r), ("ISOTROPIC", lambda r: (r - 1 + math.sqrt(r * r - 2 * r)) / 2)]
)
def test_without_spin(chart, drawn):
    found = circles.marks(placed(kind="BLACK_HOLE", mass=3.0, chart=chart))
    expected = {"Horizon": drawn(2.0), "Photon Sphere": drawn(3.0), "Last Stable Orbit": drawn(6.0)}
    assert {mark.name: mark.equator / 3.0 for mark in found} == pytest.approx(expected, rel=1e-12)
    assert found[1].pole == found[1].equator and found[2].pole == 0


def test_a_throat_and_a_hole_of_no_mass():
    (throat,) = circles.marks(placed(kind="WORMHOLE", throat_radius=0.8))
    assert (throat.name, throat.equator, throat.pole) == ("Throat", 0.4, 0.4)
    assert circles.marks(placed(kind="BLACK_HOLE", mass=0.0)) == []


@pytest.mark.parametrize("eye", [(4.0, 9.0, -5.0, 1.0), (1.0, -2.0, 9.0, 1.0), (0.1, 0.7, -0.4, 0.0)])
def test_an_outline_is_where_lines_of_sight_touch(eye):
    """The spheroid's normal at a point p is p / axes^2, and the line of sight there is at right angles to it."""
    item = placed(kind="BLACK_HOLE", mass=1.0, spin=0.95, chart="OBLATE")
    horizon = circles.marks(item)[0]
    axes = np.array([horizon.equator, horizon.equator, horizon.pole])
    line = circles.line(item, horizon, np.array(eye))
    points = own(item, line)
    np.testing.assert_allclose(((points / axes) ** 2).sum(axis=1), 1, rtol=1e-12)
    seen = np.linalg.solve(item.world_from_spacetime, eye)
    sight = seen[:3] - points * seen[3]
    normals = points / axes**2
    cosines = (sight * normals).sum(axis=1) / np.linalg.norm(sight, axis=1) / np.linalg.norm(normals, axis=1)
    assert np.abs(cosines).max() < 1e-12
    np.testing.assert_allclose(line[0], line[-1], atol=1e-12)


def test_there_is_no_outline_from_within():
    item = placed(kind="BLACK_HOLE", mass=1.0)
    assert circles.line(item, circles.marks(item)[0], np.array([1.0, -2.0, 3.1, 1.0])) is None


def crowd() -> list[SpacetimeData]:
    """A spinning hole, one without spin, and a wormhole between mouths of different scale and orientation."""
    return [
        placed(1.0, (0, 0, 0), name="kerr", kind="BLACK_HOLE", mass=0.3, spin=0.8, chart="OBLATE"),
        placed(0.5, (10, 0, 0), name="still", kind="BLACK_HOLE", mass=0.5),
        placed(1.0, (0, 12, 0), rotation(1), name="here", kind="WORMHOLE", throat_radius=1.0, exit="there"),
        placed(0.5, (0, -15, 3), rotation(2), name="there", kind="WORMHOLE", throat_radius=2.0, exit="here"),
    ]


def box(size: float) -> bentlight_native.Scene:
    scene = bentlight_native.Scene()
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32) * size
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], np.uint32)
    scene.add_instance(scene.add_mesh(corners, triangles), np.eye(4))
    return scene


@pytest.mark.parametrize(
    "items", [crowd(), crowd()[:1], crowd()[1:2], crowd()[2:]], ids=["all", "kerr", "still", "wormhole"]
)
def test_drawn_rays_are_those_of_a_render(items):
    """They fall in where the core's do, and else leave along the line on which the core's meet the walls far away."""
    scene = box(60.0)
    native.set_spacetimes(scene, items)
    scene.commit()
    rng = np.random.default_rng(1)
    starts = rng.uniform(-8, 8, (80, 3))
    targets = np.array([items[i % len(items)].origin for i in range(80)]) + rng.normal(0, 1.2, (80, 3))
    directions = targets - starts
    hits = scene.intersect(starts, directions, 1e-7, angular_tolerance=1e-9)
    lenses = rays.lenses(items, 120.0)  # beyond all walls
    fates = []
    for i in range(80):
        lines, fate = rays.trace(lenses, starts[i], directions[i], 200.0)
        fates.append(fate)
        assert all(np.isfinite(line).all() for line in lines)
        assert (fate == rays.ESCAPED) == (hits["fate"][i] == bentlight_native.FATES.index("hit"))
        if fate == rays.ESCAPED:
            assert distance_to_line(hits["position"][i], np.concatenate(lines)) < 2e-5 * 120 + 20 * hits["error"][i]
    assert "ESCAPED" in fates and ("CAPTURED" in fates or all(item.kind == "WORMHOLE" for item in items))


def distance_to_line(place: np.ndarray, points: np.ndarray) -> float:
    """From a point to the nearest piece of a line."""
    start, way = points[:-1], np.diff(points, axis=0)
    along = np.clip(np.einsum("ij,ij->i", place - start, way) / np.maximum((way**2).sum(axis=1), 1e-300), 0, 1)
    return float(np.linalg.norm(start + along[:, None] * way - place, axis=1).min())


def test_a_line_through_mouths_is_in_pieces_that_begin_and_end_at_throats():
    items = crowd()[2:]
    axis = items[0].world_from_spacetime[:3, 1]
    lines, fate = rays.trace(rays.lenses(items, 100.0), items[0].origin - 8 * axis + 0.05, axis, 20.0)
    assert fate == rays.ESCAPED and len(lines) == 2
    for end, item in ((lines[0][-1], items[0]), (lines[1][0], items[1])):
        assert np.linalg.norm(end - item.origin) == pytest.approx(0.5, rel=0.1)


def test_lines_look_smooth_and_have_no_jumps():
    item = placed(1.0, (0, 0, 0), name="still", kind="BLACK_HOLE", mass=1.0)
    b = 5.2  # a little more than 3 sqrt 3: once around
    (line,), fate = rays.trace(rays.lenses([item], 1000.0), np.array([-900.0, b, 0]), np.array([1.0, 0, 0]), 1.0)
    assert fate == rays.ESCAPED
    ways = np.diff(line, axis=0)
    ways = ways[np.linalg.norm(ways, axis=1) > 1e-6]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    assert np.arccos(np.clip((ways[1:] * ways[:-1]).sum(axis=1), -1, 1)).max() < 0.09
    turned = np.unwrap(np.arctan2(line[:, 1], line[:, 0]))
    assert abs(turned[-1] - turned[0]) > 1.5 * math.pi


def test_a_start_within_the_horizon_gives_no_line_that_is_not_finite():
    item = placed(1.0, (0, 0, 0), kind="BLACK_HOLE", mass=1.0)
    lines, fate = rays.trace(rays.lenses([item], 100.0), np.array([0.1, 0, 0]), np.array([1.0, 0, 0]), 1.0)
    assert fate == rays.CAPTURED and all(np.isfinite(line).all() for line in lines)


def test_the_camera_s_rays_lie_side_by_side_at_the_target_s_height():
    camera = CameraData("PERSPECTIVE", np.eye(4), 200, 100, (-0.5, 0.5, -0.25, 0.25), 0.1, 100.0)
    starts, directions = fans.camera_fan(camera, 5, np.array([1.0, 1.0, -10.0]))
    assert not starts.any()
    slopes = directions[:, :2] / -directions[:, 2:]
    np.testing.assert_allclose(slopes[:, 0], [-0.4, -0.2, 0, 0.2, 0.4], atol=1e-12)
    np.testing.assert_allclose(slopes[:, 1], 0.1, rtol=1e-12)
    for target, height in ((None, 0.0), (np.array([0, 0, 5.0]), 0.0), (np.array([0, 90.0, -10]), 0.25)):
        _, directions = fans.camera_fan(camera, 3, target)
        np.testing.assert_allclose(directions[:, 1] / -directions[:, 2], height, atol=1e-12)


@pytest.mark.parametrize("target", [None, np.array([3.0, 0, 1]), np.array([1.0, 2, 9]), np.array([1.0, 2, 3])])
def test_the_cursor_s_rays_go_all_around(target):
    place = np.array([1.0, 2.0, 3.0])
    starts, directions = fans.star(place, 8, target, np.array([0, 0, 1.0]))
    np.testing.assert_array_equal(starts, np.tile(place, (8, 1)))
    np.testing.assert_allclose(directions.sum(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(directions @ directions[0], np.cos(np.arange(8) * math.pi / 4), atol=1e-12)
    if target is not None and np.linalg.norm(target - place) > 0:
        np.testing.assert_allclose(directions[0], (target - place) / np.linalg.norm(target - place))


def subjects() -> list[contents.Subject]:
    bpy.context.view_layer.update()
    holes = [obj for obj in bpy.context.view_layer.objects if obj.bentlight.kind != "NONE"]
    return contents.read_subjects(holes, lambda obj: not obj.hide_get(), bpy.context.evaluated_depsgraph_get())


def drawn_rays() -> list[contents.Line]:
    found = subjects()
    return contents.ray_lines(bpy.context.scene, bpy.context.evaluated_depsgraph_get(), found)


def test_rays_end_at_surfaces_but_not_at_lenses():
    settings = bpy.context.scene.bentlight.overlay
    settings.rays, settings.ray_count = "CAMERA", 9
    stage.add_camera(location=(0, 0, 20))
    assert {line.kind for line in drawn_rays()} == {"ESCAPED"}  # straight: there is no hole
    bpy.ops.bentlight.black_hole_add(mass=0.2, location=(0, 0, 5))
    wall = stage.add_square(100.0)
    lines = drawn_rays()
    assert {line.kind for line in lines} >= {"HIT", "CAPTURED"} and len(lines) == 9
    ends = [line.points[-1] for line in lines if line.kind == "HIT"]
    assert np.abs(np.array(ends)[:, 2]).max() < 1e-4
    wall.bentlight.made_for_cycles = "LENS"
    assert "HIT" not in {line.kind for line in drawn_rays()}


def test_why_there_are_no_rays():
    settings = bpy.context.scene.bentlight.overlay
    settings.rays = "CAMERA"
    with pytest.raises(RenderError, match="camera"):
        drawn_rays()
    stage.add_camera()
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    with pytest.raises(RenderError, match="horizon"):
        drawn_rays()
    settings.rays = "CURSOR"
    with pytest.raises(RenderError, match="cursor"):
        drawn_rays()
    bpy.context.scene.cursor.location = (0, 0, 4)
    assert drawn_rays()
    bpy.ops.bentlight.wormhole_add(location=(20, 0, 0))
    bpy.context.object.bentlight.exit.hide_set(True)
    with pytest.raises(RenderError, match="exit"):
        drawn_rays()


def test_lines_are_of_what_is_shown_as_it_is_in_this_frame():
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    hole = bpy.context.object
    hole.bentlight.disk.enable = True
    hole.bentlight.disk.keyframe_insert("outer_radius", frame=1)
    hole.bentlight.disk.outer_radius = 50.0
    hole.bentlight.disk.keyframe_insert("outer_radius", frame=10)
    bpy.context.scene.frame_set(10)
    (subject,) = subjects()
    assert subject.disk == pytest.approx((6.0, 50.0))
    lines = contents.mark_lines([subject], FAR)
    assert [line.kind for line in lines] == ["HORIZON", "PHOTON", "ISCO", "DISK", "DISK"]
    hole.hide_set(True)
    assert subjects() == []
    hole.hide_set(False)
    hole.scale = (0, 0, 0)
    assert subjects() == []
