"""A camera that goes around the origin, frame by frame, and looks at it."""

from dataclasses import dataclass

import bentlight_native
import numpy as np


@dataclass(frozen=True)
class Orbit:
    """distance: from the origin. height: over the plane z = 0, as a part of the distance in it. step: radians a frame.
    slope: of the highest rays of the picture."""

    distance: float
    height: float
    step: float
    slope: float

    def place_camera(self, scene: bentlight_native.Scene, frame: int, aspect: float) -> None:
        """Puts the camera where it is in that frame, and commits. aspect: width over height."""
        back = np.array([np.cos(frame * self.step), np.sin(frame * self.step), self.height])
        back /= np.linalg.norm(back)
        right = np.cross((0, 0, 1), back)
        right /= np.linalg.norm(right)
        camera = np.eye(4)
        camera[:3] = np.stack([right, np.cross(back, right), back, self.distance * back], axis=1)
        wide = self.slope * aspect
        scene.set_camera("PERSPECTIVE", camera, (-wide, wide, -self.slope, self.slope))
        scene.commit()
