"""object.bentlight.disk: the accretion disk of a black hole."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty


def _tag(self: "BentlightDiskSettings", context: bpy.types.Context) -> None:
    """Blender knows of no change in a setting of ours."""
    self.id_data.update_tag()


def _make_ramp(self: "BentlightDiskSettings", context: bpy.types.Context) -> None:
    """A color ramp lives in a texture; one that glows from white to red is there from the start."""
    _tag(self, context)
    if self.emission != "RAMP" or self.ramp is not None:
        return
    self.ramp = bpy.data.textures.new("Accretion Disk", "BLEND")
    self.ramp.use_color_ramp = True
    elements = self.ramp.color_ramp.elements
    elements[0].color, elements[1].color = (1.0, 0.93, 0.8, 1.0), (0.25, 0.03, 0.0, 0.0)
    middle = elements.new(0.35)
    middle.color = (1.0, 0.45, 0.12, 1.0)


class BentlightDiskSettings(bpy.types.PropertyGroup):
    """A thin disk in the plane of the hole's equator. Radii are circumferences over 2 pi, in masses of the hole."""

    enable: BoolProperty(
        name="Accretion Disk",
        description=(
            "Matter in orbit around the black hole, in the plane of its equator and with its rotation. It glows, "
            "lights the scene and hides what is behind it"
        ),
        default=False,
        update=_tag,
    )
    inner_edge: EnumProperty(
        name="Inner Edge",
        description="Where the disk ends towards the hole: how wide the dark gap around the shadow is",
        items=[
            ("ISCO", "Last Stable Orbit", "Where orbits cease to be stable: 6 masses without spin, fewer with spin"),
            ("CUSTOM", "Custom", "At a radius of your own. Within the last stable orbit matter falls freely"),
        ],
        default="ISCO",
        update=_tag,
    )
    inner_radius: FloatProperty(
        name="Inner Radius",
        description=(
            "Where the disk ends towards the hole: circumference over 2 pi, in masses of the hole, at least 1. Within "
            "the horizon (2 masses without spin) there is no disk. Smaller narrows the dark gap around the shadow"
        ),
        min=1.0,
        soft_max=20.0,
        default=6.0,
        update=_tag,
    )
    outer_radius: FloatProperty(
        name="Outer Radius",
        description=(
            "Where the disk ends outwards: circumference over 2 pi, in masses of the hole, larger than the inner "
            "radius. From 10, a narrow ring, to 100, a wide plain"
        ),
        min=1.0,
        soft_max=100.0,
        default=20.0,
        update=_tag,
    )
    emission: EnumProperty(
        name="Emission",
        description="What gives the disk its colors and its brightness",
        items=[
            (
                "PAGE_THORNE",
                "Page-Thorne",
                "A blackbody at each radius, as hot as steady accretion makes it (Page & Thorne 1974): dark at the "
                "last stable orbit, hottest a little outside of it",
            ),
            ("POWER_LAW", "Power Law", "A blackbody at each radius, the hotter the nearer to the hole"),
            ("RAMP", "Color Ramp", "A color ramp from the inner to the outer edge"),
            ("IMAGE", "Image", "An image: around the hole from left to right, from the inner edge upwards"),
            (
                "MATERIAL",
                "Material",
                "Your own material. Attribute nodes give it bentlight_radius (in masses), bentlight_azimuth (radians), "
                "bentlight_frequency_ratio, bentlight_doppler, bentlight_gravitational, bentlight_image_order and "
                "bentlight_pattern",
            ),
        ],
        default="PAGE_THORNE",
        update=_make_ramp,
    )
    temperature: FloatProperty(
        name="Temperature",
        description=(
            "Temperature of the hottest place, in kelvin, to who moves with it, from 300 to 1e8. 3000: orange, 6500: "
            "white, 15000 and more: blue. In nature about 1e7 around the remains of a star, 1e5 around the hole of a "
            "galaxy"
        ),
        min=300.0,
        max=1e8,
        soft_min=1000.0,
        soft_max=40000.0,
        default=6500.0,
        step=10000,
        precision=0,
        subtype="TEMPERATURE",
        update=_tag,
    )
    exponent: FloatProperty(
        name="Exponent",
        description=(
            "How fast the temperature falls with the radius: as its power of minus this, from 0 (one color all over) "
            "to 10. 0.75: as steady accretion does far from the hole"
        ),
        min=0.0,
        max=10.0,
        soft_max=3.0,
        default=0.75,
        update=_tag,
    )
    strength: FloatProperty(
        name="Strength",
        description=(
            "Brightness, 0 and more: radiance of a blackbody of the given temperature, as luminance, before its "
            "frequency is shifted; factor of ramps and images"
        ),
        min=0.0,
        soft_max=100.0,
        default=1.0,
        update=_tag,
    )
    ramp: PointerProperty(
        name="Color Ramp",
        description="Colors from the inner edge, left, to the outer one, right; the disk is as transparent as they are",
        type=bpy.types.Texture,
        update=_tag,
    )
    image: PointerProperty(
        name="Image",
        description="Colors of the disk: around the hole from left to right, from the inner edge upwards",
        type=bpy.types.Image,
        update=_tag,
    )
    material: PointerProperty(
        name="Material",
        description="What the disk is made of: it shines and is transparent as the nodes say",
        type=bpy.types.Material,
        update=_tag,
    )
    opacity: FloatProperty(
        name="Opacity",
        description="How much the disk hides of what is behind it, from 0, nothing, to 1. It glows by as much",
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        update=_tag,
    )
    softness: FloatProperty(
        name="Soft Edge",
        description=(
            "The part of the disk's width over which its outer edge fades out: 0 ends it sharply, 1 fades all of it"
        ),
        min=0.0,
        max=1.0,
        default=0.3,
        subtype="FACTOR",
        update=_tag,
    )
    doppler: FloatProperty(
        name="Doppler",
        description=(
            "How much the motion of the disk shifts its light: the side that comes towards you is brighter and bluer. "
            "0: as in films, 1: as in nature"
        ),
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        update=_tag,
    )
    gravitational: FloatProperty(
        name="Gravitational",
        description=(
            "How much gravity shifts the light: darker and redder near the hole. 0: as in films, 1: as in nature"
        ),
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        update=_tag,
    )
    pattern: FloatProperty(
        name="Pattern",
        description="How uneven the disk is: streaks of gas that the orbits shear. 0: smooth, 1: torn",
        min=0.0,
        max=1.0,
        default=0.5,
        subtype="FACTOR",
        update=_tag,
    )
    pattern_scale: FloatProperty(
        name="Scale",
        description="How many streaks lie around the hole, 0.01 and more: more make a finer pattern",
        min=0.01,
        soft_max=20.0,
        default=2.0,
        update=_tag,
    )
    loop_frames: IntProperty(
        name="Loop",
        description="Frames after which the pattern is as it was, 1 and more; in between it never jumps",
        min=1,
        soft_max=1000,
        default=240,
        update=_tag,
    )
    loop_orbits: FloatProperty(
        name="Orbits",
        description=(
            "How often matter at the inner edge goes around in a loop, 0 (at rest) and more. More shear the pattern "
            "more"
        ),
        min=0.0,
        soft_max=20.0,
        default=3.0,
        update=_tag,
    )
