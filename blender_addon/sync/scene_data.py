"""A scene as plain numpy data: what the rest of the add-on reads from Blender and hands to the native core.

No bpy here. World coordinates are Blender's; matrices are (4, 4) float64, row-major, for column vectors. Meshes, images
and materials are named by their place in their list, as in the native scene.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from bentlight_native import EVERYONE, Aperture, Influence


class Visibility:
    """Bits of the kinds of rays that see an instance (bent_visibility)."""

    CAMERA = 1
    DIFFUSE = 2
    GLOSSY = 4
    TRANSMISSION = 8
    ALL = 15
    HOLDOUT = 16  # the camera sees a hole in the picture
    SHADOWLESS = 32  # casts no shadow
    IMMATERIAL = 128  # sends light along rays, and lets them pass: a lamp


@dataclass
class MeshData:
    """Triangles with what shading needs at their corners. None means the core's default (flat, zero, slot 0)."""

    vertices: np.ndarray  # (n, 3) float32
    triangles: np.ndarray  # (m, 3) uint32, indices of vertices
    corner_normals: np.ndarray | None = None  # (m, 3, 3) float32, unit
    corner_uvs: np.ndarray | None = None  # (m, 3, 2) float32
    material_slots: np.ndarray | None = None  # (m,) uint32, index into the instance's materials
    generated: np.ndarray | None = None  # (n, 3) float32, texture space coordinates, [0, 1] inside it
    attributes: dict[int, np.ndarray] = field(
        default_factory=dict
    )  # (m, 3, 1 to 4) float32, by the number in materials


@dataclass
class InstanceData:
    """One appearance of a mesh in the world."""

    name: str  # of the object, for messages
    mesh: int
    world_from_mesh: np.ndarray
    materials: tuple[int, ...] = ()
    visibility: int = Visibility.ALL
    object_index: float = 0.0
    one_sided: bool = False
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)  # RGB and alpha, for materials that ask
    random: float = 0.0  # in [0, 1], likewise
    attributes: dict[int, tuple[float, ...]] = field(default_factory=dict)  # four numbers, by the number in materials
    influence: Influence = EVERYONE  # of its own light
    receiver_set: int = 0  # by which the influence of others names it, as by the next
    blocker_set: int = 0
    is_disk: bool = False  # an accretion disk: no mesh of the user's
    asset: str = ""  # name of the topmost parent, for Cryptomatte
    light_group: str = ""  # of its own light; as of lamps, suns and the world, "": none
    carrier: str = ""  # name of the object that instances it, as of lamps, suns and holes; "": none does


@dataclass
class LampData:
    """A point of light."""

    name: str  # of the object, for messages
    world_from_lamp: np.ndarray
    material: int
    visibility: int = Visibility.ALL
    influence: Influence = EVERYONE
    light_group: str = ""
    carrier: str = ""


@dataclass
class SunData:
    """A disk in the sky, or a point of it."""

    direction: tuple[float, float, float]  # unit, towards the sun
    radiance: tuple[float, float, float]  # of a point: irradiance of what faces it
    angle: float  # diameter, radians
    material: int = -1  # or what gives its radiance instead
    world_from_sun: np.ndarray = field(default_factory=lambda: np.eye(4))
    visibility: int = Visibility.ALL
    influence: Influence = EVERYONE
    light_group: str = ""
    name: str = ""  # of the object
    carrier: str = ""


@dataclass
class StarData:
    """Points of the sky that only the camera sees."""

    directions: np.ndarray  # (n, 3) unit, towards the stars
    irradiance: np.ndarray  # (n, 3) linear RGB, of what faces them


@dataclass
class SpacetimeData:
    """A black hole or one mouth of a wormhole. Lengths are in its own units unless said otherwise."""

    name: str
    kind: str  # 'BLACK_HOLE' or 'WORMHOLE'
    world_from_spacetime: np.ndarray  # rotation, uniform positive scale, translation
    mass: float = 0.0
    spin: float = 0.0  # a/M
    chart: str = "ISOTROPIC"  # or 'OBLATE'
    throat_radius: float = 0.0
    sphere_radius: float = 0.0  # of influence; 0: automatic
    exit: str | None = None  # name of the other mouth
    carrier: str = ""

    @property
    def scale(self) -> float:
        """World units per unit of its own."""
        return float(np.linalg.norm(self.world_from_spacetime[:3, 0]))

    @property
    def origin(self) -> np.ndarray:
        """World position (3,)."""
        return self.world_from_spacetime[:3, 3]


@dataclass
class CameraData:
    """A camera, exactly as Cycles reads Blender's.

    A point of the image at fractions (u, v) of its width and height, from its lower left corner, lies at
    (left + u (right - left), bottom + v (top - bottom)) of `window`: for 'PERSPECTIVE' the slopes x/-z and y/-z of the
    ray in the camera's axes (x right, y up, looking along -z), for 'ORTHOGRAPHIC' the ray's start in scene units, for
    panoramas the fractions at which the panorama is looked up, [0, 1] without shift.
    """

    kind: str  # 'PERSPECTIVE', 'ORTHOGRAPHIC' or Blender's panorama_type
    world_from_camera: np.ndarray  # no scale
    width: int  # of the whole image, pixels
    height: int
    window: tuple[float, float, float, float]  # left, right, bottom, top
    clip_start: float
    clip_end: float
    panorama: dict[str, float] = field(default_factory=dict)  # the lens: Blender's property names and values
    aperture: Aperture | None = None  # without, everything is sharp


@dataclass
class SceneData:
    """Everything that one frame of one view layer shows."""

    camera: CameraData
    meshes: list[MeshData] = field(default_factory=list)
    instances: list[InstanceData] = field(default_factory=list)
    suns: list[SunData] = field(default_factory=list)
    lamps: list[LampData] = field(default_factory=list)
    spacetimes: list[SpacetimeData] = field(default_factory=list)
    images: list[Any] = field(default_factory=list)
    materials: list[Any] = field(default_factory=list)
    world: Any = None
    material_labels: list[tuple[str, float]] = field(default_factory=list)  # name and pass index of each; "": no user's
    world_group: str = ""
    stars: StarData | None = None
    gravitational: float = 0.0  # how much gravity shifts light: Scene.set_gravitational
