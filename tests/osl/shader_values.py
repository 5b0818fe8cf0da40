"""Shader code in tests: whether it compiles, and its values over arrays: one pixel a value, through Cycles, as emission
in a 32-bit EXR."""

import re
import shutil
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
from bentlight_native.exr import write_exr

OSL = Path(__file__).parents[2] / "osl"
_SHADER = """
{includes}
float number(string image, int channel)
{{
  return texture(image, 0.5 + 0.5 * P[0], 0.5 - 0.5 * P[1], 0, 0, 0, 0, "interp", "closest", "firstchannel", channel);
}}
shader probe(string Numbers = "", output closure color BSDF = 0)
{{
  float in[{count}];
  for (int i = 0; i < {count}; i++) in[i] = number(Numbers, i);
  vector out = 0;
  {code}
  BSDF = emission() * color(out[0], out[1], out[2]);
}}
"""


def compiled_functions(folder: Path, header: Path, macro: str) -> int:
    """How many functions, declared by `macro`, a header for two compilers has; asserts that oslc takes each as is."""
    import _cycles  # there once bpy is

    functions = re.findall(rf"{macro} (\w+)\(([^)]*)\)", header.read_text())
    calls = "\n".join(f"  result += {name}({', '.join(['a'] * (args.count(',') + 1))});" for name, args in functions)
    shader = f'#include "{header}"\nshader probe(float a = 0.1, output float result = 0)\n{{\n{calls}\n}}\n'
    (folder / "probe.osl").write_text(shader)
    assert _cycles.osl_compile(str(folder / "probe.osl"), str(folder / "probe.oso"))
    code = (folder / "probe.oso").read_text()
    assert "OpenShadingLanguage" in code and "shader probe" in code
    return len(functions)


def evaluate(folder: Path, includes: list[str], code: str, numbers: np.ndarray) -> np.ndarray:
    """What OSL statements make of rows of numbers: they read in[0], in[1], ... and set the vector `out`.

    numbers: (n, k), rounded to float32; (n, 3) float32 comes back. Headers are those of osl/.
    """
    import _cycles  # there once bpy is

    count, arguments = numbers.shape
    width = max(int(np.ceil(np.sqrt(count))), 4)  # Blender has no smaller pictures
    grid = np.zeros((width * width, arguments), np.float32)
    grid[:count] = numbers
    grid = grid.reshape(width, width, arguments)
    write_exr(folder / "numbers.exr", {f"{i:02}": grid[..., i] for i in range(arguments)}, {})
    shutil.copytree(OSL, folder / "osl", dirs_exist_ok=True)
    lines = "\n".join(f'#include "{name}"' for name in includes)
    source = folder / "osl" / "probe.osl"
    source.write_text(_SHADER.format(includes=lines, count=arguments, code=code))
    assert _cycles.osl_compile(str(source), str(source.with_suffix(".oso")))
    scene = _scene(source.with_suffix(".oso").read_text(), folder / "numbers.exr", width)
    scene.render.filepath = str(folder / "values.exr")
    bpy.ops.render.render(write_still=True)
    channels = OpenEXR.File(str(folder / "values.exr"), separate_channels=True).channels()
    pixels = np.stack([channels[c].pixels for c in "RGB"], axis=-1)
    return pixels.reshape(-1, 3)[:count]


def _scene(code: str, image: Path, width: int) -> bpy.types.Scene:
    """A square in front of a camera without perspective: pixel centers are the image's."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.samples, scene.cycles.filter_width = 1, 0.01
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    scene.render.resolution_x = scene.render.resolution_y = width
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new("Probe")
    if bpy.app.version < (5, 0, 0):  # where they are optional
        material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    node = nodes.new("ShaderNodeScript")
    node.bytecode, node.bytecode_hash = code, str(hash(code))
    node.inputs.new(type="NodeSocketString", name="Numbers", identifier="Numbers").default_value = str(image)
    output = node.outputs.new(type="NodeSocketShader", name="BSDF", identifier="BSDF")
    material.node_tree.links.new(output, nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Square", mesh))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2
    camera.location = (0, 0, 1)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene
