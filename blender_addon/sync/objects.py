"""The evaluated depsgraph, object by object, as SceneData."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np

from ..properties import check_range
from ..report import RenderError, Reporter, told
from . import disk, light, mesh, spacetime
from .aovs import valid_aovs
from .attributes import OBJECT_KINDS, AttributeKey, read_object_attribute
from .cycles_setting import cycles_setting
from .disk_program import compile_disk
from .hashing import WORD, hash_words
from .light_linking import LightLinking
from .material import MaterialTable, NoMaterials
from .memory import Memory
from .scene_data import CameraData, InstanceData, LampData, MeshData, SceneData, SpacetimeData, Visibility
from .stars import read_stars

_SINGULAR = 5e-7  # of the volume of the box that a matrix's columns could span: less may be rounding of float32
_ZERO_SIZE = "Object '{}' has zero size: none of its faces has an area. To hide an object, disable it in renders"
UNSUPPORTED_TYPES = {"CURVES": "hair", "POINTCLOUD": "point clouds", "VOLUME": "volumes"}
_LAMP_BOUNCES = 1024  # Cycles' default
_STUDIO_FLOOR = "FloorHidden"  # the material by whose name Blender's own engines know it


def read_scene(
    depsgraph: bpy.types.Depsgraph,
    camera: CameraData,
    reporter: Reporter,
    studio: bool = False,
    should_stop: Callable[[], bool] = lambda: False,
    bare: bool = False,
    memory: Memory | None = None,
    is_shown: Callable[[bpy.types.Object], bool] = lambda _: True,
) -> SceneData | None:
    """Everything that the view layer of `depsgraph` shows. Raises RenderError for what cannot be rendered.

    bare: without what surfaces, lamps and the sky look like, which another renderer knows; disks have their material.
    In a studio, where Blender's previews are taken, the floor that hides from the camera is left out: less noise in
    small pictures of a few samples. None once `should_stop`, which is
    asked before each object, says so. `memory`: of an earlier reading of the same depsgraph.
    `is_shown`: of an object, or of the one that instances it, as in the local view of a viewport.
    """
    reader = _SceneReader(depsgraph, camera, reporter, studio, bare, memory or Memory())
    for instance in depsgraph.object_instances:
        if should_stop():
            return None
        if is_shown(instance.parent or instance.object):
            reader.add(instance)
    return reader.finish()


class _SceneReader:
    """Collects SceneData; stores no Blender data beyond one walk over the depsgraph."""

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        camera: CameraData,
        reporter: Reporter,
        studio: bool,
        bare: bool,
        memory: Memory,
    ) -> None:
        memory.begin()
        self._memory = memory
        self._reporter = reporter
        self._studio, self._bare = studio, bare
        self._scene = depsgraph.scene_eval
        self._view_layer = depsgraph.view_layer_eval
        self._data = SceneData(camera=camera, gravitational=self._scene.bentlight.gravitational)
        self._meshes: dict[tuple, int | None] = {}
        aovs = valid_aovs(depsgraph.view_layer_eval)
        self._materials = NoMaterials(reporter) if bare else MaterialTable(reporter, memory, aovs)
        self._without_faces: set[str] = set()
        self._instancers: set[str] = set()
        self._empty_slot: int | None = None
        self._linking = LightLinking(depsgraph.objects, reporter)
        if self._view_layer.use_sky:
            world = self._view_layer_world(depsgraph.scene_eval)
            self._materials.set_world(world)
            self._data.world_group = world.lightgroup if world else ""
            self._data.stars = None if studio or bare else read_stars(world)

    def add(self, instance: bpy.types.DepsgraphObjectInstance) -> None:
        obj = instance.object
        matrix = np.array(instance.matrix_world, dtype=np.float64, order="C")
        if instance.parent:
            self._instancers.add(instance.parent.name)
        if obj.bentlight.kind != "NONE":
            self._add_spacetime(instance, matrix)
        if self._studio and _STUDIO_FLOOR in obj.material_slots:
            return
        if obj.bentlight.made_for_cycles != "NOTHING":
            return  # what Cycles needs
        if not instance.show_self or obj.type not in {"MESH", "LIGHT", *UNSUPPORTED_TYPES}:
            return
        if not np.isfinite(matrix).all():
            raise RenderError("Object '{}': its transform is not finite", obj.name)
        if obj.type == "LIGHT":
            self._add_light(obj, instance.parent, matrix)
        elif obj.type in UNSUPPORTED_TYPES:
            self._reporter.warn("Object '{}': {} cannot be rendered yet", obj.name, told(UNSUPPORTED_TYPES[obj.type]))
        elif self._view_layer.use_solid:
            self._add_geometry(instance, matrix)

    def finish(self) -> SceneData:
        for name in sorted(self._without_faces - self._instancers):
            self._reporter.warn("Object '{}' has no faces, so there is nothing to see of it", name)
        self._data.images = self._materials.images
        self._data.materials = self._materials.materials
        self._data.material_labels = self._materials.labels
        self._data.world = self._materials.world
        self._data.spacetimes = [item for item in self._data.spacetimes if item.kind != "BLACK_HOLE" or item.mass != 0]
        return self._data

    def _view_layer_world(self, scene: bpy.types.Scene) -> bpy.types.World | None:
        return self._view_layer.world_override or scene.world

    def _add_spacetime(self, instance: bpy.types.DepsgraphObjectInstance, matrix: np.ndarray) -> None:
        obj = instance.object
        if instance.is_instance:
            if not _is_scattered(instance):  # the mesh of a curve, which came before as itself
                return
            if obj.bentlight.kind == "WORMHOLE":
                self._reporter.warn("Wormhole '{}': instances of wormholes are not supported; left out", obj.name)
                return
        hole = spacetime.read_spacetime(obj, matrix)
        hole.carrier = _name_of(instance.parent)
        self._data.spacetimes.append(hole)
        if hole.kind == "BLACK_HOLE" and obj.bentlight.disk.enable and instance.show_self:
            self._add_disk(instance, hole)

    def _add_disk(self, instance: bpy.types.DepsgraphObjectInstance, hole: SpacetimeData) -> None:
        obj, settings = instance.object, instance.object.bentlight.disk
        if not (np.isfinite(hole.world_from_spacetime).all() and hole.mass > 0 and abs(hole.spin) < 1):
            return  # the hole is nothing, or refused later
        check_range(settings, type(settings).__annotations__)
        extent = disk.read_extent(settings, hole)
        pattern = disk.read_pattern(settings, extent, self._scene.frame_current_final)
        compiled = compile_disk(f"Black hole '{obj.name}'", settings, extent, pattern, self._materials.image_table)
        receiver_set, blocker_set = self._linking.sets_of(obj)
        self._data.instances.append(
            InstanceData(
                name=obj.name,
                mesh=self._append_mesh(disk.disk_mesh(extent)),
                is_disk=True,
                world_from_mesh=hole.world_from_spacetime,
                materials=(self._materials.add(compiled),),
                visibility=self._visibility(obj, instance.parent),
                object_index=float(obj.pass_index),
                color=tuple(obj.color),
                random=_random_number(instance),
                asset=_asset_name(obj),
                light_group=obj.lightgroup,
                influence=self._linking.influence(obj),
                receiver_set=receiver_set,
                blocker_set=blocker_set,
                carrier=_name_of(instance.parent),
            )
        )

    def _add_geometry(self, instance: bpy.types.DepsgraphObjectInstance, matrix: np.ndarray) -> None:
        obj = instance.object
        if not obj.data.polygons:
            if obj.original.type == "MESH" and obj.bentlight.kind == "NONE":
                self._without_faces.add(obj.name)
            return
        materials = tuple(map(self._material_index, self._slots(obj, list(obj.data.materials))))
        wanted = self._materials.wanted_by(materials)
        index = self._mesh_of(obj, {n: key for n, key in wanted.items() if key.kind not in OBJECT_KINDS})
        if index is None:
            return
        if _is_singular(matrix):
            data = self._data.meshes[index]
            if not mesh.has_area(data, matrix):
                self._refuse_size(instance)
                return
            data, matrix = mesh.flattened(data, matrix)
            index = self._append_mesh(data)
        receiver_set, blocker_set = self._linking.sets_of(obj)
        self._data.instances.append(
            InstanceData(
                name=obj.name,
                mesh=index,
                world_from_mesh=matrix,
                materials=materials,
                visibility=self._visibility(obj, instance.parent),
                object_index=float(obj.pass_index),
                color=tuple(obj.color),
                random=_random_number(instance),
                attributes=self._object_attributes(instance, wanted),
                asset=_asset_name(obj),
                light_group=obj.lightgroup,
                influence=self._linking.influence(obj),
                receiver_set=receiver_set,
                blocker_set=blocker_set,
                carrier=_name_of(instance.parent),
            )
        )

    def _refuse_size(self, instance: bpy.types.DepsgraphObjectInstance) -> None:
        """Of an object's own appearance zero size is a mistake, of one among many that are scattered it is usual."""
        if not _is_scattered(instance):
            raise RenderError(_ZERO_SIZE, instance.object.name)
        self._reporter.warn("Object '{}': instances of zero size are left out", instance.object.name)

    def _material_index(self, material: bpy.types.Material | None) -> int:
        """Index of a material, or of what Cycles makes of an empty slot: gray, since Blender 5 a Principled BSDF."""
        if material is None and bpy.app.version >= (5, 0, 0):
            if self._empty_slot is None:
                self._empty_slot = self._materials.principled()
            return self._empty_slot
        return self._materials.index_of(material)

    def _slots(self, obj: bpy.types.Object, data_materials: list) -> list[bpy.types.Material | None]:
        """Materials by slot: the view layer's override, or the object's where a slot says so, else the data's."""
        count = max(1, len(data_materials))
        if self._view_layer.material_override:
            return [self._view_layer.material_override] * count
        slots = data_materials + [None] * (count - len(data_materials))
        for i, slot in enumerate(obj.material_slots[:count]):
            if slot.link == "OBJECT":
                slots[i] = slot.material
        return slots

    def _object_attributes(
        self, instance: bpy.types.DepsgraphObjectInstance, wanted: dict[int, AttributeKey]
    ) -> dict[int, tuple[float, ...]]:
        return {
            number: read_object_attribute(instance, self._scene, self._view_layer, key)
            for number, key in wanted.items()
            if key.kind in (*OBJECT_KINDS, "COLOR")
        }

    def _mesh_of(self, obj: bpy.types.Object, wanted: dict[int, AttributeKey]) -> int | None:
        """Index of the object's mesh with the wanted attributes, read once for all its users; None if it is empty."""
        key = obj.data.as_pointer(), frozenset(wanted)
        if key not in self._meshes:
            self._meshes[key] = self._read_mesh(obj, wanted)
        return self._meshes[key]

    def _read_mesh(self, obj: bpy.types.Object, wanted: dict[int, AttributeKey]) -> int | None:
        data = self._memory.mesh(obj, wanted, lambda: self._sound_mesh(obj, wanted))
        return None if data is None else self._append_mesh(data)

    def _sound_mesh(self, obj: bpy.types.Object, wanted: dict[int, AttributeKey]) -> MeshData | None:
        """The object's mesh without what cannot be rendered; None if that is all of it."""
        data = mesh.read_mesh(obj, wanted)
        broken = mesh.drop_broken_triangles(data)
        if broken:
            self._reporter.warn(
                "Object '{}': {} triangles have vertices that are not finite or beyond 1e18; left out", obj.name, broken
            )
            if not len(data.triangles):
                return None
        if not mesh.has_area(data):
            raise RenderError(_ZERO_SIZE, obj.name)
        return data

    def _append_mesh(self, data: MeshData) -> int:
        self._data.meshes.append(data)
        return len(self._data.meshes) - 1

    def _add_light(self, obj: bpy.types.Object, parent: bpy.types.Object | None, matrix: np.ndarray) -> None:
        lamp = obj.data
        if not np.isfinite(lamp.energy * 2.0**lamp.exposure):
            raise RenderError("Light '{}': its power is not finite", obj.name)
        # A portal helps Cycles, and is no light.
        is_portal = lamp.type == "AREA" and cycles_setting(lamp, "is_portal", False)
        if lamp.energy == 0 or is_portal:
            return
        if self._bare and (lamp.type == "SUN" or lamp.energy < 0):
            return  # nothing that rays meet
        if lamp.energy < 0:
            self._reporter.warn("Light '{}' has negative power, which is not supported; it gives no light", obj.name)
            return
        visibility = self._visibility(obj, parent) & Visibility.ALL
        max_bounces = cycles_setting(lamp, "max_bounces", _LAMP_BOUNCES)
        influence = self._linking.influence(obj)._replace(max_bounces=max_bounces)
        if not lamp.use_shadow:
            influence = influence._replace(blockers=0)
        if lamp.type == "SUN":
            sun = light.read_sun(lamp, matrix, self._materials)
            sun.name, sun.light_group, sun.carrier = obj.name, obj.lightgroup, _name_of(parent)
            sun.visibility, sun.influence = visibility, influence
            self._data.suns.append(sun)
            return
        axes = light.lamp_axes(lamp, matrix)
        point = light.is_point(lamp)
        shape = None if axes is None or point else light.read_shape(lamp, axes)
        if shape is None and not point:
            self._reporter.warn("Light '{}' has zero size; it is not rendered", obj.name)
            return
        material = -1 if self._bare else light.read_material(lamp, axes, self._materials, self._reporter)
        if point:
            self._data.lamps.append(
                LampData(obj.name, axes, material, visibility, influence, obj.lightgroup, _name_of(parent))
            )
        else:
            self._data.instances.append(
                InstanceData(
                    name=obj.name,
                    mesh=self._append_mesh(shape.mesh),
                    world_from_mesh=axes,
                    materials=(material,),
                    visibility=visibility | Visibility.IMMATERIAL,
                    one_sided=shape.one_sided,
                    light_group=obj.lightgroup,
                    influence=influence,
                    carrier=_name_of(parent),
                )
            )

    def _visibility(self, obj: bpy.types.Object, parent: bpy.types.Object | None) -> int:
        """Visibility bits of an object; an instance is also hidden from what its instancer is hidden from."""
        bits, shadow = Visibility.ALL, 0
        for owner in (obj, parent) if parent else (obj,):
            bits &= (
                Visibility.CAMERA * owner.visible_camera
                | Visibility.DIFFUSE * owner.visible_diffuse
                | Visibility.GLOSSY * owner.visible_glossy
                | Visibility.TRANSMISSION * owner.visible_transmission
            )
            if not owner.visible_shadow:
                shadow = Visibility.SHADOWLESS
        placed = parent or obj  # what is in a collection of the view layer
        if placed.indirect_only_get(view_layer=self._view_layer):
            bits &= ~Visibility.CAMERA
        if obj.is_holdout or placed.holdout_get(view_layer=self._view_layer):
            bits |= Visibility.HOLDOUT
        return bits | shadow


def _is_scattered(instance: bpy.types.DepsgraphObjectInstance) -> bool:
    """Whether another object placed the instance; curves and the like also instance their own mesh."""
    return instance.is_instance and instance.parent.original != instance.object.original


def _name_of(obj: bpy.types.Object | None) -> str:
    return obj.name if obj else ""


def _asset_name(obj: bpy.types.Object) -> str:
    """Of the topmost parent, or the object's own."""
    while obj.parent:
        obj = obj.parent
    return obj.name


def _is_singular(matrix: np.ndarray) -> bool:
    """Whether a (4, 4) matrix flattens space."""
    axes = matrix[:3, :3]
    return abs(np.linalg.det(axes)) <= _SINGULAR * np.prod(np.linalg.norm(axes, axis=0))


def _random_number(instance: bpy.types.DepsgraphObjectInstance) -> float:
    """A number in [0, 1] that is the object's own: of an instance Blender's, else made from the name as by Cycles."""
    if instance.is_instance:
        return (instance.random_id & WORD) / WORD
    word = 0
    for byte in instance.object.name.encode():
        word = (word * 37 + byte) & WORD
    return hash_words(word, 0) / WORD
