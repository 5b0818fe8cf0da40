"""The lens shader's arithmetic, one pixel a ray, against the core's rays through the same finite spheres.

What float32 can reach depends on the ray: those that wind around a hole, or graze the throat, multiply rounding errors.
So errors are counted in units of what a rounding of the start does to the core's own answer.
"""

import re

import numpy as np
import pytest
import shader_values
from bentlight_native import FATES, DeflectionTable, SampledTable, Scene, Spacetime, _core
from bentlight_native.exr import read_exr

ROUNDING = 2.0**-24
COUNT = 1024
ISOTROPIC, OBLATE, WORMHOLE = range(3)
FAR_RADIUS = 8.0

SPACES = {
    "schwarzschild": (ISOTROPIC, 0.0, Spacetime.schwarzschild(1.0), 10.0),
    "wide": (ISOTROPIC, 0.0, Spacetime.schwarzschild(1.0), 150.0),
    "areal": (OBLATE, 0.0, Spacetime.schwarzschild(1.0, "areal"), 12.0),
    "ellis": (WORMHOLE, 0.0, Spacetime.ellis(1.0), 5.0),
    "kerr 0.6": (OBLATE, 0.6, Spacetime.kerr(1.0, 0.6), 10.0),
    "kerr 0.9": (OBLATE, 0.9, Spacetime.kerr(1.0, 0.9), 40.0),
    "kerr 0.998": (OBLATE, 0.998, Spacetime.kerr(1.0, 0.998), 10.0),
    "kerr -0.9": (OBLATE, -0.9, Spacetime.kerr(1.0, -0.9), 8.0),
}
FOLLOW = "follow(space, start, ray, p, d)"
CODE = """
Space space;
space.chart = {chart}, space.a = {a!r}, space.radius = {radius!r}, space.far_radius = {far!r};
point start = point(in[0], in[1], in[2]), p;
vector ray = normalize(vector(in[3], in[4], in[5])), d;
int fate = {call};
out = fate == FATE_LOST ? vector(0) : {result};
"""


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def rays(radius: float, inside: bool, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Starts and directions as float32 has them: inward from the sphere, most of them near the hole, or from inside."""
    random = np.random.default_rng(seed)
    outward = unit(random.normal(size=(COUNT, 3)))
    across = unit(np.cross(outward, random.normal(size=(COUNT, 3))))
    if inside:
        points = outward * radius * random.uniform(0.35, 0.99, (COUNT, 1))
        directions = random.normal(size=(COUNT, 3))
    else:
        reach = np.where(np.arange(COUNT) % 4 == 0, 1, min(12 / radius, 1))
        sine = np.sqrt(random.uniform(0, reach**2))[:, None]
        points, directions = outward * radius, sine * across - np.sqrt(1 - sine**2) * outward
    return points.astype(np.float32).astype(float), unit(directions).astype(np.float32).astype(float)


def core_rays(name: str, points: np.ndarray, directions: np.ndarray, walls: bool = False) -> dict[str, np.ndarray]:
    """By the core: through the sphere of `name`, a wormhole's exit far up; with walls, to a box around the sphere."""
    chart, _, spacetime, radius = SPACES[name]
    away = np.eye(4)
    away[2, 3] = 1e4
    objects = [(spacetime, np.eye(4), radius, -1)]
    if chart == WORMHOLE:
        objects = [(spacetime, np.eye(4), radius, 1), (spacetime, away, FAR_RADIUS, 0)]
    scene = Scene()
    scene.set_spacetime_objects(objects)
    if walls:
        half = 3 * radius
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32) * half
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.uint32)
        scene.add_instance(scene.add_mesh(corners, faces), np.eye(4))
    scene.commit()
    return scene.intersect(points, unit(directions), 1e-5 if walls else 1e-9, angular_tolerance=1e-11)


def shader_rays(folder, name, points, directions, call, result="d"):
    chart, a, _, radius = SPACES[name]
    code = CODE.format(chart=chart, a=a, radius=radius, far=FAR_RADIUS, call=call, result=result)
    numbers = np.concatenate([points, directions], axis=1)
    return shader_values.evaluate(folder, ["lens_table.h"], code, numbers).astype(float)


def table_call(folder, name: str) -> str:
    chart = SPACES[name][0]
    spacetime = Spacetime.ellis(1.0) if chart == WORMHOLE else Spacetime.schwarzschild(1.0)
    paths = folder / "total.exr", folder / "outward.exr"
    SampledTable.from_table(DeflectionTable(spacetime)).write(*paths)
    return f'cross_by_table(space, "{paths[0]}", "{paths[1]}", start, ray, p, d)'


def amplification(name, points, directions) -> np.ndarray:
    """How much farther off a ray ends than it starts: by shifts of its direction and of its start, in the core."""
    random = np.random.default_rng(99)
    size, points = 1e-7, points * (1 - 1e-6)  # shifted starts stay inside the sphere
    base = core_rays(name, points, directions)["direction"]
    worst = np.ones(len(points))
    for _ in range(2):
        shift = size * unit(random.normal(size=points.shape))
        moved = core_rays(name, points + shift * np.linalg.norm(points, axis=1, keepdims=True), directions)["direction"]
        turned = core_rays(name, points, unit(directions) + shift)["direction"]
        for shifted in (moved, turned):
            worst = np.fmax(worst, np.linalg.norm(shifted - base, axis=1) / size)
    return worst


