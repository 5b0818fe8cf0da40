"""What the relay camera costs: rays a second, and how much memory its maps take, in a process of their own."""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESOLUTION = (960, 540)
FULL_HD = 1920 * 1080 / (RESOLUTION[0] * RESOLUTION[1])
SCENES = ("monkey", "disk")


@dataclass(frozen=True)
class RelayCost:
    """Seconds are of the bake; memory in MiB: before it, and the most so far after it and after the render."""

    rays: int
    seconds: float
    maps: float  # MiB on disk
    before: float
    baked: float
    rendered: float

    @property
    def in_full_hd(self) -> float:
        """The most memory that a picture of 1920 x 1080 takes, if the maps, which Cycles keeps, grow with the pixels:
        more than is measured (docs/limits.md), as compressed places, around which maps are finer, grow less."""
        return self.rendered + (FULL_HD - 1) * self.maps


def measure(scene: str = "monkey", motion_blur: bool = False) -> RelayCost:
    """A scene with 4 x 4 parts a pixel, rendered by Cycles with one sample; still, or while something in it moves.
    monkey: examples/cycles_relay.py; disk: examples/gargantua.py, seen from so near that its disk fills the picture."""
    arguments = [sys.executable, __file__, scene, *(["--motion-blur"] if motion_blur else [])]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True, cwd=ROOT)
    return RelayCost(**json.loads(done.stdout.splitlines()[-1]))


def _build(name: str):
    """The scene for Cycles, and what moves in it."""
    import bpy

    if name == "monkey":
        import cycles_relay

        return cycles_relay.build(), bpy.data.objects["Suzanne"]
    import gargantua

    scene, camera = gargantua.build(), bpy.context.scene.camera
    inclination = math.radians(70)
    camera.location = (0, -20 * math.sin(inclination), 20 * math.cos(inclination))
    camera.rotation_euler = (inclination, 0, 0)
    camera.data.angle = math.radians(80)
    planet = bpy.data.objects["Planet"]
    planet.location = (4, -6, 3)
    scene.render.engine = "CYCLES"
    bpy.ops.bentlight.cycles_setup()
    bpy.ops.bentlight.relay_setup(bake=False)
    return scene, planet


def _work(name: str, motion_blur: bool, resolution: tuple[int, int]) -> RelayCost:
    sys.path[:0] = [str(ROOT), str(ROOT / "examples")]
    import bpy

    scene, moved = _build(name)
    from blender_addon import memory
    from blender_addon.cycles import relay, render_state

    scene.render.resolution_x, scene.render.resolution_y = resolution
    scene.cycles.samples = 1
    if motion_blur:
        scene.render.use_motion_blur = True
        for frame in range(3):
            moved.location.x += 0.3
            moved.keyframe_insert("location", frame=frame)
        scene.frame_set(1)
    before, _ = memory.used_and_peak()
    with render_state.as_rendered(bpy.context.view_layer) as depsgraph:
        maps = relay.update(scene, depsgraph)
    size = sum(file.stat().st_size for file in maps.files) / (1 << 20)
    _, baked = memory.used_and_peak()
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.png")
        bpy.ops.render.render(write_still=True)
        _, rendered = memory.used_and_peak()
    cost = RelayCost(maps.rays, maps.seconds, size, before, baked, rendered)
    relay.forget_all()
    return cost


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", choices=SCENES)
    parser.add_argument("--motion-blur", action="store_true")
    parser.add_argument("--resolution", type=int, nargs=2, default=RESOLUTION)
    args = parser.parse_args()
    sys.stdout.write(f"\n{json.dumps(asdict(_work(args.scene, args.motion_blur, args.resolution)))}\n")
