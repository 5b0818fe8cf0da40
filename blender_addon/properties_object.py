"""object.bentlight: what an object does to spacetime."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty

from .properties_disk import BentlightDiskSettings
from .properties_scale import ScaleProperties
from .sync import spacetime

MASS = 0.2  # of a new black hole: its shadow is as large as the meshes that Blender adds, a ball with a radius of 1.04


def _tag(self: "BentlightObjectSettings", context: bpy.types.Context) -> None:
    """Blender knows of no change in a setting of ours."""
    self.id_data.update_tag()


def _refit(self: "BentlightObjectSettings", context: bpy.types.Context) -> None:
    """An empty is drawn as large as the horizon or throat that it stands for."""
    obj = self.id_data
    _tag(self, context)
    if self.kind == "NONE" or obj.type != "EMPTY":
        return
    radius = spacetime.core_radius(spacetime.read_spacetime(obj, obj.matrix_world))
    obj.empty_display_size = max(radius, 1e-4)


def _is_other_object(self: "BentlightObjectSettings", obj: bpy.types.Object) -> bool:
    return obj != self.id_data


def _link_back(self: "BentlightObjectSettings", context: bpy.types.Context) -> None:
    """The other mouth leads back here: a wormhole has two ends. Ends the recursion when it does already."""
    _tag(self, context)
    other = self.exit
    if other is None or other == self.id_data or other.bentlight.exit == self.id_data:
        return
    other.bentlight.kind = "WORMHOLE"
    other.bentlight.throat_radius = self.throat_radius
    other.bentlight.exit = self.id_data


class BentlightObjectSettings(ScaleProperties, bpy.types.PropertyGroup):
    """object.bentlight: what an object does to spacetime. Any object may; usually it is an empty."""

    kind: EnumProperty(
        name="Spacetime",
        description="What this object does to space and light around it",
        items=[
            ("NONE", "Flat", "Nothing: light goes straight on"),
            (
                "BLACK_HOLE",
                "Black Hole",
                "Bends light around itself and swallows what comes too close: a black disk, ringed by images",
            ),
            ("WORMHOLE", "Wormhole", "A mouth that leads to another place in the scene: a ball in which that is seen"),
        ],
        default="NONE",
        update=_refit,
    )
    mass: FloatProperty(
        name="Mass",
        description=(
            "Size of the black hole, as a length in the object's own units (times its scale), 0 (no hole) and more. "
            "Without spin the horizon is drawn with half this radius, and seen from afar the shadow has a radius of "
            "5.2 masses"
        ),
        min=0.0,
        soft_max=10.0,
        default=MASS,
        precision=4,
        subtype="DISTANCE",
        update=_refit,
    )
    spin: FloatProperty(
        name="Spin",
        description=(
            "Rotation about the object's local Z axis, as a fraction of the most a black hole can have, from -0.9999 "
            "to 0.9999. Drags light around, and makes the shadow lopsided and the disk brighter and closer. 0.7: fast"
        ),
        min=-0.9999,
        max=0.9999,
        soft_min=-0.998,  # what accretion can spin a hole up to: Thorne, Astrophysical Journal 191, 507 (1974)
        soft_max=0.998,
        default=0.0,
        precision=4,
        update=_refit,
    )
    chart: EnumProperty(
        name="Chart",
        description="How curved space is drawn into Blender's flat space. Without spin only",
        items=[
            (
                "ISOTROPIC",
                "Isotropic",
                "Small objects keep their shape. The horizon is drawn at half the mass",
            ),
            (
                "OBLATE",
                "Areal / Oblate",
                "Spheres keep their area. The only one with spin. Horizon at up to twice the mass",
            ),
        ],
        default="ISOTROPIC",
        update=_refit,
    )
    throat_radius: FloatProperty(
        name="Throat Radius",
        description=(
            "Radius of the narrowest sphere inside the wormhole, in the object's own units (times its scale). Drawn "
            "with half this radius; from afar a ball of twice this size, full of what is on the other side. Both "
            "mouths "
            "need the same. 1e-6 and more"
        ),
        min=1e-6,
        soft_max=10.0,
        default=1.0,
        precision=4,
        subtype="DISTANCE",
        update=_refit,
    )
    exit: PointerProperty(
        name="Exit",
        description="The other mouth, whose place is seen in this one: what goes in here comes out there, and back",
        type=bpy.types.Object,
        poll=_is_other_object,
        update=_link_back,
    )
    relay_source: PointerProperty(
        name="Relay of",
        description="The camera whose curved rays this relay camera hands to Cycles",
        type=bpy.types.Object,
    )
    sphere_radius: FloatProperty(
        name="Sphere of Influence",
        description=(
            "With several black holes and wormholes: the radius, in the object's own units (times its scale), inside "
            "which this one bends light; outside all spheres light is straight. Lines seen at the edge "
            "of a small one have a kink. 0: half-way to the nearest other one"
        ),
        min=0.0,
        soft_max=100.0,
        default=0.0,
        subtype="DISTANCE",
        update=_tag,
    )
    lens_radius: FloatProperty(
        name="Lens in Cycles",
        description=(
            "Radius, in the object's own units (times its scale), inside which Cycles bends light, and sees no "
            "meshes. 0: that of the sphere of influence"
        ),
        min=0.0,
        soft_max=100.0,
        default=0.0,
        subtype="DISTANCE",
        update=_tag,
    )
    lens_soft_edge: FloatProperty(
        name="Soft Edge",
        description=(
            "Part of the lens' radius, from 0 to 0.5, over which bending fades toward its edge, so that lines have no "
            "kink there. Lenses that have the radius of the sphere of influence have none, and bend exactly as "
            "Bentlight does"
        ),
        min=0.0,
        max=0.5,
        default=0.4,
        subtype="FACTOR",
        update=_tag,
    )
    lens_is_automatic: BoolProperty(
        name="Automatic Lens",
        description="Use in Cycles has chosen the radius of the lens",
        default=False,
        options={"HIDDEN"},
    )
    made_for_cycles: EnumProperty(
        name="Made for Cycles",
        description="What this object does in Cycles. Bentlight itself does not render it",
        items=[
            ("NOTHING", "Nothing", "An object of the scene"),
            ("LENS", "Lens", "Made by Use in Cycles"),
            ("SCREEN", "Screen", "Made for a relay camera while motion blur is on"),
        ],
        default="NOTHING",
        options={"HIDDEN"},
    )
    relay_switched_osl: BoolProperty(
        name="Switched OSL On",
        description="The relay camera has switched Open Shading Language on, for motion blur",
        default=False,
        options={"HIDDEN"},
    )
    disk: PointerProperty(
        name="Accretion Disk", description="Matter in orbit around a black hole", type=BentlightDiskSettings
    )
