"""The header of the accretion disk in OSL: oslc accepts every function as it stands, and Cycles computes what the core
does."""

import re
from pathlib import Path

import numpy as np
import pytest
from bentlight_native import ProgramBuilder, Scene, disk_drawn_radius, disk_flux, disk_isco

HEADER = Path(__file__).parents[2] / "native" / "src" / "scene" / "disk.h"
bpy = pytest.importorskip("bpy")


def compiled(source, folder):
    """The path of a compiled shader."""
    import _cycles

    (folder / "probe.osl").write_text(source)
    assert _cycles.osl_compile(str(folder / "probe.osl"), str(folder / "probe.oso"))
    return folder / "probe.oso"


def test_every_function_compiles(tmp_path):
    functions = re.findall(r"DISK_FUNCTION (disk_\w+)\(([^)]*)\)", HEADER.read_text())
    assert len(functions) >= 20
    calls = "\n".join(f"  result += {name}({', '.join(['a'] * (args.count(',') + 1))});" for name, args in functions)
    path = compiled(
        f'#include "{HEADER}"\nshader probe(float a = 0.1, output float result = 0)\n{{\n{calls}\n}}\n', tmp_path
    )
    assert "shader probe" in path.read_text()


def values_in_cycles(columns, expressions, folder):
    """(n, 3): what Cycles' shader makes of three OSL expressions of named columns (n,), a pixel each."""
    count = len(next(iter(columns.values())))
    arrays = "\n".join(
        f"  float {name}_[{count}] = {{{', '.join(f'{x:.9g}' for x in values)}}};\n  float {name} = {name}_[i];"
        for name, values in columns.items()
    )
    path = compiled(
        f'#include "{HEADER}"\nshader probe(output closure color Result = 0)\n{{\n'
        f"  int i = int(P[0]);\n{arrays}\n  Result = color({', '.join(expressions)}) * emission();\n}}\n",
        folder,
    )
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.cycles.use_adaptive_sampling, scene.cycles.pixel_filter_type = False, "BOX"
    scene.render.resolution_x, scene.render.resolution_y = count, 4
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", count
    camera.location = (count / 2, 2, 1)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.mesh.primitive_plane_add(size=2 * count, location=(count / 2, 2, 0))
    material = bpy.data.materials.new("Probe")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    script, output = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeOutputMaterial")
    script.mode, script.filepath = "EXTERNAL", str(path)
    socket = script.outputs.get("Result") or script.outputs.new("NodeSocketShader", "Result", identifier="Result")
    tree.links.new(socket, output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(folder / "probe.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(folder / "probe.exr"))
    pixels = np.empty(count * 4 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(4, count, 4)[1, :, :3].astype(float)


def shade(operation, columns, immediates=()):
    """(n, outputs) of one of the core's operations on columns (n,) of operands."""
    rows = []
    for values in zip(*columns, strict=True):
        builder = ProgramBuilder()
        outputs = builder.emit(operation, *map(builder.constant, values), immediates=immediates)
        builder.emit("emission", builder.constant(1.0), outputs[0], builder.constant(1.0))
        scene = Scene()
        material = scene.add_material(builder.build())
        rows.append(scene.shade(material, position=(0, 0, 0), wo=(0, 0, 1))["emission"][0, 0])
    return np.array(rows)


def core_shift(spin, r, k_r, k_phi):
    """g at infinity, by the core's operation for disks."""
    builder = ProgramBuilder()
    operands = map(builder.constant, (1.0, spin))
    _radius, _azimuth, doppler, gravitational, _order = builder.emit("disk", *operands, immediates=("OBLATE",))
    builder.emit("emission", builder.constant(1.0), doppler, gravitational)
    scene = Scene()
    material = scene.add_material(builder.build())
    wo = (k_r, k_phi, np.sqrt(1 - k_r**2 - k_phi**2))
    return scene.shade(material, position=(disk_drawn_radius(r, spin, False), 0, 0), wo=wo)["emission"][0, 0]


def test_cycles_computes_what_the_core_does(tmp_path):
    """In single precision: flux to 1e-3 from 1.2 times the radius of the last stable orbit on (temperature to a 4th),
    g to 2e-6, the pattern to 1e-3 (its noise is that of Cycles)."""
    rng, count = np.random.default_rng(5), 60
    a = np.float32(rng.uniform(0, 0.998, count)).astype(float)
    inner = np.array([disk_isco(spin) for spin in a])
    r = np.float32(inner * np.exp(rng.uniform(np.log(1.2), np.log(30), count))).astype(float)
    k = rng.normal(size=(count, 3))
    k_r, k_phi, _ = np.float32(k / np.linalg.norm(k, axis=1, keepdims=True)).astype(float).T
    columns = {"r": r, "a": a, "k_r": k_r, "k_phi": k_phi}
    expressions = ("1e4 * disk_flux(r, a)", "disk_doppler(r, a, k_r, k_phi) * disk_gravitational(r, a, k_phi)",
                   "2 + disk_pattern(r, a, k_phi * 3, 0.3 + k_r, 40, 2)")  # fmt: skip
    seen = values_in_cycles(columns, expressions, tmp_path)
    flux = np.array([disk_flux(x, spin) for x, spin in zip(r, a, strict=True)])
    assert np.abs(seen[:, 0] / (1e4 * flux) - 1).max() < 1e-3
    shift = np.array([core_shift(*row) for row in zip(a, r, k_r, k_phi, strict=True)])
    assert np.abs(seen[:, 1] / shift - 1).max() < 2e-6
    ones = np.ones(count)
    pattern = shade("disk_pattern", (r, 3 * k_phi, a, 0.3 + k_r, 40 * ones, 2 * ones))
    assert np.abs(seen[:, 2] - 2 - pattern).max() < 1e-3
