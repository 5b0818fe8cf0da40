"""Several spacetime objects and wormholes in one scene, against a tracer of their own in numpy."""

import math

import meshes
import numpy as np
import pytest
from bentlight_native import Scene, Spacetime

WALLS = 6.0  # half width of the box around everything


def placed(center, scale=1.0, turn=0.0):
    """Turned about a skew axis, scaled, moved."""
    axis = np.array([1.0, 2.0, 3.0]) / math.sqrt(14)
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    matrix = np.eye(4)
    matrix[:3, :3] = scale * (np.eye(3) + math.sin(turn) * k + (1 - math.cos(turn)) * k @ k)
    matrix[:3, 3] = center
    return matrix


class Lens:
    """A conformally flat object: a medium of refractive index n(R) inside a sphere (Gordon 1923), by Runge-Kutta."""

    def __init__(self, matrix, radius, *, mass=0.0, throat=0.0, exit_=-1):
        self.matrix, self.radius, self.exit = matrix, radius, exit_
        self.scale = np.linalg.norm(matrix[:3, 0])
        self.mass, self.throat = mass, throat
        self.spacetime = Spacetime.ellis(throat) if throat else Spacetime.schwarzschild(mass)

    def entry(self):
        return self.spacetime, self.matrix, self.radius, self.exit

    def index(self, R):
        """n and dn/dR."""
        if self.throat:
            q = self.throat**2 / (4 * R**2)
            return 1 + q, -2 * q / R
        q = self.mass / (2 * R)
        n = (1 + q) ** 3 / (1 - q)
        return n, -n * q / R * (3 / (1 + q) + 1 / (1 - q))

    def slope(self, y):
        R = np.linalg.norm(y[:, :3], axis=1, keepdims=True)
        n, dn = self.index(R)
        return np.concatenate([y[:, 3:], n * dn * y[:, :3] / R], axis=1)

    def step(self, y, h):
        k1 = self.slope(y)
        k2 = self.slope(y + h / 2 * k1)
        k3 = self.slope(y + h / 2 * k2)
        k4 = self.slope(y + h * k3)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def bend(self, points, directions, far_radius):
        """Own points and directions where rays come out, and whether they fell in or came out far."""
        rotation = self.matrix[:3, :3] / self.scale
        x = (points - self.matrix[:3, 3]) @ rotation / self.scale
        y = np.concatenate([x, directions @ rotation], axis=1)
        n, _ = self.index(np.linalg.norm(x, axis=1, keepdims=True))
        y[:, 3:] *= n
        edge = self.radius / self.scale
        far_edge = self.throat**2 / (4 * far_radius / self.scale)
        state = np.zeros(len(y), int)  # 1: out, 2: fell in, 3: far
        fresh = np.ones(len(y), bool)
        while (going := state == 0).any():
            before = y[going]
            R = np.linalg.norm(before[:, :3], axis=1, keepdims=True)
            h = 0.004 * R / np.linalg.norm(before[:, 3:], axis=1, keepdims=True)
            after = self.step(before, h)
            R = np.linalg.norm(after[:, :3], axis=1)
            inward = np.sum(after[:, :3] * after[:, 3:], axis=1) < 0
            new = np.where((edge < R) & ~(fresh[going] & inward), 1, 0)
            new[(far_edge if self.throat else 0.505 * self.mass) > R] = 3 if self.throat else 2
            for kind, target in ((1, edge), (3, far_edge)):
                low, high = np.zeros((len(h), 1)), h.copy()
                if not (new == kind).any():
                    continue
                for _ in range(50):  # bisection of the last step
                    middle = (low + high) / 2
                    radius = np.linalg.norm(self.step(before, middle)[:, :3], axis=1, keepdims=True)
                    beyond = radius > target if kind == 1 else radius < target
                    low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
                after = np.where((new == kind)[:, None], self.step(before, high), after)
            y[going] = after
            fresh[going] = False
            state[going] = new
        x, d = y[:, :3], y[:, 3:] / np.linalg.norm(y[:, 3:], axis=1, keepdims=True)
        return x, d, state, rotation

    def world(self, x, d, rotation):
        return x @ rotation.T * self.scale + self.matrix[:3, 3], d @ rotation.T


