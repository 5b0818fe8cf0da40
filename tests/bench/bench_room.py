"""The room of make render, timed: with and without its hole, on 1 and 2 threads, and beside Cycles without the hole."""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
from measure import side_by_side

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import common
import room_schwarzschild

RESOLUTION = (320, 180)
SAMPLES = 16


@dataclass(frozen=True)
class RoomTimes:
    """Seconds a picture, and the ratios that the goals are set for."""

    seconds: dict[str, float]

    @property
    def hole_over_flat(self) -> float:
        """What the hole costs, on two threads."""
        return self.seconds["hole, 2 threads"] / self.seconds["flat, 2 threads"]

    @property
    def flat_over_cycles(self) -> float:
        """Bentlight beside Cycles where space is flat, on two threads."""
        return self.seconds["flat, 2 threads"] / self.seconds["Cycles flat, 2 threads"]

    @property
    def speed_up(self) -> float:
        """What the second thread brings, with the hole."""
        return self.seconds["hole, 1 thread"] / self.seconds["hole, 2 threads"]


def render(engine: str, hole: bool, threads: int) -> None:
    """One picture, synchronization with Blender included."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.objects["Black hole"].bentlight.kind = "BLACK_HOLE" if hole else "NONE"
    bpy.ops.render.render()


def measure(runs: int = 3) -> RoomTimes:
    """All renders, taking turns."""
    scene = room_schwarzschild.build()
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.bentlight.samples = scene.cycles.samples = SAMPLES
    for limit in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces"):  # Cycles' own are fewer
        setattr(scene.cycles, limit, scene.bentlight.max_bounces)
    common.log.info("room: %d x %d, %d samples", *RESOLUTION, SAMPLES)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "room.png")
        works = {
            "hole, 1 thread": lambda: render("BENTLIGHT", True, 1),
            "hole, 2 threads": lambda: render("BENTLIGHT", True, 2),
            "flat, 1 thread": lambda: render("BENTLIGHT", False, 1),
            "flat, 2 threads": lambda: render("BENTLIGHT", False, 2),
            "Cycles flat, 2 threads": lambda: render("CYCLES", False, 2),
        }
        return RoomTimes(side_by_side(works, runs))
