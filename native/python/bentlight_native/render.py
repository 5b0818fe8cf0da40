"""Path tracing by tiles: camera, suns, settings and the channels of a render.

`RenderMethods` gives these methods to `Scene`. Angles are in radians, lengths in scene units, colors linear RGB.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .influence import EVERYONE, Influence, influences


class Channel(NamedTuple):
    """One thing a render can deliver. `reduction` says how a pixel's samples become its value: 'mean', 'max', 'first'
    (the first sample of the range, as Cycles does for depth and position), 'count', or 'state' (what a call that
    resumes from channels goes on with), or 'matte' (pairs of a name and the mean of its coverage, the largest first).
    items: '', or the setting that says how many times the components are there."""

    name: str
    components: int
    reduction: str
    description: str
    items: str

    def width(self, settings: "RenderSettings") -> int:
        """Values of a pixel: the last size of the channel's array."""
        return self.components * (getattr(settings, self.items) if self.items else 1)


CHANNELS: dict[str, Channel] = {row[0]: Channel(*row) for row in _core.render_channels()}


@dataclass(frozen=True)
class RenderSettings:
    """How to render; the defaults are those of Cycles where it has the setting.

    width, height: size of the full image, pixels.
    first_sample, sample_count: which samples of every pixel to take; their sum stays below 2**31.
    sampling_pattern: 'BLUE_NOISE': random numbers of nearby pixels complement each other, so that their errors cancel
        and noise is fine-grained, at every number of samples. 'CLASSIC': pixels are independent.
    noise_threshold: a pixel gets no more samples once its noise (the summed standard errors of its colors times
        sqrt(2/pi), over the square root of their sum, as in Cycles) is below; 0: all get all. min_samples: those that
        every pixel gets at least; 2 or more.
    photon_ring_samples: near the image of a photon sphere, and in a wormhole's mouth, a pixel takes up to this many
        samples where another takes one, 1 to 64: one more for every 0.1 radians by which bending spreads the camera
        rays through its corners. 1: all pixels are alike.
    resume: the state holds all samples before first_sample and is gone on with, as if one call had taken all; pixels
        that the noise threshold has ended stay as they are. Without a state the channels do, to float32 rounding,
        which takes 'sample_count', and with a noise threshold 'combined' and those of reduction 'state'.
    max_bounces: scatterings before the last one, in all and by kind of lobe, counted as Cycles does: at 0 a path
        scatters once and gathers emission only. transparent_bounces counts straight passes through surfaces.
    roulette_start: bounces before Russian roulette may end a path.
    tolerance: wanted angular error of a ray, in (0, 0.1]; a tenth of a pixel's angle is used if that is smaller, and
        ten times as much after a diffuse scattering.
    filter: 'BLACKMAN_HARRIS', 'GAUSSIAN' or 'BOX' (one pixel wide); filter_width: its full support, pixels.
    sky_filter: equirectangular images of the sky that the camera sees are averaged around each ray by a Gaussian of
        this standard deviation, pixels, 0 to 1, as bending maps them to the sky. 1 / sqrt(samples) takes most of the
        noise of details that are small beside a pixel; 0: not averaged.
    film_transparent: the sky that the camera sees has alpha 0 and no color in `combined`.
    clamp_direct, clamp_indirect: largest contribution (mean of RGB) of light that was scattered once at most, and of
        light that was scattered more often; 0 is off.
    integrator: 'PATH': light is followed from the camera; 'BIDIRECTIONAL': from the lamps as well, for caustics.
        The mean of a picture is the same, except that PATH does not find caustics of lamps without size.
        Suns, the sky and lamps that do not shine on all objects are followed from the camera alone.
        `Scene.bidirectional_obstacle` says where it is PATH instead. light_sampling must be 'BOTH'; blur_glossy and
        the switches of caustics do nothing.
    light_sampling: how lights are found. 'SCATTERING': by scattered rays that happen to meet them; 'CONNECTIONS': by
        rays that join a point on a light with the surface, where they are known; 'BOTH': each where it is better. The
        mean of a picture is the same, except that lamps and suns without size need connections.
    blur_glossy: Cycles' Filter Glossy: what is seen by way of a blurry scattering is made rougher, which takes noise
        and blurs caustics; 0 is off. caustics_reflective, caustics_refractive: whether rays that were scattered
        diffusely see reflections and refractions by glossy surfaces and glass.
    portal_sampling: aims some scattered rays at the mouths of wormholes; the mean is the same.
    light_threshold: connections that would bring a sample less light than this are traced by chance only, in
        proportion, which costs some noise and no bias; 0 traces all.
    alpha_threshold: surfaces less opaque than this are passed over by depth, position, normal and other data of the
        first surface.
    light_groups, aovs, matte_ranks: items in the channels of that many, at most 1024.
    mist_start, mist_depth, mist_falloff: of the channel 'mist', which rises over that depth, by that power.
    occlusion_distance: how far rays of the channel 'ambient_occlusion' see.
    """

    width: int
    height: int
    first_sample: int = 0
    sample_count: int = 1
    seed: int = 0
    noise_threshold: float = 0.0
    min_samples: int = 16
    photon_ring_samples: int = 1
    max_bounces: int = 12
    diffuse_bounces: int = 4
    glossy_bounces: int = 4
    transmission_bounces: int = 12
    transparent_bounces: int = 8
    roulette_start: int = 2
    tolerance: float = 1e-4
    filter: str = "BLACKMAN_HARRIS"
    filter_width: float = 3.0
    film_transparent: bool = False
    clamp_direct: float = 0.0
    clamp_indirect: float = 0.0
    integrator: str = "PATH"
    light_sampling: str = "BOTH"
    blur_glossy: float = 0.0
    caustics_reflective: bool = True
    caustics_refractive: bool = True
    portal_sampling: bool = True
    light_threshold: float = 0.01
    alpha_threshold: float = 0.5
    resume: bool = False
    sampling_pattern: str = "BLUE_NOISE"
    sky_filter: float = 0.0
    light_groups: int = 1
    aovs: int = 1
    matte_ranks: int = 1
    mist_start: float = 5.0
    mist_depth: float = 25.0
    mist_falloff: float = 2.0
    occlusion_distance: float = 10.0


