"""The two images of every star around a hole that spins fast, as the camera goes round it: their tracks on its sky, and
where on the celestial sphere images are made. After James, von Tunzelmann, Franklin & Thorne 2015, figures 6 to 9.

Left, the camera's sky: each star draws a track while the camera moves by ORBIT along the hole's equator. Blue tracks
are primary images, whose light goes around the hole on the nearer side, amber ones secondary images, which go around
the other one. They meet at the white critical curve, which no track crosses: there images appear and disappear in
pairs. The red curve, close to the shadow, parts secondary images from the next ones.
Right, the celestial sphere, above the half behind the hole and below the half behind the camera: critical curves show
the caustics there. That of the white one is a point within the ring that marks it; that of the red one is the large
astroid of a spinning hole, which reaches around the sky.
"""

import argparse
import logging
from dataclasses import dataclass
from pathlib import Path

import bpy
import common
import numpy as np
from bentlight_native import Scene, Spacetime, StarImages, trace_rays

log = logging.getLogger("bentlight.examples")

HOLE, DISTANCE = Spacetime.kerr(1.0, 0.999), 15.0
ORBIT = np.radians(6.0)
STARS, FRAMES = 1400, 240
SIZE, CHART_SIZE = (900, 640), (340, 640)  # pixels, of both parts
HALF = 0.86  # of the picture's height at distance 1
CHART_RADIUS = 148.0  # pixels, of a hemisphere
PRIMARY, SECONDARY = np.array([0.4, 0.68, 1.0]), np.array([1.0, 0.6, 0.2])
CURVES = np.array([0.85, 0.95, 1.0]), np.array([1.0, 0.22, 0.12])
_EXPOSURE = 2.5e-3


@dataclass
class CriticalCurve:
    """Points (n, 3) all around the hole: `seen` in the camera's directions, `sky` where their light comes from."""

    seen: np.ndarray
    sky: np.ndarray


def make_scene() -> Scene:
    """The hole and a camera on its equator, for the core itself: nothing else is in the world."""
    camera = np.eye(4)
    camera[:3, :3] = np.column_stack([(1, 0, 0), (0, 0, 1), (0, -1, 0)])  # looks along +y
    camera[:3, 3] = 0, -DISTANCE, 0
    width = HALF * SIZE[0] / SIZE[1]
    scene = Scene()
    scene.set_spacetime(HOLE)
    scene.set_camera("PERSPECTIVE", camera, (-width, width, -HALF, HALF))
    scene.commit()
    return scene


# ---- Stars ----


def make_stars() -> tuple[np.ndarray, np.ndarray]:
    """Unit directions (n, 3) and irradiance (n,): a few bright ones, many faint ones."""
    from blender_addon.sync.star_catalog import procedural

    stars = procedural(STARS, 3, 0.0, 1.1)
    return stars.directions, 10 ** (-0.4 * stars.magnitudes)


def turned(directions: np.ndarray, angle: float) -> np.ndarray:
    """The sky about the hole's axis, which is the same as the camera turned the other way."""
    c, s = np.cos(angle), np.sin(angle)
    return directions @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def draw_tracks(scene: Scene, critical: CriticalCurve) -> np.ndarray:
    """(height, width, 3): all frames in one exposure, the last ones brightest."""
    directions, irradiance = make_stars()
    picture = np.zeros((SIZE[1], SIZE[0], 3))
    for frame in range(FRAMES):
        images = scene.find_stars(turned(directions, -ORBIT * frame / FRAMES), SIZE, threads=2)
        outside = is_outside(scene.camera_rays(images.place).directions, critical)
        light = images.light(irradiance[:, None] * np.ones(3)) * np.where(outside[:, None], PRIMARY, SECONDARY)
        picture += images.draw(light, SIZE, (0, 0, *SIZE)) * ((frame + 1) / FRAMES) ** 2
    return picture * _EXPOSURE / FRAMES


def is_outside(seen: np.ndarray, critical: CriticalCurve) -> np.ndarray:
    """Whether directions (n, 3) lie outside of a critical curve, where images are primary."""
    angles, radii = np.arctan2(critical.seen[:, 2], critical.seen[:, 0]), np.arccos(critical.seen[:, 1])
    order = angles.argsort()
    limit = np.interp(np.arctan2(seen[:, 2], seen[:, 0]), angles[order], radii[order], period=2 * np.pi)
    return np.arccos(seen[:, 1]) > limit


# ---- Critical curves ----


