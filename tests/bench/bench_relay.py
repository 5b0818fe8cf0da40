"""What the relay camera costs: rays a second, and the most memory that Blender takes, in processes of their own.

Every ray is traced. `make bench` measures some scenes in a quarter of the pixels. In full, each takes minutes:
    .venv/bin/python tests/bench/run.py --relay-full-hd
    .venv/bin/python tests/bench/bench_relay.py kerr --resolution 1920 1080
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESOLUTION, FULL_HD = (960, 540), (1920, 1080)


@dataclass(frozen=True)
class RelayCost:
    """Seconds are of the bake; memory in MiB: before it, and the most so far after it and after the render."""

    rays: int
    seconds: float
    maps: float  # MiB on disk
    before: float
    baked: float
    rendered: float


@dataclass(frozen=True)
class Case:
    """One of SCENES, still or while something in it moves, and whether `make bench` measures it."""

    scene: str
    motion_blur: bool = False
    always: bool = False

    @property
    def name(self) -> str:
        """As the report has it."""
        return self.scene + (", with motion blur" if self.motion_blur else "")


CASES = (
    Case("monkey", always=True),
    Case("monkey", motion_blur=True, always=True),
    Case("disk"),
    Case("disk", motion_blur=True, always=True),
    Case("room"),
    Case("room", motion_blur=True),
    Case("kerr"),
    Case("near"),
)


def measure(case: Case, resolution: tuple[int, int] = RESOLUTION) -> RelayCost:
    """A case with 4 x 4 parts a pixel, rendered by Cycles with one sample."""
    arguments = [sys.executable, __file__, case.scene, *(["--motion-blur"] if case.motion_blur else [])]
    arguments += ["--resolution", *map(str, resolution)]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True, cwd=ROOT)
    return RelayCost(**json.loads(done.stdout.splitlines()[-1]))


def _monkey() -> str:
    """examples/cycles_relay.py."""
    import cycles_relay

    cycles_relay.build()
    return "Suzanne"


def _disk() -> str:
    """examples/gargantua.py, seen from so near that its disk fills the picture."""
    import bpy
    import gargantua

    scene = gargantua.build()
    camera, inclination = scene.camera, math.radians(70)
    camera.location = (0, -20 * math.sin(inclination), 20 * math.cos(inclination))
    camera.rotation_euler = (inclination, 0, 0)
    camera.data.angle = math.radians(80)
    bpy.data.objects["Planet"].location = (4, -6, 3)
    _use_cycles()
    return "Planet"


def _room() -> str:
    """That of `make render`: surfaces everywhere."""
    import room_schwarzschild

    room_schwarzschild.build()
    _use_cycles()
    return "Cube"


def _kerr() -> str:
    """The same around a spinning hole, so near that the ring of compressed images is as high as the picture."""
    import objects
    import room_schwarzschild

    scene = room_schwarzschild.build(spin=0.9)
    scene.camera.location = (0, -15 * room_schwarzschild.MASS, room_schwarzschild.CENTER[2])
    objects.look_at(scene.camera, room_schwarzschild.CENTER)
    _use_cycles()
    return "Cube"


def _near() -> str:
    """The same with a disk, from within it: more of the picture is compressed than finer parts may be."""
    import objects
    import room_schwarzschild

    scene = room_schwarzschild.build(spin=0.9)
    hole = next(obj for obj in scene.objects if obj.bentlight.kind == "BLACK_HOLE")
    hole.bentlight.disk.enable = True
    turn, distance = math.radians(75), 6 * room_schwarzschild.MASS
    x, y, z = room_schwarzschild.CENTER
    scene.camera.location = (x, y - distance * math.sin(turn), z + distance * math.cos(turn))
    objects.look_at(scene.camera, room_schwarzschild.CENTER)
    scene.camera.data.angle = math.radians(100)
    _use_cycles()
    return "Cube"


SCENES: dict[str, Callable[[], str]] = {"monkey": _monkey, "disk": _disk, "room": _room, "kerr": _kerr, "near": _near}


def _use_cycles() -> None:
    import bpy

    bpy.context.scene.render.engine = "CYCLES"
    bpy.ops.bentlight.cycles_setup()
    bpy.ops.bentlight.relay_setup(bake=False)


def _work(name: str, motion_blur: bool, resolution: tuple[int, int], samples: int) -> RelayCost:
    sys.path[:0] = [str(ROOT), str(ROOT / "examples")]
    import bpy

    moving = SCENES[name]()
    scene, moved = bpy.context.scene, bpy.data.objects[moving]
    from blender_addon import memory
    from blender_addon.cycles import relay, render_state

    scene.render.resolution_x, scene.render.resolution_y = resolution
    scene.cycles.samples = samples
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
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", choices=SCENES)
    parser.add_argument("--motion-blur", action="store_true")
    parser.add_argument("--resolution", type=int, nargs=2, default=RESOLUTION)
    parser.add_argument("--samples", type=int, default=1)
    args = parser.parse_args()
    sys.stdout.write(f"\n{json.dumps(asdict(_work(args.scene, args.motion_blur, args.resolution, args.samples)))}\n")