class RenderStatistics(NamedTuple):
    """What happened in a call of `render_tile`.

    samples: pixel samples finished; 0 when a resumed call found no pixel that wants more.
    rays: rays traced, all bounces.
    unresolved: rays whose tolerance could not be met; they are black, and pi in the channel `error`.
    invalid: samples that came out NaN or infinite because of broken input; they count as black.
    joins, lost_joins: curved rays that connections with lights have looked for, and those of them that exist but were
        not found exactly enough (`connect`). Their light comes by scattering, that of lamps without size not at all.
    """

    samples: int
    rays: int
    unresolved: int
    invalid: int
    joins: int
    lost_joins: int


class Aperture(NamedTuple):
    """The opening of a camera's lens, as Cycles has it.

    radius: scene units. focal_distance: of what is sharp, depth, in panoramas distance, in the camera's own straight
    space; positive. blades: corners of a regular polygon of that circumradius, at most 64, below 3 a disk. rotation:
    radians, of the middle of a side. ratio: positive; 2 squeezes the opening to half its width.
    """

    radius: float
    focal_distance: float
    blades: int = 0
    rotation: float = 0.0
    ratio: float = 1.0


class CameraRays(NamedTuple):
    """Camera rays; every entry of a row is NaN where the projection has none (outside a fisheye's circle).

    origins, directions: (n, 3) float64, world; directions are unit vectors.
    length_min, length_max: (n,) float64, the clip range as length along the ray.
    depth_per_length: (n,) float64, z depth of the point at unit distance; 1 where depth means distance.
    """

    origins: NDArray[np.float64]
    directions: NDArray[np.float64]
    length_min: NDArray[np.float64]
    length_max: NDArray[np.float64]
    depth_per_length: NDArray[np.float64]


