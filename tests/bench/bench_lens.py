"""What a lens costs Cycles: the room of make render with and without it, and what is made before."""

import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import bentlight_native
import bpy
from measure import side_by_side

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import common
import room_schwarzschild

WITHOUT = {"own shading": "no lens", "OSL": "no lens, OSL"}  # Cycles' own shading is what artists begin from
RESOLUTION = (240, 135)
SAMPLES = 16


@dataclass(frozen=True)
class LensTimes:
    """Seconds a picture, and to make the tables of a kind of space."""

    seconds: dict[str, float]
    bake: float

    def ratio(self, name: str, without: str) -> float:
        """A lens, which is in Open Shading Language, over no lens by one of WITHOUT."""
        return self.seconds[name] / self.seconds[WITHOUT[without]]


def render(lens: bool, spin: float = 0.0, osl: bool = True) -> None:
    """One picture by Cycles, its own preparation included."""
    scene = bpy.context.scene
    hole = scene.objects["Black hole"]
    hole.hide_render, hole.bentlight.spin = not lens, spin
    scene.cycles.shading_system = osl
    bpy.context.view_layer.update()
    bpy.ops.render.render()


def measure(runs: int = 3) -> LensTimes:
    """All renders, taking turns."""
    start = time.perf_counter()
    table = bentlight_native.DeflectionTable(bentlight_native.Spacetime.schwarzschild(1.0))
    bentlight_native.SampledTable.from_table(table)
    bake = time.perf_counter() - start
    scene = room_schwarzschild.build()
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.cycles.samples = SAMPLES
    bpy.ops.bentlight.cycles_setup()
    common.log.info("lens: %d x %d, %d samples", *RESOLUTION, SAMPLES)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "room.png")
        works = {
            "no lens": lambda: render(False, osl=False),
            "no lens, OSL": lambda: render(False),
            "lens": lambda: render(True),
            "lens, spin 0.9": lambda: render(True, 0.9),
        }
        return LensTimes(side_by_side(works, runs), bake)
