"""Shaders compiled for Cycles. Their code is kept inside the .blend, in the script node itself: there are no files to
lose. It is compiled anew where the sources or Blender have another version."""

from __future__ import annotations

import functools
import hashlib
import os
import tempfile
from pathlib import Path
from typing import NamedTuple

import bpy

from ..report import RenderError


class Shader(NamedTuple):
    """What a script node holds."""

    code: str
    key: str  # of the sources and of the compiler


def source_folder() -> Path:
    """osl/: inside the installed extension, or beside the add-on in a checkout."""
    package = Path(__file__).resolve().parents[1]
    return next(folder for folder in (package / "osl", package.parent / "osl") if folder.is_dir())


@functools.cache
def key() -> str:
    """Tells whether shaders were compiled from these sources by this Blender."""
    digest = hashlib.sha256(bpy.app.version_string.encode())
    for path in sorted(source_folder().iterdir()):
        digest.update(path.read_bytes())
    return digest.hexdigest()


@functools.cache
def compiled(name: str) -> Shader:
    """The shader osl/<name>.osl. Raises RenderError where Blender has no compiler."""
    try:
        import _cycles

        compile_file = _cycles.osl_compile
    except (ImportError, AttributeError):
        raise RenderError("This Blender is built without Open Shading Language: Cycles cannot bend light") from None
    handle, path = tempfile.mkstemp(suffix=".oso")
    os.close(handle)
    try:
        if not compile_file(str(source_folder() / f"{name}.osl"), path):
            raise RenderError("The shader {}.osl does not compile; see the console", name)
        return Shader(Path(path).read_text(encoding="utf-8"), f"{name} {key()}")
    finally:
        os.unlink(path)


Socket = tuple[str, object]  # type and value


def digest(shown: object) -> str:
    """Fingerprint of what nodes show, with that of the shaders that do."""
    return hashlib.sha256(repr((shown, key())).encode()).hexdigest()


def new_material(name: str, shader: str, outputs: dict[str, str] | None = None) -> bpy.types.Material:
    """A material that is the shader osl/<shader>.osl; `outputs` as in fill_node."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):  # where they are optional
        material.use_nodes = True
    material.cycles.emission_sampling = "NONE"  # a disk is found by rays that lenses bend
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.location = (-300, 0)
    fill(material, shader, {}, outputs)
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    return material


def fill(
    material: bpy.types.Material, shader: str, inputs: dict[str, Socket], outputs: dict[str, str] | None = None
) -> None:
    """Gives a material of new_material its parameters, and the shader if it has another version."""
    node = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeScript")
    fill_node(node, compiled(shader), inputs, outputs)


def new_node(
    tree: bpy.types.NodeTree, shader: str, inputs: dict[str, Socket], outputs: dict[str, str] | None = None
) -> bpy.types.ShaderNodeScript:
    """A script node that is the shader osl/<shader>.osl; `inputs`, `outputs` as in fill_node."""
    node = tree.nodes.new("ShaderNodeScript")
    fill_node(node, compiled(shader), inputs, outputs)
    return node


def remove(obj: bpy.types.Object) -> None:
    """An object with its mesh and its materials."""
    mesh, materials = obj.data, list(obj.data.materials)
    bpy.data.objects.remove(obj)
    bpy.data.meshes.remove(mesh)
    for material in filter(None, materials):
        bpy.data.materials.remove(material)


def fill_node(
    node: bpy.types.ShaderNodeScript, shader: Shader, inputs: dict[str, Socket], outputs: dict[str, str] | None = None
) -> None:
    """Gives a script node its code and its sockets, without the module that Blender's own button needs for that, and
    which Blender as a Python module lacks. Writes only what is different. A value of `None` leaves an input as it is;
    `outputs`: names and types of those besides BSDF."""
    if node.bytecode_hash != shader.key:
        node.bytecode, node.bytecode_hash = shader.code, shader.key
    for name, (kind, value) in inputs.items():
        socket = node.inputs.get(name) or node.inputs.new(type=kind, name=name, identifier=name)
        if value is None:
            continue
        now = tuple(socket.default_value) if kind == "NodeSocketVector" else socket.default_value
        if now != value:
            socket.default_value = value
    for name, kind in {"BSDF": "NodeSocketShader", **(outputs or {})}.items():
        if name not in node.outputs:
            node.outputs.new(type=kind, name=name, identifier=name)
