"""Motion vectors against brute force: the ray through the place that a vector leads to, traced in the scene of the
other moment, meets what was seen."""

import numpy as np
import pytest
from bentlight_native import Aperture, Moment, RenderSettings, Scene, Spacetime
from scenes import IDENTITY, add, diffuse, emission, look_at, new_scene, perspective, quad, render

SIZE, FILTER = 20, 0.01  # pixels
NAMES = ("vector", "vector_weight")
MOVED = {-1: (-0.3, -0.2, -0.1), 0: (0, 0, 0), 1: (0.4, 0.1, 0.2)}
"""The camera, the hole and the wall of each moment are moved by multiples of these."""


def placed(*place):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


def wall_at(moment):
    """A large wall behind the hole, which slides and turns."""
    turned = look_at((0, 0, 0), (0.1 * moment, -1, 0.05 * moment))
    return placed(*np.array([0.5, 7, 0.2]) + MOVED[moment]) @ turned


def view(scene, moment, spacetimes, camera="PERSPECTIVE"):
    """Gives a scene a moment's camera and spacetime objects."""
    scene.set_spacetime_objects(
        [(s, placed(*np.array(at) - 0.5 * np.array(MOVED[moment])), r, e) for s, at, r, e in spacetimes]
    )
    eye = np.array([0.3, -9, 0.4]) + 0.3 * np.array(MOVED[moment])
    matrix = look_at(eye, (0.05 * moment, 0, 0.1))
    if camera == "PERSPECTIVE":
        perspective(scene, matrix, half=0.45)
    else:
        scene.set_camera(camera, matrix, (0.2, 0.8, 0.2, 0.8))


def scene_of(moment, spacetimes, camera, has_wall=True):
    scene = new_scene((1, 1, 1))
    if has_wall:
        add(scene, quad(3.5, 3.5), diffuse((0.5, 0.5, 0.5)), at=wall_at(moment))
    view(scene, moment, spacetimes, camera)
    scene.commit()
    return scene


def vectors_of(scene, spacetimes, camera):
    """(SIZE, SIZE, 4), rows upwards, as passes have them."""
    moments = []
    for moment in (-1, 1):
        other = Scene()
        view(other, moment, spacetimes, camera)
        other.commit()
        moments.append(Moment(other, [wall_at(moment)]))
    scene.set_motion(*moments)
    channels, _ = render(scene, SIZE, SIZE, 1, names=NAMES, filter_width=FILTER, tolerance=1e-7)
    weight = channels["vector_weight"]
    return np.where(weight > 0, channels["vector"] / np.where(weight > 0, weight, 1), 0)


def trace(scene, places):
    """What rays through places of the picture, in pixels, meet: position or direction, and whether it is a wall."""
    rays = scene.camera_rays(np.asarray(places) / SIZE)
    hits = scene.intersect(rays.origins, rays.directions, tolerance=1e-9, angular_tolerance=1e-10)
    is_wall, is_sky = (np.isin(hits["fate"], kinds) for kinds in ((4,), (1, 3)))
    return np.where(is_wall[:, None], hits["position"], hits["direction"]), is_wall, is_sky


def slopes(scene, places, kind):
    """What rays through the places meet, how that changes by pixel (n, 3, 2), and where all of it is of that kind."""
    met, *kinds = trace(scene, places)
    usable, step, columns = kinds[kind].copy(), 1e-3, []
    for axis in np.eye(2):
        beside, *kinds = trace(scene, places + step * axis)
        usable &= kinds[kind]
        columns.append((beside - met) / step)
    return met, np.stack(columns, axis=-1), usable


def misses(scene, other, moment, places, shift, kind):
    """By how many pixels rays through the shifted places miss, in the other moment's scene, what is seen now: wall
    (kind 0) or sky (1); and how much of that the sample's own distance from the middle of its pixel may explain."""
    seen, now, usable = slopes(scene, places, kind)
    met, then, usable_then = slopes(other, places + shift, kind)
    if kind == 0:
        to_there = wall_at(moment) @ np.linalg.inv(wall_at(0))
        seen, now = seen @ to_there[:3, :3].T + to_there[:3, 3], to_there[:3, :3] @ now
    usable &= usable_then
    back = np.linalg.pinv(then[usable])
    off = np.linalg.norm(back @ (seen - met)[usable, :, None], axis=(1, 2))
    explained = np.linalg.norm(back @ now[usable] - np.eye(2), axis=(1, 2)) * FILTER / 2 * np.sqrt(2)
    return off, explained


