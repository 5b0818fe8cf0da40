"""An Einstein ring that can be measured: one small bright disk exactly behind a hole, in empty space.

In the isotropic chart the camera stands at the areal radius R_OBSERVER and the disk at R_SOURCE, both in units of the
mass. Light reaches the camera from every point of a ring around the hole; `ring_angle` gives its radius in closed
form, and tests/images measures the same angle in the picture.
"""

import math

import bpy
import common
import materials
import numpy as np
import objects

MASS = 1.0
R_OBSERVER = 50.0
R_SOURCE = 50.0
DISK_RADIUS = 0.5
FIELD_OF_VIEW = math.radians(36)


def build() -> bpy.types.Scene:
    """Makes the scene in the current file and returns it."""
    scene = common.new_scene(samples=64, resolution=(360, 360))
    scene.bentlight.max_bounces = 0
    scene.view_settings.view_transform = "Standard"
    bpy.ops.bentlight.black_hole_add(mass=MASS, spin=0.0, location=(0, 0, 0))
    bpy.ops.mesh.primitive_circle_add(
        vertices=128,
        radius=DISK_RADIUS,
        fill_type="NGON",
        location=(0, isotropic_radius(R_SOURCE), 0),
        rotation=(math.pi / 2, 0, 0),
    )
    objects.place(bpy.context.object, materials.emission("Star", (1.0, 0.85, 0.6), 1.0))
    view = objects.camera((0, -isotropic_radius(R_OBSERVER), 0), (0, 0, 0))
    view.data.sensor_fit, view.data.angle = "HORIZONTAL", FIELD_OF_VIEW
    view.data.clip_end = 1000.0
    return scene


def isotropic_radius(r: float, mass: float = MASS) -> float:
    """The radius in the scene, R = (r - M + sqrt(r^2 - 2 M r)) / 2, of the areal radius r."""
    return (r - mass + math.sqrt(r * r - 2 * mass * r)) / 2


def ring_radius_pixels(angle: float, width: int = 360) -> float:
    """Where a perspective camera of FIELD_OF_VIEW shows the angle, measured from the middle of a picture."""
    return width / 2 * math.tan(angle) / math.tan(FIELD_OF_VIEW / 2)


def ring_angle(
    r_observer: float = R_OBSERVER, r_source: float = R_SOURCE, mass: float = MASS, swept: float = math.pi
) -> float:
    """The angle (rad) between the ring and the middle of the hole, as a static observer at r_observer measures it.

    The ray with impact parameter b swings by `swept` (rad; pi for a source exactly behind the hole) on its way between
    the two radii. With u = M/r its orbit is (du/dphi)^2 = (M/b)^2 - u^2 + 2 u^3 (Darwin 1959); with the cubic's roots
    u1 < 0 < u2 < u3 the angle from u to the turning point u2 is
    2 / sqrt(2 (u3 - u1)) * (K(k) - F(asin sqrt((u - u1)/(u2 - u1)), k)), k^2 = (u2 - u1)/(u3 - u1).
    """

    def swing(u2: float) -> float:
        # Vieta: the three roots sum to 1/2 and their pair products to 0, so u2 fixes u1 and u3.
        root = math.sqrt((1 - 2 * u2) * (1 + 6 * u2))
        u1, u3 = (1 - 2 * u2 - root) / 4, (1 - 2 * u2 + root) / 4
        k2 = (u2 - u1) / (u3 - u1)
        scale = 2 / math.sqrt(2 * (u3 - u1))
        angle = 0.0
        for r in (r_observer, r_source):
            amplitude = math.asin(math.sqrt((mass / r - u1) / (u2 - u1)))
            angle += scale * (elliptic_f(math.pi / 2, k2) - elliptic_f(amplitude, k2))
        return angle

    low, high = mass / min(r_observer, r_source), 1 / 3 - 1e-12  # the swept angle grows with u2 up to the photon sphere
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if swing(middle) < swept else (low, middle)
    b = mass / (low * math.sqrt(1 - 2 * low))
    return math.asin(b / r_observer * math.sqrt(1 - 2 * mass / r_observer))


def elliptic_f(amplitude: float, k2: float, points: int = 64) -> float:
    """Legendre's F(amplitude, k) by Gauss-Legendre quadrature; to 1e-13 for k^2 < 0.9."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    theta = amplitude / 2 * (nodes + 1)
    return float(amplitude / 2 * np.sum(weights / np.sqrt(1 - k2 * np.sin(theta) ** 2)))


if __name__ == "__main__":
    common.main(build, "einstein_ring.png")
