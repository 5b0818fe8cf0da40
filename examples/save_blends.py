"""Writes scenes of examples as .blend files with thumbnails, for a double click: save_blends.py [NAME...]"""

import argparse
import importlib
import logging
import tempfile
from pathlib import Path

import bpy
import common
import numpy as np
import thumbnail

NAMES = (
    "room_schwarzschild",
    "room_kerr",
    "room_wormhole",
    "lamps",
    "soft_shadow",
    "caustic_glass",
    "gargantua",
    "cycles_lens",
)
SIZE, SAMPLES = (256, 144), 8  # of thumbnails, which are denoised
log = logging.getLogger("bentlight.blends")


def picture(scene: bpy.types.Scene, folder: Path) -> np.ndarray:
    """The scene as a thumbnail: (height, width, 4) uint8, rows upwards. Leaves the scene's settings as they were."""
    render = scene.render
    settings = scene.cycles if render.engine == "CYCLES" else scene.bentlight
    kept = render.resolution_x, render.resolution_y, settings.samples, render.filepath
    render.resolution_x, render.resolution_y = SIZE
    settings.samples = SAMPLES
    image = bpy.data.images.load(str(common.render(scene, folder / "thumbnail.png")))
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    render.resolution_x, render.resolution_y, settings.samples, render.filepath = kept
    return np.rint(255 * pixels.reshape(SIZE[1], SIZE[0], 4)).astype(np.uint8)


def save(name: str, folder: Path) -> Path:
    """Builds the scene of an example and writes it; returns the file."""
    scene = importlib.import_module(name).build()
    common.add_denoiser(scene)
    scene.render.filepath = "//"
    path = folder / f"{name}.blend"
    with tempfile.TemporaryDirectory() as scratch:
        small = picture(scene, Path(scratch))
        plain = Path(scratch) / path.name
        bpy.ops.file.pack_all()
        bpy.data.orphans_purge(do_recursive=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(plain), compress=False)
        thumbnail.embed(plain, small)
        bpy.ops.wm.open_mainfile(filepath=str(plain))  # without a window Blender keeps a file's thumbnail
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, relative_remap=False)
    return path


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", nargs="*", choices=[*NAMES, []], help="default: all of them")
    parser.add_argument("-o", "--output", type=Path, default=common.ROOT / "examples", help="the folder")
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    common.register()
    args.output.mkdir(parents=True, exist_ok=True)
    for name in args.name or NAMES:
        log.info("%s", save(name, args.output.resolve()))


if __name__ == "__main__":
    main()