SPACES = {
    "flat": [],
    "schwarzschild": [(Spacetime.schwarzschild(0.4), (0, 0, 0), np.inf, -1)],
    "kerr": [(Spacetime.kerr(0.4, 0.36), (0, 0, 0), np.inf, -1)],
    "ellis": [(Spacetime.ellis(0.8), (0, 0, 0), np.inf, -1)],
    "spheres": [
        (Spacetime.schwarzschild(0.15), (-1, 0, 0), 1.2, -1),
        (Spacetime.schwarzschild(0.1, "areal"), (1.6, 1, 0), 1.2, -1),
    ],
    "mouths": [(Spacetime.ellis(0.5), (-0.5, -1, 0), 1.5, 1), (Spacetime.ellis(0.5), (0, -2, 4), 1.5, 0)],
}


KNOWN = {"kerr": 0.85, "spheres": 0.95}  # part of what is seen whose image is found in all moments
BORDERS = {
    "spheres": 0.01,
    "mouths": 0.01,
}  # part that is seen beside the border of a sphere of influence, where space is torn


@pytest.mark.parametrize(
    ("space", "camera"), [*((space, "PERSPECTIVE") for space in SPACES), ("schwarzschild", "EQUIRECTANGULAR")]
)
def test_vectors_lead_to_what_was_seen(space, camera):
    """In pixels, to what the sample's own place within its pixel leaves open, and that a lens may magnify."""
    scene = scene_of(0, SPACES[space], camera)
    vectors = vectors_of(scene, SPACES[space], camera)
    y, x = np.indices((SIZE, SIZE)).reshape(2, -1) + 0.5
    places = np.stack([x, y], axis=1)
    seen = np.any(trace(scene, places)[1:], axis=0)
    for moment, shift in ((-1, vectors[..., :2]), (1, -vectors[..., 2:])):
        shift = shift.reshape(-1, 2)
        known = (shift != 0).any(axis=-1)
        assert known[seen].mean() > KNOWN.get(space, 0.97) and not known[~seen].any()
        other = scene_of(moment, SPACES[space], camera)
        wrong = 0
        for kind in (0, 1):
            off, explained = misses(scene, other, moment, places[known], shift[known], kind)
            assert len(off) > 5 and np.median(explained) < 0.02
            wrong += (off > explained + 1e-4).sum()
        assert wrong <= BORDERS.get(space, 0) * known.sum()


def test_what_stands_still_does_not_move():
    """To the last bit, although rays and connections are known to some digits only; without motion nothing is known."""
    space = SPACES["schwarzschild"]
    scene = scene_of(0, space, "PERSPECTIVE")
    still, moved = Scene(), placed(0, 0, 0.1) @ wall_at(0)
    view(still, 0, space, "PERSPECTIVE")
    still.commit()
    scene.set_motion(Moment(still, [wall_at(0)]), Moment(still, [moved]))
    channels, _ = render(scene, SIZE, SIZE, 1, names=(*NAMES, "fate", "position"))
    vector, weight, fate = channels["vector"], channels["vector_weight"], channels["fate"]
    assert not vector[..., :2].any() and not vector[fate[..., 0] == 1][:, 2:].any()
    assert (weight[(channels["position"] != 0).any(axis=-1)] > 0).all()
    assert vector[fate[..., 0] == 4][:, 2:].any()
    scene.set_motion()
    channels, _ = render(scene, SIZE, SIZE, 1, names=NAMES)
    assert not any(values.any() for values in channels.values())


def test_shapes_change_by_their_vertices():
    """The corner of a triangle moves, and with it, in proportion, all that it holds."""
    scene, other = new_scene((0, 0, 0)), Scene()
    vertices = np.array([(-4, -4, 0), (4, -4, 0), (0, 6, 0)], np.float32)
    add(scene, (vertices, np.array([[0, 1, 2]], np.uint32)), emission((1, 1, 1)))
    for each in (scene, other):
        perspective(each, placed(0, 0, 10), half=0.3)
        each.commit()
    moved = vertices + np.array([(0, 0, 0), (0, 0, 0), (0.5, 0, 0)], np.float32)
    scene.set_motion(Moment(other), Moment(other, [IDENTITY], [moved]))
    channels, _ = render(scene, SIZE, SIZE, 1, names=("vector", "position"))
    height = (channels["position"][..., 1] + 4) / 10
    pixels_per_unit = SIZE / (2 * 0.3 * 10)
    inside = (channels["position"] != 0).any(axis=-1)
    np.testing.assert_allclose(channels["vector"][inside, 2], -0.5 * height[inside] * pixels_per_unit, rtol=1e-4)
    assert not channels["vector"][..., (0, 1, 3)].any()


def test_lenses_of_cameras_do_not_hide_images():
    """With depth of field the rays that see a place do not start in the middle of the lens, where its image is looked
    for: blurred or not, it moves alike."""
    found = []
    for radius in (0.0, 0.05):
        space = SPACES["schwarzschild"]
        scene = scene_of(0, space, "PERSPECTIVE")
        moments = []
        for each in (scene, Scene(), Scene()):
            view(each, 0 if each is scene else 1, space, "PERSPECTIVE")
            matrix = look_at((0.3, -9, 0.4), (0, 0, 0.1))
            each.set_camera("PERSPECTIVE", matrix, (-0.45, 0.45, -0.45, 0.45), aperture=Aperture(radius, 9.0))
            each.commit()
            moments.append(Moment(each, [wall_at(1)]))
        scene.set_motion(*moments[1:])
        channels, _ = render(scene, SIZE, SIZE, 16, names=NAMES, filter="BOX")
        weight = channels["vector_weight"]
        found.append((np.where(weight > 0, channels["vector"] / np.where(weight > 0, weight, 1), 0), weight[..., 0]))
    (sharp, whole), (blurred, _) = found
    wall = (whole == 4 / 16) & (np.abs(sharp).max(axis=-1) < 3)
    assert wall.sum() > SIZE
    assert np.median(np.abs(sharp - blurred)[wall]) < 0.02 * np.median(np.abs(sharp)[wall])


@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_what_is_out_of_focus_moves_too(ratio):
    """Of a wall much nearer than what is sharp every sample tells, and all the same, as the wall faces the camera."""
    lenses = {0.0: None, 0.05: None}
    for radius in lenses:
        scene, other = new_scene(), Scene()
        add(scene, quad(5, 5), diffuse((0.5, 0.5, 0.5)))
        for each in (scene, other):
            aperture = Aperture(radius, 10.0, ratio=ratio)
            each.set_camera("PERSPECTIVE", placed(0, 0, 2), (-0.5, 0.5, -0.5, 0.5), aperture=aperture)
            each.commit()
        scene.set_motion(Moment(other, [placed(-0.1, 0, 0)]), Moment(other, [placed(0.1, 0, 0)]))
        lenses[radius], _ = render(scene, SIZE, SIZE, 4, names=NAMES, tolerance=1e-5)
    for channels in lenses.values():
        assert (channels["vector_weight"] == 1).all()
        np.testing.assert_allclose(channels["vector"], np.broadcast_to((-1, 0, -1, 0), (SIZE, SIZE, 4)), atol=1e-4)


def test_samples_that_know_nothing_do_not_shorten_vectors():
    """Pixels that show both what will be behind the camera, where it has no image, and what will not."""
    scene, other = new_scene(), Scene()
    for side in (-3, 3):
        add(scene, quad(3, 5), diffuse((0.5, 0.5, 0.5)), at=placed(side + 0.03, 0, 0))
    for each in (scene, other):
        each.set_camera("PERSPECTIVE", placed(0, 0, 2), (-0.5, 0.5, -0.5, 0.5))
        each.commit()
    moved = Moment(other, [placed(-2.87, 0, 0), placed(3.03, 0, 5)])
    scene.set_motion(moved, moved)
    channels, _ = render(scene, SIZE, SIZE, 4, names=NAMES, filter="BOX")
    vector, weight = channels["vector"] / channels["vector_weight"], channels["vector_weight"][..., 0]
    partly = (weight > 0.1) & (weight < 0.9)
    assert 5 < partly.sum() < 2 * SIZE and (weight > 0.9).sum() > 100 and (weight < 0.1).sum() > 100
    np.testing.assert_allclose(vector[weight > 0.1], [(1, 0, -1, 0)] * (weight > 0.1).sum(), atol=1e-3)
    assert not vector[weight < 0.1].any()


def test_counts_and_views_are_checked():
    scene, other = scene_of(0, [], "PERSPECTIVE"), Scene()
    with pytest.raises(RuntimeError, match="committed"):
        scene.set_motion(Moment(other), Moment(other))
    view(other, 0, [], "PERSPECTIVE")
    other.commit()
    with pytest.raises(ValueError, match="vertices"):
        scene.set_motion(Moment(other, [], [np.zeros((3, 3), np.float32)]), Moment(other))
    with pytest.raises(ValueError, match="vertices"):
        scene.set_motion(Moment(other, [], [np.full((4, 3), np.nan, np.float32)]), Moment(other))
    scene.set_motion(Moment(other), Moment(other))
    settings = RenderSettings(SIZE, SIZE)
    scene.render_tile(0, 0, SIZE, SIZE, settings, {"vector": np.zeros((SIZE, SIZE, 4), np.float32)})