def towards(angle: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """(..., 3): local directions at an angle from the hole's middle, and around it."""
    angle, radius = np.broadcast_arrays(angle, radius)
    return np.stack([np.sin(radius) * np.cos(angle), np.cos(radius), np.sin(radius) * np.sin(angle)], axis=-1)


def sky_of(seen: np.ndarray) -> np.ndarray:
    """(..., 3): where light comes from that is seen in directions (..., 3); NaN in the shadow."""
    rays = np.ascontiguousarray(seen.reshape(-1, 3))
    origins = np.tile((0.0, -DISTANCE, 0.0), (len(rays), 1))
    return trace_rays(HOLE, origins, rays)["direction"].reshape(seen.shape)


def shadow_edge(angle: np.ndarray) -> np.ndarray:
    """(n,): radius of the shadow at angles around its middle, by bisection."""
    inside, outside = np.zeros_like(angle), np.ones_like(angle)
    for _ in range(45):
        middle = (inside + outside) / 2
        dark = np.isnan(sky_of(towards(angle, middle))[:, 0])
        inside, outside = np.where(dark, middle, inside), np.where(dark, outside, middle)
    return outside


def critical_curves(count: int = 2, points: int = 1440, steps: int = 500) -> list[CriticalCurve]:
    """Where the map from the camera's sky to the celestial sphere changes its parity, from the outermost curve on."""
    angle = np.arange(points) * (2 * np.pi / points)
    edge = shadow_edge(angle)
    radius = edge[:, None] + np.geomspace(1e-5, 1.0, steps)
    seen = towards(angle[:, None], radius)
    sky = sky_of(seen)
    around = (np.roll(sky, -1, axis=0) - np.roll(sky, 1, axis=0)) / 2
    parity = np.einsum("...k,...k", sky, np.cross(np.gradient(sky, axis=1), around))
    curves = [np.empty((points, 2, 3)) for _ in range(count)]
    for i in range(points):
        crossings = np.nonzero(parity[i, :-1] * parity[i, 1:] < 0)[0][::-1]
        for curve, k in zip(curves, crossings, strict=False):
            part = parity[i, k] / (parity[i, k] - parity[i, k + 1])
            curve[i] = [values[i, k] * (1 - part) + values[i, k + 1] * part for values in (seen, sky)]
    return [CriticalCurve(unit(curve[:, 0]), unit(curve[:, 1])) for curve in curves]


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


# ---- Drawing ----


def draw_points(size: tuple[int, int], pixels: np.ndarray, light: np.ndarray) -> np.ndarray:
    """(height, width, 3): points at pixel coordinates (n, 2), each as bright as one pixel of its light (n, 3)."""
    count = len(pixels)
    images = StarImages.sharp(np.arange(count), pixels / size, np.ones((count, 3)), np.ones(count), np.zeros(count))
    return images.draw(light / (size[0] * size[1]), size, (0, 0, *size))


def draw_line(size: tuple[int, int], pixels: np.ndarray, color: np.ndarray) -> np.ndarray:
    """(height, width, 3): a closed line through pixel coordinates (n, 2); NaN and wide gaps are left out."""
    ends = np.roll(pixels, -1, axis=0)
    lengths = np.nan_to_num(np.linalg.norm(ends - pixels, axis=1), nan=np.inf)
    drawn, parts = lengths < 40, 80
    part = (np.arange(parts) + 0.5)[:, None, None] / parts
    places = pixels[drawn] + part * (ends - pixels)[drawn]
    light = np.broadcast_to(lengths[drawn][:, None] / parts * color, (*places.shape[:2], 3))
    return draw_points(size, places.reshape(-1, 2), light.reshape(-1, 3))


def picture_pixels(seen: np.ndarray) -> np.ndarray:
    """(n, 2): where the camera shows directions (n, 3)."""
    return np.array(SIZE) / 2 + seen[:, ::2] / seen[:, 1:2] * (SIZE[1] / (2 * HALF))


def chart_pixels(sky: np.ndarray, half: int) -> np.ndarray:
    """(n, 2): where a half of the celestial sphere, 1 behind the hole, -1 behind the camera, shows directions (n, 3).

    Angles from its middle are true (azimuthal equidistant). NaN in the other half.
    """
    angle = np.arccos(np.clip(half * sky[:, 1], -1, 1))
    out = unit(sky[:, ::2] * (half, 1)) * (angle / (np.pi / 2))[:, None]
    out[angle > np.pi / 2] = np.nan
    return (CHART_SIZE[0] / 2, CHART_SIZE[1] * (0.5 + 0.25 * half)) + CHART_RADIUS * out


def draw_chart(curves: list[CriticalCurve]) -> np.ndarray:
    """(height, width, 3): both halves of the celestial sphere, with the stars and the caustics."""
    directions, irradiance = make_stars()
    rim = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    circle = towards(rim, np.pi / 2)
    chart = np.zeros((CHART_SIZE[1], CHART_SIZE[0], 3))
    for half in (1, -1):
        places = chart_pixels(directions, half)
        shown = np.isfinite(places[:, 0])
        brightness = np.clip(irradiance * 20, 0.25, 2.0)[shown]
        chart += draw_points(CHART_SIZE, places[shown], brightness[:, None] * PRIMARY)
        chart += draw_line(CHART_SIZE, chart_pixels(circle * (1, 0, 1) + (0, 1e-9 * half, 0), half), np.full(3, 0.12))
        for curve, color in zip(curves, CURVES, strict=True):
            chart += draw_line(CHART_SIZE, chart_pixels(curve.sky, half), 0.9 * color)
    chart += draw_line(CHART_SIZE, ring_around(chart_pixels(curves[0].sky, 1)), 0.9 * CURVES[0])
    return chart


def ring_around(pixels: np.ndarray, radius: float = 6.0) -> np.ndarray:
    """(n, 2): a circle that shows where something tiny is."""
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    return np.nanmean(pixels, axis=0) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def compose() -> np.ndarray:
    """(height, width, 3), linear, rows upwards: both parts side by side."""
    scene, curves = make_scene(), critical_curves()
    picture = draw_tracks(scene, curves[0])
    for curve, color in zip(curves, CURVES, strict=True):
        picture += draw_line(SIZE, picture_pixels(curve.seen), 0.6 * color)
    return np.concatenate([picture, draw_chart(curves)], axis=1)


def save(picture: np.ndarray, path: Path) -> None:
    """Writes a PNG; linear light becomes sRGB, bright light fades into white."""
    linear = 1 - np.exp(-picture)
    encoded = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    height, width = picture.shape[:2]
    image = bpy.data.images.new("Figure", width, height)
    image.pixels.foreach_set(np.concatenate([encoded, np.ones((height, width, 1))], axis=2).astype(np.float32).ravel())
    path.parent.mkdir(parents=True, exist_ok=True)
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=common.OUTPUT / "primary_secondary.png")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    common.register()
    save(compose(), arguments.output.resolve())
    log.info("%s", arguments.output)
