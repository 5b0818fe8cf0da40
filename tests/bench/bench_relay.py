"""What the relay camera costs: rays a second, and how much memory its maps take, in a process of their own."""

import json
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESOLUTION = (960, 540)
FULL_HD = 1920 * 1080 / (RESOLUTION[0] * RESOLUTION[1])


@dataclass(frozen=True)
class RelayCost:
    """Seconds are of the bake; memory in MiB: before it, and the most so far after it and after the render."""

    rays: int
    seconds: float
    maps: float  # MiB on disk
    before: float
    baked: float
    rendered: float

    def in_full_hd(self, memory: float) -> float:
        """Memory in a picture of 1920 x 1080, if all that grew did so with the pixels: more than there is measured."""
        return self.before + FULL_HD * (memory - self.before)


def measure(motion_blur: bool = False) -> RelayCost:
    """The scene of examples/cycles_relay.py, 4 x 4 parts a pixel, rendered by Cycles with one sample; still, or while
    its monkey moves."""
    arguments = [sys.executable, __file__, *(["--motion-blur"] if motion_blur else [])]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True, cwd=ROOT)
    return RelayCost(**json.loads(done.stdout.splitlines()[-1]))


def _work(motion_blur: bool) -> RelayCost:
    sys.path[:0] = [str(ROOT), str(ROOT / "examples")]
    import bpy
    import cycles_relay

    from blender_addon import memory
    from blender_addon.cycles import relay, render_state

    scene = cycles_relay.build()
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.cycles.samples = 1
    if motion_blur:
        scene.render.use_motion_blur = True
        monkey = bpy.data.objects["Suzanne"]
        for frame in range(3):
            monkey.location.x += 0.3
            monkey.keyframe_insert("location", frame=frame)
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
    sys.stdout.write(f"\n{json.dumps(asdict(_work('--motion-blur' in sys.argv)))}\n")