class RenderMethods:
    """The methods of `Scene` that concern rendering."""

    def set_camera(
        self,
        kind: str,
        world_from_camera: ArrayLike,
        viewplane: tuple[float, float, float, float],
        clip_start: float = 0.0,
        clip_end: float = inf,
        *,
        longitude_min: float = -pi,
        longitude_max: float = pi,
        latitude_min: float = -pi / 2,
        latitude_max: float = pi / 2,
        fisheye_fov: float = pi,
        fisheye_lens: float = 10.5,
        sensor_width: float = 36.0,
        sensor_height: float = 24.0,
        fisheye_polynomial_k0: float = 0.0,
        fisheye_polynomial_k1: float = 0.0,
        fisheye_polynomial_k2: float = 0.0,
        fisheye_polynomial_k3: float = 0.0,
        fisheye_polynomial_k4: float = 0.0,
        central_cylindrical_range_u_min: float = -pi,
        central_cylindrical_range_u_max: float = pi,
        central_cylindrical_range_v_min: float = -1.0,
        central_cylindrical_range_v_max: float = 1.0,
        central_cylindrical_radius: float = 1.0,
        aperture: Aperture | None = None,
    ) -> None:
        """Set the camera; visible after commit().

        kind: 'PERSPECTIVE', 'ORTHOGRAPHIC', or a panorama as in Cycles: 'EQUIRECTANGULAR',
            'EQUIANGULAR_CUBEMAP_FACE', 'MIRRORBALL', 'FISHEYE_EQUIDISTANT', 'FISHEYE_EQUISOLID',
            'FISHEYE_LENS_POLYNOMIAL', 'CENTRAL_CYLINDRICAL'.
        world_from_camera: (4, 4); in camera space the view is along -z, x points right, y up. Its scale is ignored.
        viewplane: left, right, bottom, top of the image, shift included: on the plane at distance 1 (perspective), in
            scene units (orthographic), or in the panorama's (u, v), where (0, 1, 0, 1) is all of it.
        clip_start, clip_end: z depth (perspective, orthographic) or distance (panoramas).
        aperture: of the lens, for depth of field; without, everything is sharp.
        The rest are the parameters of the panoramas, named as Blender's camera properties; sensor and lens in mm.
        Raises ValueError for an unknown kind, a singular matrix or a parameter out of its range.
        """
        self._set_camera(
            kind,
            np.ascontiguousarray(world_from_camera, dtype=np.float64),
            tuple(viewplane),
            clip_start,
            clip_end,
            longitude_min,
            longitude_max,
            latitude_min,
            latitude_max,
            fisheye_fov,
            fisheye_lens,
            sensor_width,
            sensor_height,
            fisheye_polynomial_k0,
            fisheye_polynomial_k1,
            fisheye_polynomial_k2,
            fisheye_polynomial_k3,
            fisheye_polynomial_k4,
            central_cylindrical_range_u_min,
            central_cylindrical_range_u_max,
            central_cylindrical_range_v_min,
            central_cylindrical_range_v_max,
            central_cylindrical_radius,
            aperture or Aperture(0.0, 1.0),
        )

    def camera_rays(self, points: ArrayLike, lens: ArrayLike | None = None) -> CameraRays:
        """The rays through points of the image, (n, 2) in [0, 1] from its left and bottom edges.

        lens: (n, 2) in [0, 1), evenly mapped to the area of the aperture; without, all rays go through its middle.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        origins, directions, ranges = (np.empty((len(points), 3)) for _ in range(3))
        lens = None if lens is None else np.ascontiguousarray(lens, dtype=np.float64)
        self._camera_rays(points, origins, directions, ranges, lens)
        return CameraRays(origins, directions, *ranges.T)

    def set_suns(
        self,
        directions: ArrayLike,
        radiance: ArrayLike,
        angle: ArrayLike,
        visibility: ArrayLike = 15,
        influence: Influence | Sequence[Influence] = EVERYONE,
        materials: ArrayLike = -1,
        world_from_sun: ArrayLike | None = None,
    ) -> None:
        """Replace all suns, disks on the asymptotic sky; visible after commit().

        directions: (n, 3), towards each sun. radiance: (n, 3) linear RGB; a surface that faces the sun receives
        pi * sin(angle / 2)**2 * radiance. angle: scalar or (n,), angular diameter in [0, pi]; at 0 the radiance is the
        irradiance of a surface that faces the sun. visibility: scalar or (n,) bits: camera 1, diffuse 2, glossy 4,
        transmission 8. influence: one for all, or n: whom it lights. materials: scalar or (n,), -1 or what gives the
        radiance instead; the place that its program sees is minus the direction, its UV the disk in the unit square.
        world_from_sun: (n, 4, 4), of its object coordinates; None: the identity.
        """
        directions = np.ascontiguousarray(directions, dtype=np.float64).reshape(-1, 3)
        radiance = np.ascontiguousarray(radiance, dtype=np.float64).reshape(-1, 3)
        count = len(directions)
        places = np.broadcast_to(np.eye(4) if world_from_sun is None else world_from_sun, (count, 4, 4))
        self._set_suns(
            directions,
            radiance,
            np.array(np.broadcast_to(angle, (count,)), dtype=np.float64),
            np.array(np.broadcast_to(visibility, (count,)), dtype=np.uint32),
            influences(influence, count),
            np.array(np.broadcast_to(materials, (count,)), dtype=np.int32),
            np.ascontiguousarray(places, dtype=np.float64),
        )

    def set_lamps(
        self,
        world_from_lamp: ArrayLike,
        materials: ArrayLike,
        visibility: ArrayLike = 15,
        influence: Influence | Sequence[Influence] = EVERYONE,
    ) -> None:
        """Replace all lamps, points of light that only connections find; visible after commit().

        world_from_lamp: (n, 4, 4), the place and axes of each lamp. materials: scalar or (n,), indices: the radiance
        that a material emits towards a direction is the lamp's radiant intensity there. visibility: scalar or (n,)
        bits as of suns: the kinds of scattering that it lights. influence: as of suns.
        """
        matrices = np.ascontiguousarray(world_from_lamp, dtype=np.float64).reshape(-1, 4, 4)
        count = len(matrices)
        self._set_lamps(
            matrices,
            np.array(np.broadcast_to(materials, (count,)), dtype=np.int32),
            np.array(np.broadcast_to(visibility, (count,)), dtype=np.uint32),
            influences(influence, count),
        )

    def set_labels(
        self,
        instance_names: ArrayLike = (),
        instance_groups: ArrayLike = (),
        materials: ArrayLike = (),
        lamp_groups: ArrayLike = (),
        sun_groups: ArrayLike = (),
        world_group: int = -1,
    ) -> None:
        """Say what passes tell things apart by; in the order in which they were added. Takes no commit.

        instance_names: (n, 2), the Cryptomatte names of object and asset, hashes as float32. instance_groups: (n, 2)
        the light group of an instance's own light, -1: none, and 1 if it is an accretion disk, else 0. materials:
        (m, 2) the Cryptomatte name and the index of each. lamp_groups, sun_groups: (k,).
        """
        self._set_labels(
            np.ascontiguousarray(instance_names, dtype=np.float32).reshape(-1, 2),
            np.ascontiguousarray(instance_groups, dtype=np.int32).reshape(-1, 2),
            np.ascontiguousarray(materials, dtype=np.float32).reshape(-1, 2),
            np.ascontiguousarray(lamp_groups, dtype=np.int32),
            np.ascontiguousarray(sun_groups, dtype=np.int32),
            world_group,
        )

    def draw_lights(
        self, points: ArrayLike, normals: ArrayLike, u: ArrayLike
    ) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
        """The light that the renderer draws for each point, for tests and diagnosis. The scene must be committed.

        points, normals: (n, 3); a normal of 0 takes light from all sides. u: (n, 4) in [0, 1): two for
            the place on the light, one for its choice.
        Returns (n, 3) kind (0 triangle, 1 lamp, 2 sun, 3 sky; -1 nothing), index of instance, lamp or sun, triangle;
        (n, 3) the world position or asymptotic direction; and (n, 3) how often it is drawn: the probability of a lamp
        or sun, of a triangle that times the density of the place over its mean, of the sky the pdf by solid angle; the
        same as it weighs against scattering, which does not know what the point's surface faces; and that looked up
        afterwards.
        """
        points, normals, u = (np.ascontiguousarray(a, dtype=np.float64) for a in (points, normals, u))
        n = len(points)
        which, target, probability = np.empty((n, 3), np.int32), np.empty((n, 3)), np.empty((n, 3))
        self._draw_lights(points, normals, u, which, target, probability)
        return which, target, probability

    def draw_light_starts(
        self, u: ArrayLike
    ) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Where light subpaths start, for tests and diagnosis. The scene must be committed; ValueError if none starts.

        u: (n, 6) in [0, 1): one for the light, two for the place on it, three for the direction. Returns (n, 3) kind (0
        triangle, 1 lamp), index of instance or lamp, triangle or -1; (n, 3) places; (n, 3) directions; and (n, 2) the
        chance of the triangle or lamp, and the direction's pdf by solid angle.
        """
        u = np.ascontiguousarray(u, dtype=np.float64)
        n = len(u)
        which, place, direction = np.empty((n, 3), np.int32), np.empty((n, 3)), np.empty((n, 3))
        probability = np.empty((n, 2))
        self._draw_light_starts(u, which, place, direction, probability)
        return which, place, direction, probability

    def join(
        self,
        points: ArrayLike,
        ends: ArrayLike,
        *,
        sky: bool = False,
        far: bool = False,
        u: ArrayLike | None = None,
        way_chances: ArrayLike | None = None,
    ) -> dict[str, NDArray]:
        """The rays that the renderer knows to join places, for tests and diagnosis. The scene must be committed.

        points, ends: (n, 3) world positions; with sky, ends are unit asymptotic directions, of the skies beyond
        wormholes without exit with far. u: (n,) in [0, 1) decides what is listed, as in a render; None lists all.
        way_chances: (n, 1 + 2 lenses) in (0, 1]: those with which the straight way and, by way of each lens, that on
        this side and that through its throat are tried; None: all are.
        Returns "count" (n,); "wanted" and "lost" (n,), how many images around a hole or wormhole, both ends beside it,
        were looked for, and those of them that exist but were not found exactly enough; "rest" (n,), what u has left
        for further decisions; and for each pair in places
        0 .. count - 1 of 16, the others NaN or -1: "launch", "arrival" (n, 16, 3) local directions of travel, "spread"
        (n, 16) local area at the end (solid angle of sky) per solid angle of launch, "swept" (n, 16), and "first_lens",
        "borders", "length" as ``intersect`` has them; "chance", with which the way, number "way", was tried; with more
        than 16 rays also some of the faintest are left out by chance, by which others that stand for them are to be
        divided; and "image_chance", with which such an image of a way that is tried is listed.
        """
        points, ends = (np.ascontiguousarray(a, dtype=np.float64) for a in (points, ends))
        given = (None if a is None else np.ascontiguousarray(a, dtype=np.float64) for a in (u, way_chances))
        n, shape = len(points), (len(points), 16)
        out = {name: np.empty(n, np.int32) for name in ("count", "wanted", "lost")}
        out["rest"] = np.empty(n)
        out |= {name: np.full((*shape, 3), np.nan) for name in ("launch", "arrival")}
        out |= {name: np.full(shape, np.nan) for name in ("spread", "swept")}
        out |= {"first_lens": np.full(shape, -1, np.int32), "borders": np.zeros(shape, np.uint32)}
        out |= {name: np.full(shape, np.nan) for name in ("length", "chance", "image_chance")}
        out["way"] = np.full(shape, -1, np.int32)
        self._join(sky, far, points, ends, *given, *out.values())
        return out

    def render_tile(
        self,
        x: int,
        y: int,
        width: int,
        height: int,
        settings: RenderSettings,
        channels: Mapping[str, NDArray[np.float32]],
        progress: "_core.Progress | None" = None,
        light: NDArray[np.int64] | None = None,
        state: NDArray[np.float64] | None = None,
    ) -> RenderStatistics:
        """Render one tile of the image and write it into `channels`.

        x, y, width, height: the tile in pixels, counted from the bottom left of the full image, rows upwards.
        channels: for each wanted name of CHANNELS a C-contiguous float32 array (height, width, components).
        progress: `done` counts pixel samples; after cancel() the call raises Cancelled within 0.1 s and the arrays
            hold what was finished: the channel `sample_count` says how many samples each pixel has (0: all zero).
        light: with the integrator BIDIRECTIONAL, (settings.height, settings.width, 3) of the whole image, to which the
            call adds what light subpaths bring anywhere in it; calls on several threads may share it (`light_image`).
        state: (height, width, state_width(channels, settings)), what the samples add up to: a call that resumes goes on
            with it to the last bit, and merge_states and develop_state take it.
        The result is the same to the last bit for any tiles, order and number of threads. Releases the GIL.
        Raises ValueError for bad settings or arrays, RuntimeError without a camera or before commit().
        """
        values = {field.name: getattr(settings, field.name) for field in fields(settings)}
        done = self._render_tile((x, y, width, height), dict(channels), state, light, progress, **values)
        return RenderStatistics(**done)


def sobol_points(
    seed: int, pixel: tuple[int, int], dimension_set: int, first: int, count: int, pattern: str = "BLUE_NOISE"
) -> NDArray[np.float64]:
    """The renderer's random numbers: samples first .. first + count - 1 of a pixel in one set of four dimensions,
    (count, 4) in [0, 1). Owen-scrambled Sobol points, independent between sets. Pixels, below 2^16, are independent in
    the pattern 'CLASSIC'; in 'BLUE_NOISE' those of an aligned square are a net together. Set 0 is the camera's."""
    out = np.empty((count, 4))
    _core.sobol_points(pattern, seed, pixel[0], pixel[1], dimension_set, first, out)
    return out


def filter_offsets(kind: str, width: float, u: ArrayLike) -> NDArray[np.float64]:
    """Offsets from a pixel's center, in pixels, for numbers u in [0, 1): inverse cumulative of the pixel filter."""
    out = np.array(u, dtype=np.float64, ndmin=1)
    _core.filter_offsets(kind, width, out)
    return out
