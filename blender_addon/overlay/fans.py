"""Where drawn rays start, and in which directions. No bpy here."""

from __future__ import annotations

import dataclasses

import bentlight_native
import numpy as np

from ..sync.native import set_camera
from ..sync.scene_data import CameraData

Rays = tuple[np.ndarray, np.ndarray]  # (n, 3) world places and local unit directions in world axes


def nearest(places: list[np.ndarray], start: np.ndarray) -> np.ndarray | None:
    """Of the middles of holes and mouths."""
    return min(places, key=lambda place: float(np.linalg.norm(place - start)), default=None)


def camera_fan(camera: CameraData, count: int, target: np.ndarray | None) -> Rays:
    """Across the picture from left to right, at the height at which `target` would be seen without bending."""
    height = 0.5
    if camera.kind in {"PERSPECTIVE", "ORTHOGRAPHIC"} and target is not None:
        _, y, z = np.linalg.solve(camera.world_from_camera, np.append(target, 1.0))[:3]
        low, high = camera.window[2:]
        if z < 0:
            height = float(np.clip(((y if camera.kind == "ORTHOGRAPHIC" else y / -z) - low) / (high - low), 0, 1))
    scene = bentlight_native.Scene()
    set_camera(scene, dataclasses.replace(camera, aperture=None))  # through the middle of the lens
    scene.commit()
    points = np.stack([(np.arange(count) + 0.5) / count, np.full(count, height)], axis=1)
    rays = scene.camera_rays(points)
    seen = np.isfinite(rays.directions).all(axis=1) & (np.linalg.norm(rays.directions, axis=1) > 0)
    return rays.origins[seen], rays.directions[seen]


def star(place: np.ndarray, count: int, target: np.ndarray | None, axis: np.ndarray) -> Rays:
    """All around a place, the first one to `target`, in a plane that is as nearly across `axis` as can be."""
    ahead = np.array([1.0, 0.0, 0.0]) if target is None else np.asarray(target) - place
    length = np.linalg.norm(ahead)
    ahead = ahead / length if length > 0 else np.array([1.0, 0.0, 0.0])
    side = np.cross(axis, ahead)
    if np.linalg.norm(side) < 1e-6:  # the axis leads to the target
        side = np.cross(np.eye(3)[np.argmin(np.abs(ahead))], ahead)
    side /= np.linalg.norm(side)
    angles = np.arange(count)[:, None] * (2 * np.pi / count)
    return np.tile(place, (count, 1)), np.cos(angles) * ahead + np.sin(angles) * side
