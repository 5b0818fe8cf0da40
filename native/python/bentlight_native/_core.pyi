"""Types of the C module; its own docstrings say what each name does."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

class Cancelled(Exception): ...

class Progress:
    def __init__(self) -> None: ...
    def cancel(self) -> None: ...
    def advance(self, count: int, /) -> None: ...
    @property
    def done(self) -> int: ...
    @property
    def cancelled(self) -> bool: ...

class Scene:
    def __init__(self) -> None: ...
    def add_mesh(
        self,
        vertices: NDArray[np.float32],
        triangles: NDArray[np.uint32],
        corner_normals: NDArray[np.float32] | None,
        corner_uvs: NDArray[np.float32] | None,
        material_slots: NDArray[np.uint32] | None,
        generated: NDArray[np.float32] | None,
    ) -> int: ...
    def update_mesh(
        self,
        mesh: int,
        vertices: NDArray[np.float32],
        corner_normals: NDArray[np.float32] | None,
        generated: NDArray[np.float32] | None,
    ) -> None: ...
    def set_mesh_attribute(self, mesh: int, attribute: int, values: NDArray[np.float32]) -> None: ...
    def set_instance_attribute(
        self, instance: int, attribute: int, value: tuple[float, float, float, float]
    ) -> None: ...
    def report_mesh(self, mesh: int) -> dict[str, int]: ...
    def add_instance(
        self,
        mesh: int,
        world_from_mesh: NDArray[np.float64],
        materials: NDArray[np.int32] | None,
        visibility: int,
        object_index: float,
        one_sided: int,
        color: tuple[float, float, float, float],
        random: float,
        influence: tuple[int, int, int],
        sets: tuple[int, int],
    ) -> int: ...
    def update_instance(self, instance: int, world_from_mesh: NDArray[np.float64]) -> None: ...
    def clear_instances(self) -> None: ...
    def set_spacetimes(self, objects: Sequence[tuple[Spacetime, NDArray[np.float64], float, int]]) -> None: ...
    def commit(self, progress: Progress | None) -> None: ...
    def bidirectional_obstacle(self) -> str | None: ...
    def shows_stars(self) -> bool: ...
    def intersect(
        self,
        origins: NDArray[np.float64],
        directions: NDArray[np.float64],
        sources: NDArray[np.int32] | None,
        tolerance: float,
        angular_tolerance: float,
        length_min: float,
        length_max: float,
        visibility: int,
        progress: Progress | None,
        veils: NDArray[np.uint8] | None,
        fate: NDArray[np.uint8],
        instance: NDArray[np.int32],
        triangle: NDArray[np.int32],
        barycentric: NDArray[np.float64],
        position: NDArray[np.float64],
        direction: NDArray[np.float64],
        length: NDArray[np.float64],
        swept: NDArray[np.float64],
        error: NDArray[np.float64],
        first_lens: NDArray[np.int32],
        borders: NDArray[np.uint32],
        sky: NDArray[np.int32],
        glow: NDArray[np.float64] | None,
        transmission: NDArray[np.float64] | None,
        layers: NDArray[np.uint32] | None,
    ) -> None: ...

class Spacetime:
    @classmethod
    def minkowski(cls) -> Spacetime: ...
    @classmethod
    def schwarzschild(cls, mass: float, chart: str = "isotropic") -> Spacetime: ...
    @classmethod
    def kerr(cls, mass: float, spin: float) -> Spacetime: ...
    @classmethod
    def ellis(cls, throat_radius: float) -> Spacetime: ...
    @property
    def kind(self) -> str: ...
    @property
    def mass(self) -> float: ...
    @property
    def spin(self) -> float: ...
    @property
    def chart(self) -> str: ...
    @property
    def core_radius(self) -> float: ...

def instruction_set() -> str: ...
def contains(spacetime: Spacetime, position: tuple[float, float, float], /) -> bool: ...
def lapse(spacetime: Spacetime, position: tuple[float, float, float], /) -> float: ...
def local_from_covector(
    spacetime: Spacetime, position: tuple[float, float, float], /
) -> tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]: ...
def disk_isco(spin: float, /) -> float: ...
def disk_flux(radius: float, spin: float, /) -> float: ...
def disk_orbit_frequency(radius: float, spin: float, /) -> float: ...
def disk_drawn_radius(radius: float, spin: float, isotropic: bool, /) -> float: ...
def ray_path(
    spacetime: Spacetime,
    origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    tolerance: float,
    mino_times: NDArray[np.float64],
    positions: NDArray[np.float64],
    directions: NDArray[np.float64],
    sides: NDArray[np.uint8],
    /,
) -> None: ...
def trace_rays(
    spacetime: Spacetime,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    tolerance: float,
    route: int,
    fate: NDArray[np.uint8],
    direction: NDArray[np.float64],
    error: NDArray[np.float64],
    steps: NDArray[np.uint32],
    swept: NDArray[np.float64],
    progress: Progress | None,
    /,
) -> None: ...
def connect(
    spacetime: Spacetime,
    points: NDArray[np.float64],
    ends: NDArray[np.float64],
    sky: bool,
    far_side: bool,
    max_images: int,
    min_share: float,
    tolerance: float,
    status: NDArray[np.uint8],
    launch: NDArray[np.float64],
    arrival: NDArray[np.float64],
    spread: NDArray[np.float64],
    frequency_ratio: NDArray[np.float64],
    swept: NDArray[np.float64],
    error: NDArray[np.float64],
    progress: Progress | None,
    /,
) -> tuple[int, int, int, int, int]: ...
def load_embree(paths: list[str]) -> None: ...
def embree_copy() -> tuple[str | None, str | None]: ...
def render_channels() -> list[tuple[str, int, str, str, str]]: ...
def state_width(names: Sequence[str], sizes: tuple[float, int, int, int]) -> int: ...
def state_merge(names: Sequence[str], sizes: tuple[float, int, int, int], state: NDArray, other: NDArray) -> None: ...
def state_develop(
    sizes: tuple[float, int, int, int], height: int, width: int, state: NDArray, channels: dict[str, NDArray]
) -> None: ...
def draw_stars(
    places: NDArray[np.float64],
    light: NDArray[np.float64],
    blur: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint8]] | None,
    width: int,
    height: int,
    filter: str,
    filter_width: float,
    tile: tuple[int, int, int, int],
    pixels: NDArray[np.float32],
) -> None: ...
def sobol_points(pattern: str, seed: int, x: int, y: int, set: int, first: int, out: NDArray[np.float64]) -> None: ...
def filter_offsets(kind: str, width: float, values: NDArray[np.float64]) -> None: ...

class Table:
    @property
    def rows(self) -> int: ...
    def build(self, first: int, last: int, progress: Progress | None = None) -> None: ...
    def measured(self) -> tuple[float, float, float, float]: ...
    def total(self, delta: NDArray[np.float64], angle: NDArray[np.float64]) -> None: ...
    def sweep(
        self,
        radius: NDArray[np.float64],
        cosine: NDArray[np.float64],
        sine: NDArray[np.float64],
        fate: NDArray[np.uint8],
        swept: NDArray[np.float64],
    ) -> None: ...
    def trace(
        self,
        origins: NDArray[np.float64],
        directions: NDArray[np.float64],
        fate: NDArray[np.uint8],
        direction: NDArray[np.float64],
        error: NDArray[np.float64],
        swept: NDArray[np.float64],
    ) -> None: ...

class Sphere:
    def measured(self) -> tuple[float, float, float, float]: ...
    def cross(
        self,
        points: NDArray[np.float64],
        directions: NDArray[np.float64],
        fate: NDArray[np.uint8],
        exit: NDArray[np.float64],
        direction: NDArray[np.float64],
        swept: NDArray[np.float64],
        length: NDArray[np.float64],
        error: NDArray[np.float64],
    ) -> None: ...
    def emerge(
        self,
        points: NDArray[np.float64],
        directions: NDArray[np.float64],
        fate: NDArray[np.uint8],
        exit: NDArray[np.float64],
        direction: NDArray[np.float64],
        swept: NDArray[np.float64],
        length: NDArray[np.float64],
        error: NDArray[np.float64],
    ) -> None: ...

def sphere_new(spacetime: Spacetime, radius: float) -> Sphere: ...
def table_constants() -> tuple[int, float, float]: ...
def table_new(spacetime: Spacetime) -> Table: ...
def table_map(
    name: str,
    x: NDArray[np.float64],
    p: NDArray[np.float64],
    q: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None: ...