def check(name, points, directions, found, allowed):
    """Fates agree, and errors in units of a rounding, amplified, are at most `allowed` in the mean square."""
    core = core_rays(name, points, directions)
    escaped, lost = core["fate"] == FATES.index("escaped"), np.linalg.norm(found, axis=1) < 0.5
    factor = amplification(name, points, directions)
    clear = factor < 1e4
    assert clear.mean() > 0.98
    assert not (lost == escaped)[clear].any()
    both = escaped & ~lost & clear
    error = np.linalg.norm(found - core["direction"], axis=1)[both] / (ROUNDING * factor[both])
    assert both.sum() > COUNT / 3
    assert np.sqrt(np.mean(error**2)) < allowed, f"{np.sqrt(np.mean(error**2))} roundings"
    assert error.max() < 10 * allowed, f"{error.max()} roundings"


def test_the_header_knows_the_images(tmp_path):
    header = (shader_values.OSL / "lens_table.h").read_text()
    constants = {name: float(value) for name, value in re.findall(r"#define ([A-Z_]+) ([\d.]+)\n", header)}
    _, schwarzschild_max, ellis_min = _core.table_constants()
    assert constants["SCHWARZSCHILD_MAX"] == schwarzschild_max
    assert constants["ELLIS_MIN"] == ellis_min
    paths = tmp_path / "total.exr", tmp_path / "outward.exr"
    SampledTable.from_table(DeflectionTable(Spacetime.ellis(1.0))).write(*paths)
    assert read_exr(paths[0])[0]["inside"].shape == (1, constants["TOTAL_WIDTH"])
    assert read_exr(paths[1])[0]["outward"].shape == (constants["OUTWARD_SIZE"],) * 2


@pytest.mark.parametrize("name", [name for name, space in SPACES.items() if space[1] == 0])
def test_crossing_by_table(name, tmp_path):
    points, directions = rays(SPACES[name][3], False, 1)
    found = shader_rays(tmp_path, name, points, directions, table_call(tmp_path, name))
    check(name, points, directions, found, 10)


@pytest.mark.parametrize("name", SPACES)
@pytest.mark.parametrize("inside", [False, True], ids=["across", "from inside"])
def test_integration(name, inside, tmp_path):
    points, directions = rays(SPACES[name][3], inside, 2)
    found = shader_rays(tmp_path, name, points, directions, FOLLOW)
    check(name, points, directions, found, 5)


@pytest.mark.parametrize("name", ["schwarzschild", "kerr 0.9"])
def test_rays_leave_from_the_right_point(name, tmp_path):
    """On along the shader's line, a ray meets walls around the sphere where the core's does."""
    points, directions = rays(SPACES[name][3], False, 3)
    ahead = shader_rays(tmp_path, name, points, directions, FOLLOW)
    exits = shader_rays(tmp_path, name, points, directions, FOLLOW, "vector(p)")
    core = core_rays(name, points, directions, walls=True)
    hit = (core["fate"] == FATES.index("hit")) & (np.linalg.norm(ahead, axis=1) > 0.5)
    clear = hit & (amplification(name, points, directions) < 100)
    assert clear.sum() > COUNT / 2
    beside = np.linalg.norm(np.cross(core["position"] - exits, ahead), axis=1)[clear]
    radius = SPACES[name][3]
    assert np.abs(np.linalg.norm(exits[clear], axis=1) / radius - 1).max() < 1e-6
    assert beside.max() < 1e-4 * radius


CHANGES = """
Lens lens;
lens.space.chart = {chart}, lens.space.a = 0, lens.space.radius = {radius!r}, lens.space.far_radius = {far!r};
lens.total = "{total}", lens.outward = "{outward}", lens.soft_edge = 0.2;
lens.far_x = vector(0, 2, 0), lens.far_y = vector(0, 0, 2), lens.far_z = vector(2, 0, 0);
point q = point(in[0], in[1], in[2]) / {radius!r}, p;
vector d = normalize(vector(in[3], in[4], in[5])), leaves;
Chord chord = chord_of(q, d, 1e9);
int fate = misses(chord) ? FATE_LOST : cross_lens(lens, chord, q, d, p, leaves);
if (fate != FATE_LOST) {{
  vector square = normalize(cross(d, chord.aside));
  vector known = change_of_plane(lens, chord, d, square, 2e-3, -3e-3, fate, leaves);
  vector found = change_beside(lens, q, d, 1e9, 2e-3 * square, -3e-3 * square, fate, leaving(lens, fate, leaves));
  out = vector(length(known - found), length(found), length(chord.aside));
}}
"""


@pytest.mark.parametrize("name", ["schwarzschild", "areal", "ellis"])
def test_rays_beside_the_plane_of_a_ray(name, tmp_path):
    """In closed form and by a ray of their own, which half a difference in its place is off by its own square."""
    chart, _, _, radius = SPACES[name]
    points, directions = rays(radius, False, 4)
    table_call(tmp_path, name)
    total, outward = tmp_path / "total.exr", tmp_path / "outward.exr"
    code = CHANGES.format(chart=chart, radius=radius, far=FAR_RADIUS, total=total, outward=outward)
    numbers = np.concatenate([points, directions], axis=1)
    off, size, aside = shader_values.evaluate(tmp_path, ["lens_ray.h"], code, numbers).astype(float).T
    seen = (size > 0) & (aside > 0.05)
    assert seen.sum() > COUNT / 2
    assert np.median(off[seen] / size[seen]) < 5e-3 and np.quantile(off[seen] / size[seen], 0.95) < 0.05
