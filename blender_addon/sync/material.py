"""Blender's materials and world as programs of the core.

    table = MaterialTable(reporter)
    slot = table.index_of(material)          # None: the default gray
    table.set_world(world)                   # None: black
    table.images, table.materials, table.world   # for Scene.add_image(*image), add_material and set_world

Indices are places in those lists, which are those of the native scene if it is filled in order. `compile_material` and
`compile_world` do the work for one datablock and return their warnings.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import bpy
from bentlight_native import Program, ProgramBuilder

from ..report import Reporter, told
from .aovs import compile_aovs
from .attributes import AttributeKey, AttributeTable
from .images import ImageTable, Pixels
from .memory import Memory
from .nodes import colors, inputs, procedural, shaders, textures, values  # noqa: F401  (they register their nodes)
from .nodes.compiler import Compiler

Aovs = Sequence[tuple[str, str]]  # name and type of the passes, as valid_aovs has them
_DEFAULT_NAME = "default_surface"  # by which Cryptomatte knows the material of empty slots, as in Cycles


class Compiled(NamedTuple):
    """A program and what to tell the user about it, each warning naming the material and the node."""

    program: Program
    warnings: list[str]
    wanted: dict[int, AttributeKey]  # attributes that its nodes ask for, by their numbers


def compile_material(
    material: Any, images: ImageTable, attributes: AttributeTable | None = None, aovs: Aovs = ()
) -> Compiled:
    """The surface of a material. Adds the images and attributes that it uses to the tables; raises RenderError if an
    image is missing."""
    compiler = Compiler(told("Material '{}'", material.name), images, bpy.app.version, material.pass_index)
    if attributes is not None:
        compiler.attributes = attributes
    tree = node_tree(material)
    if tree is None:
        _viewport_surface(compiler, material)
    else:
        compile_output(compiler, tree)
        compile_aovs(compiler, tree, aovs)
    return Compiled(compiler.builder.build(compiler.owner), compiler.warnings, compiler.wanted)


def compile_world(world: Any, images: ImageTable, aovs: Aovs = ()) -> Compiled:
    """The background of a world; see compile_material."""
    compiler = Compiler(told("World '{}'", world.name), images, bpy.app.version)
    tree = node_tree(world)
    if tree is None:
        constant = compiler.builder.constant
        compiler.emit("emission", constant(1.0), constant(tuple(world.color)), constant(1.0))
    else:
        compile_output(compiler, tree)
        compile_aovs(compiler, tree, aovs)
    return Compiled(compiler.builder.build(compiler.owner), compiler.warnings, compiler.wanted)


def node_tree(datablock: Any) -> Any:
    """The nodes in use, or None. Up to Blender 4.5 they can be switched off; since 5.0 that switch is deprecated."""
    switch = datablock.bl_rna.properties.get("use_nodes")
    can_be_off = switch is not None and not getattr(switch, "is_deprecated", False)
    return None if can_be_off and not datablock.use_nodes else datablock.node_tree


def compile_output(compiler: Compiler, tree: Any, weight: int | None = None) -> None:
    """What the output node shows, times the operand `weight`; nothing if there is no output."""
    output = tree.get_output_node("CYCLES")
    if output is None:
        return
    for name in ("Volume", "Displacement"):
        socket = output.inputs.get(name)
        if socket is not None and socket.is_linked:
            compiler.warn(output, "'{}' is not supported yet; left out", name)
    compiler.surface(output.inputs["Surface"], weight)


def _viewport_surface(compiler: Compiler, material: Any) -> None:
    """A material without nodes is diffuse in its viewport color."""
    normal = compiler.emit("coordinate", immediates=("SHADING_NORMAL",))
    constant = compiler.builder.constant
    compiler.emit("diffuse", constant(1.0), constant(tuple(material.diffuse_color)[:3]), constant(0.0), normal)


class MaterialTable:
    """The materials, images and world of a scene, each compiled once; warnings go to the reporter."""

    def __init__(self, reporter: Reporter, memory: Memory | None = None, aovs: Aovs = ()) -> None:
        self._reporter = reporter
        self._aovs = aovs
        self._images = ImageTable(memory)
        self._index: dict[str, int] = {}
        self._attributes = AttributeTable()
        self._wanted: dict[int, dict[int, AttributeKey]] = {}
        self.materials: list[Program] = []
        self.labels: list[tuple[str, float]] = []  # name and pass index of each; "": not a material of the user's
        self.world: Program | None = None

    @property
    def image_table(self) -> ImageTable:
        """For compiling what is then added."""
        return self._images

    @property
    def images(self) -> list[Pixels]:
        """What the core needs of each image."""
        return self._images.images

    def index_of(self, material: Any) -> int:
        """The index of a material; -1, the core's default gray, for None. Raises RenderError if an image is missing."""
        if material is None:
            return -1
        key = material.name_full
        if key not in self._index:
            compiled = compile_material(material, self._images, self._attributes, self._aovs)
            self._index[key] = self._add(self.reported(compiled).program, material.name, float(material.pass_index))
            self._wanted[self._index[key]] = compiled.wanted
        return self._index[key]

    def wanted_by(self, indices: Iterable[int]) -> dict[int, AttributeKey]:
        """The attributes that any of these materials asks for, by their numbers in the programs."""
        return {number: key for index in indices for number, key in self._wanted.get(index, {}).items()}

    def add(self, compiled: Compiled) -> int:
        """The index of what was compiled elsewhere: the material of a lamp."""
        return self._add(self.reported(compiled).program)

    def principled(self) -> int:
        """The index of a Principled BSDF as it is when it is new."""
        builder = ProgramBuilder()
        (normal,) = builder.emit("coordinate", immediates=("SHADING_NORMAL",))
        surface = {
            "weight": 1.0, "base color": 0.8, "metallic": 0.0, "roughness": 0.5, "diffuse roughness": 0.0, "ior": 1.5,
            "specular level": 0.5, "specular tint": 1.0, "transmission": 0.0, "alpha": 1.0, "normal": None,
            "emission color": 1.0, "emission strength": 0.0, "anisotropy": 0.0, "rotation": 0.0, "tangent": 0.0,
        }  # fmt: skip
        operands = [normal if value is None else builder.constant(value) for value in surface.values()]
        builder.emit("principled", *operands, immediates=("MULTI_GGX",))
        return self._add(builder.build(), _DEFAULT_NAME)

    def set_world(self, world: Any) -> None:
        """Compiles the world; None is black."""
        self.world = None if world is None else self.reported(compile_world(world, self._images, self._aovs)).program

    def _add(self, program: Program, name: str = "", index: float = 0.0) -> int:
        self.materials.append(program)
        self.labels.append((name, index))
        return len(self.materials) - 1

    def reported(self, compiled: Compiled) -> Compiled:
        """The same, its warnings told to the user."""
        for warning in compiled.warnings:
            self._reporter.warn(warning)
        return compiled


class NoMaterials(MaterialTable):
    """The table of a scene whose surfaces and sky are for another renderer to shade: nothing is compiled but what is
    added, as accretion disks are."""

    def index_of(self, material: Any) -> int:
        """Everything is gray."""
        return -1

    def principled(self) -> int:
        """As all else."""
        return -1

    def set_world(self, world: Any) -> None:
        """The sky stays black."""