def reference(lenses, origins, directions, turns=12):
    """Where rays end on the walls, or NaN; the lens in which they are lost; how many lenses they passed."""
    points, heading = origins.copy(), directions.copy()
    n = len(points)
    inside, last = np.full(n, -1), np.full(n, -1)
    for i, lens in enumerate(lenses):
        inside[np.linalg.norm(points - lens.matrix[:3, 3], axis=1) < lens.radius] = i
    ends, lost, passed = np.full((n, 3), np.nan), np.full(n, -1), np.zeros(n, int)
    alive = np.ones(n, bool)
    for _ in range(turns):
        for i in np.flatnonzero(alive & (inside < 0)):
            best, hit = np.inf, -1
            for k, lens in enumerate(lenses):
                to = lens.matrix[:3, 3] - points[i]
                along = to @ heading[i]
                half = lens.radius**2 - to @ to + along**2
                if k != last[i] and along > 0 and half > 0 and along - math.sqrt(half) < best:
                    best, hit = along - math.sqrt(half), k
            if hit < 0:
                with np.errstate(divide="ignore"):
                    ends[i] = points[i] + heading[i] * np.min((np.sign(heading[i]) * WALLS - points[i]) / heading[i])
                alive[i] = False
            else:
                points[i] += best * heading[i]
                inside[i] = hit
        for k, lens in enumerate(lenses):
            rows = np.flatnonzero(alive & (inside == k))
            if not len(rows):
                continue
            passed[rows] += 1
            x, d, state, rotation = lens.bend(points[rows], heading[rows], lenses[lens.exit].radius)
            through = (state == 3) & (lens.exit >= 0)
            out, target = lens, k
            if through.any():
                # Inversion in the throat and a mirror carry the far side into the other mouth's axes.
                target = lens.exit
                other = lenses[target]
                assert other.throat * other.scale == pytest.approx(lens.throat * lens.scale)
                R2 = np.sum(x * x, axis=1, keepdims=True)
                far = x * lens.throat**2 / (4 * R2) * (lens.scale / other.scale)
                normal = x / np.sqrt(R2)
                turned = d - 2 * np.sum(d * normal, axis=1, keepdims=True) * normal
                mirror = np.array([1, -1, 1])
                other_rotation = other.matrix[:3, :3] / other.scale
                p, q = other.world(far * mirror, turned * mirror, other_rotation)
                points[rows[through]], heading[rows[through]] = p[through], q[through]
                last[rows[through]], inside[rows[through]] = target, -1
            p, q = out.world(x, d, rotation)
            points[rows[state == 1]], heading[rows[state == 1]] = p[state == 1], q[state == 1]
            last[rows[state == 1]], inside[rows[state == 1]] = k, -1
            gone = (state == 2) | ((state == 3) & ~through)
            alive[rows[gone]] = False
            lost[rows[gone]] = k
    return ends, lost, passed


TWO_HOLES = [
    Lens(placed((-1.5, 0.2, 0), 0.5, 0.7), 1.2, mass=0.2),
    Lens(placed((1.5, -0.2, 0.3), 2.0), 1.5, mass=0.03),
]
WORMHOLE = [
    Lens(placed((-2, 0, 0), 1.0, 0.4), 1.5, throat=0.8, exit_=1),
    Lens(placed((2, 1, -1), 2.0, -1.1), 1.7, throat=0.4, exit_=0),
    Lens(placed((0, -3, 0)), 1.0, mass=0.1),
]
DEAD_END = [
    Lens(placed((0, 0, 0), 1.0, 0.3), 1.5, throat=0.8),
    Lens(placed((3, 0, 0)), 1.0, mass=0.1),
]


