"""The opening of a camera's lens, for depth of field: parts of the image to rays through places on it. No bpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# The additive recurrence in two dimensions with the least discrepancy (Roberts 2018): powers of the inverse of the
# plastic number, the root of x^3 = x + 1.
_STEPS = np.array([0.7548776662466927, 0.5698402909980532])


@dataclass(frozen=True)
class Aperture:
    """As Cycles has it. radius, focal_distance: scene units. blades: corners of the polygon, below 3 a disk; rotation:
    radians, of the middle of a side; ratio: 2 squeezes the opening to half its width."""

    radius: float
    focal_distance: float
    blades: int = 0
    rotation: float = 0.0
    ratio: float = 1.0

    def sample(self, part: np.ndarray) -> np.ndarray:
        """A place on the opening for each part of the image, (n, 2) whole numbers: (n, 2) in scene units.

        Neighboring parts get places that complement each other, by a lattice over the image: no random numbers."""
        square = np.mod(part[:, :1] * _STEPS + part[:, 1:] * _STEPS[::-1] * np.array([1.0, -1.0]) + 0.5, 1.0)
        places = self._disk(square) if self.blades < 3 else self._polygon(square)
        return self.radius * places * (1.0 / self.ratio, 1.0)

    def _disk(self, square: np.ndarray) -> np.ndarray:
        radius, angle = np.sqrt(square[:, 0]), 2 * np.pi * square[:, 1]
        return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)

    def _polygon(self, square: np.ndarray) -> np.ndarray:
        """Uniform on a regular polygon of circumradius 1: a triangle from the center for each side."""
        side = np.floor(square[:, 0] * self.blades)
        along, outward = square[:, 0] * self.blades - side, np.sqrt(square[:, 1])
        angles = 2 * np.pi / self.blades * (side[:, None] + (-0.5, 0.5)) + self.rotation
        corners = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        return outward[:, None] * (corners[:, 0] * (1 - along)[:, None] + corners[:, 1] * along[:, None])

    def refract(
        self, world_from_camera: np.ndarray, origins: np.ndarray, directions: np.ndarray, lens: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rays through `lens` that meet those through its center in the plane of focus."""
        right, up, forward = world_from_camera[:3, 0], world_from_camera[:3, 1], -world_from_camera[:3, 2]
        offset = lens[:, :1] * right + lens[:, 1:] * up
        toward = directions * (self.focal_distance / (directions @ forward))[:, None] - offset
        return origins + offset, toward / np.linalg.norm(toward, axis=1, keepdims=True)
