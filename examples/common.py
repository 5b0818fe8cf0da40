"""What every example does around its scene: a clean start, the denoiser, the picture's file, the command line."""

import argparse
import logging
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
from compositor import new_tree
from objects import set_world

ROOT = Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "output"
FORMATS = {".png": ("PNG", "8"), ".exr": ("OPEN_EXR_MULTILAYER", "32")}  # suffix: Blender's name and color depth
log = logging.getLogger("bentlight.examples")


def register() -> None:
    """Registers the add-on from this checkout, unless Blender has it already."""
    if hasattr(bpy.types.Scene, "bentlight"):
        return
    if str(ROOT) not in sys.path:
        sys.path.insert(0, str(ROOT))
    import blender_addon

    blender_addon.register()


def new_scene(
    engine: str = "BENTLIGHT", samples: int = 64, resolution: tuple[int, int] = (640, 360)
) -> bpy.types.Scene:
    """Empties the file and returns its scene, ready to be filled."""
    register()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y = resolution
    scene.render.resolution_percentage = 100
    scene.bentlight.samples = scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = scene.bentlight.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.world = bpy.data.worlds.new("World")
    set_world((0.0, 0.0, 0.0))
    return scene


def add_denoiser(scene: bpy.types.Scene) -> None:
    """Routes the picture through the compositor's Denoise node, guided by the albedo and normal passes."""
    layer = scene.view_layers[0]
    layer.bentlight.use_pass_denoising = layer.cycles.denoising_store_passes = True
    tree, output = new_tree(scene, "Denoise")
    layers = tree.nodes.new("CompositorNodeRLayers")
    denoise = tree.nodes.new("CompositorNodeDenoise")
    tree.links.new(layers.outputs["Image"], denoise.inputs["Image"])
    tree.links.new(layers.outputs["Denoising Albedo"], denoise.inputs["Albedo"])
    tree.links.new(layers.outputs["Denoising Normal"], denoise.inputs["Normal"])
    tree.links.new(denoise.outputs["Image"], output.inputs["Image"])


def render(scene: bpy.types.Scene, path: Path) -> Path:
    """Renders the scene to a .png or .exr file. The file appears only when it is complete."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    scratch = path.with_name(f".{path.stem}.part{path.suffix}")
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE" if path.suffix == ".exr" else "IMAGE"
    settings.file_format, settings.color_depth = FORMATS[path.suffix]
    scene.render.filepath = str(scratch)
    scene.render.use_file_extension = False
    scratch.unlink(missing_ok=True)
    bpy.ops.render.render(write_still=True)
    if not scratch.is_file():
        raise RuntimeError(f"{path}: Blender wrote no picture")
    scratch.replace(path)
    return path


def main(build: Callable[[], bpy.types.Scene], output: str, default_engine: str = "BENTLIGHT") -> None:
    """The command line of one example: build the scene, render it, or only save it as a .blend file."""
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__)
    parser.add_argument("-o", "--output", type=Path, default=OUTPUT / output, help="a .png, .exr or .blend file")
    parser.add_argument("--engine", default=default_engine, choices=["BENTLIGHT", "CYCLES"])
    parser.add_argument("--samples", type=positive, help="light paths a pixel")
    parser.add_argument("--resolution", type=resolution, metavar="WxH")
    parser.add_argument("--no-denoise", action="store_true", help="show the picture as it was traced")
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else None)
    logging.basicConfig(level=logging.INFO, format="%(message)s")

    scene = build()
    scene.render.engine = args.engine
    if args.samples:
        scene.bentlight.samples = scene.cycles.samples = args.samples
    if args.resolution:
        scene.render.resolution_x, scene.render.resolution_y = args.resolution
    if not args.no_denoise:
        add_denoiser(scene)
    if args.output.suffix == ".blend":
        args.output.parent.mkdir(parents=True, exist_ok=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(args.output.resolve()))
    else:
        render(scene, args.output.resolve())
    log.info("%s", args.output)


def positive(text: str) -> int:
    """Reads a whole number from 1."""
    if (number := int(text)) < 1:
        raise ValueError(text)
    return number


def resolution(text: str) -> tuple[int, int]:
    """Reads "640x360"."""
    width, height = (int(part) for part in text.lower().split("x"))
    if width < 1 or height < 1:
        raise ValueError(text)
    return width, height