@pytest.mark.parametrize("lenses", [TWO_HOLES, WORMHOLE, DEAD_END], ids=["two holes", "wormhole", "dead end"])
def test_rays_through_several_lenses(lenses):
    rng = np.random.default_rng(21)
    n = 600
    origins = rng.uniform(-4, 4, (n, 3))
    for lens in lenses:  # some start inside a lens, none inside a hole or throat
        away = origins - lens.matrix[:3, 3]
        near = np.linalg.norm(away, axis=1) < 0.7 * lens.radius
        origins[near] += (away * (lens.radius / np.linalg.norm(away, axis=1, keepdims=True)))[near]
    origins = np.clip(origins, -5.5, 5.5)
    aims = np.array([lenses[i].matrix[:3, 3] for i in rng.integers(0, len(lenses), n)]) + rng.normal(0, 0.5, (n, 3))
    directions = aims - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    scene = Scene()
    scene.add_instance(scene.add_mesh(*meshes.box([-WALLS] * 3, [WALLS] * 3)), np.eye(4))
    scene.set_spacetime_objects([lens.entry() for lens in lenses])
    scene.commit()
    hits = scene.intersect(origins, directions, 1e-6, angular_tolerance=1e-9)
    ends, lost, passed = reference(lenses, origins, directions)
    assert (passed > 1).sum() > 20
    arrived = ~np.isnan(ends[:, 0])
    same = (hits["fate"] == 4) == arrived
    assert (~same).sum() <= 1  # a ray within the reference's error of a critical one
    error = np.linalg.norm(hits["position"] - ends, axis=1)
    assert np.nanpercentile(error, 95) < 1e-6 and np.nanmedian(error) < 1e-7
    assert np.nanpercentile(error, 99.5) < 1e-3
    holes = np.array([lens.mass > 0 for lens in lenses])
    gone = same & ~arrived & (lost >= 0)
    assert gone.any()
    np.testing.assert_array_equal(hits["fate"][gone], np.where(holes[lost[gone]], 2, 3))
    np.testing.assert_array_equal(hits["sky"][gone], np.where(holes[lost[gone]], -1, lost[gone]))


def test_a_camera_looks_upright_out_of_the_other_mouth():
    """Into mouth A along its local +y is out of mouth B along its local +y; up stays up, and right stays right."""
    a, b = placed((0, 0, 0)), placed((10, 0, 0))
    scene = Scene()
    scene.set_spacetime_objects([(Spacetime.ellis(1.0), a, 4.0, 1), (Spacetime.ellis(1.0), b, 4.0, 0)])
    scene.commit()
    directions = np.array([[0, 1, 0], [0.02, 1, 0], [0, 1, 0.02]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    out = scene.intersect(np.array([[0, -3.0, 0]] * 3), directions)
    assert np.all(out["fate"] == 1) and np.all(out["sky"] == -1)
    np.testing.assert_allclose(out["direction"][0], [0, 1, 0], atol=1e-9)
    assert out["direction"][1, 0] > 0.005 and abs(out["direction"][1, 2]) < 1e-9
    assert out["direction"][2, 2] > 0.005 and abs(out["direction"][2, 0]) < 1e-9


def test_default_spheres_reach_half_way():
    """Radius 0 is half the distance of two objects, so that their spheres touch."""
    hole = Spacetime.schwarzschild(0.1)
    scene = Scene()
    scene.set_spacetime_objects([(hole, placed((0, 0, 0)), 0.0, -1), (hole, placed((4, 0, 0)), 0.0, -1)])
    scene.commit()
    out = scene.intersect(np.array([[-5.0, 2.01, 0], [-5.0, 1.99, 0]]), np.array([[1.0, 0, 0]] * 2))
    np.testing.assert_array_equal(out["direction"][0], [1, 0, 0])
    assert out["direction"][1, 1] < -1e-3


@pytest.mark.parametrize(
    "objects, message",
    [
        ([(placed((0, 0, 0)), math.inf, -1), (placed((9, 0, 0)), 1.0, -1)], "finite radius"),
        ([(placed((0, 0, 0)), 2.0, 1), (placed((9, 0, 0)), 2.0, -1)], "must have 0 as its exit"),
        ([(placed((0, 0, 0)), 2.0, 1), (placed((9, 0, 0), 2.0), 2.0, 0)], "equally wide"),
        ([(placed((0, 0, 0)), 2.0, 0)], "exit 0 is not another object"),
        ([(placed((0, 0, 0)), math.nan, -1)], "sphere_radius"),
        ([(np.zeros((4, 4)), 1.0, -1)], "last row"),
        ([(np.diag([1.0, 1, 0, 1]), 1.0, -1)], "singular"),
    ],
)
def test_impossible_wormholes_are_refused(objects, message):
    with pytest.raises(ValueError, match=message):
        Scene().set_spacetime_objects([(Spacetime.ellis(1.0), *rest) for rest in objects])
