"""The one declaration of the user's settings, on scenes, objects, worlds and view layers."""

from collections.abc import Iterable

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .properties_disk import BentlightDiskSettings
from .properties_stars import BentlightWorldSettings
from .report import RenderError
from .sync import spacetime


class BentlightSceneSettings(bpy.types.PropertyGroup):
    """scene.bentlight: how to render."""

    integrator: EnumProperty(
        name="Integrator",
        description="How light is simulated",
        items=[
            ("PATH", "Path Tracing", "Follow light backwards from the camera; every leg of a path is curved"),
            (
                "BIDIRECTIONAL",
                "Bidirectional",
                "Follow light from the lamps too, and join both parts by bent rays. Finds the caustics of glass and "
                "metal; takes longer per sample. Suns, the sky and lamps with light linking are followed "
                "from the camera alone; so is all light where a black hole spins, or materials use Light Path",
            ),
        ],
        default="PATH",
    )
    samples: IntProperty(
        name="Samples",
        description="Paths per pixel. Four times the samples halve the noise",
        min=1,
        max=1 << 24,
        soft_max=4096,
        default=128,
    )
    use_adaptive_sampling: BoolProperty(
        name="Noise Threshold",
        description="Take fewer samples where the picture is already clean",
        default=True,
    )
    adaptive_threshold: FloatProperty(
        name="Noise Threshold",
        description="Noise at which a pixel gets no more samples, measured as in Cycles. Smaller is cleaner and slower",
        min=1e-4,
        max=1.0,
        default=0.01,
        precision=4,
    )
    adaptive_min_samples: IntProperty(
        name="Min Samples",
        description="Samples that every pixel gets at least. 0: chosen by the noise threshold",
        min=0,
        max=4096,
        default=0,
    )
    relay_parts: IntProperty(
        name="Relay Parts",
        description=(
            "Relay camera in Cycles: each pixel is cut into this many parts in each direction, with a curved ray for "
            "every part; where the image is compressed, into five times as many"
        ),
        min=1,
        max=16,
        default=4,
    )
    relay_slices: IntProperty(
        name="Shutter Slices",
        description=(
            "Relay camera in Cycles, with motion blur: the time that the shutter is open is cut into this many "
            "slices, with curved rays for each. All of them together have at least as many rays as a still picture"
        ),
        min=2,
        max=64,
        default=8,
    )
    gravitational: FloatProperty(
        name="Gravitational",
        description=(
            "How much gravity shifts light on its way to the camera: what is deep near a black hole is darker, what a "
            "camera there sees outside is brighter. Colors keep their hue; accretion disks have sliders of their own. "
            "0: as in films, 1: as in nature"
        ),
        min=0.0,
        max=1.0,
        default=0.0,
        subtype="FACTOR",
    )
    photon_ring_samples: IntProperty(
        name="Photon Ring Samples",
        description=(
            "Most samples that a pixel takes where others take one. Near the edge of a black hole's shadow, and in a "
            "wormhole's mouth, a pixel sees much of the scene at once: it takes the more samples the farther its rays "
            "are spread. 1: all pixels take as many"
        ),
        min=1,
        max=64,
        default=8,
    )
    sky_filter: FloatProperty(
        name="Sky Filter",
        description=(
            "Averages images of the sky around each camera ray, over this part of the distance between a pixel's rays, "
            "however bending stretches it: details smaller than a pixel flicker less. More samples make it narrower. "
            "0: off"
        ),
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description=(
            "Stop taking samples after this time. The picture is whole, with as many samples everywhere but where the "
            "noise threshold needs fewer. 0: no limit"
        ),
        min=0.0,
        default=0.0,
        step=100,
        subtype="TIME_ABSOLUTE",
        unit="TIME_ABSOLUTE",
    )
    sampling_pattern: EnumProperty(
        name="Pattern",
        description="How the noise of neighboring pixels belongs together",
        items=[
            (
                "BLUE_NOISE",
                "Blue-Noise",
                "The errors of nearby pixels cancel each other: noise is fine-grained and easier to remove, at any "
                "number of samples",
            ),
            ("CLASSIC", "Classic", "The errors of pixels are independent of each other. For comparison"),
        ],
        default="BLUE_NOISE",
    )
    seed: IntProperty(
        name="Seed",
        description="Another seed gives another pattern of noise",
        min=0,
        default=0,
        options={"ANIMATABLE"},
    )
    tolerance: FloatProperty(
        name="Ray Tolerance",
        description=(
            "Largest error of a ray's direction, in radians; a tenth of a pixel where that is smaller. "
            "Smaller is slower"
        ),
        min=1e-12,
        max=0.1,
        default=1e-4,
        precision=6,
        step=0.01,
        subtype="NONE",
    )
    light_sampling: EnumProperty(
        name="Light Sampling",
        description=(
            "How light finds its way from lamps, shining objects and the sky. What is rendered is the same, "
            "with more noise or less"
        ),
        items=[
            (
                "BOTH",
                "Both",
                "Surfaces aim at lights along every bent ray that leads there, and what scattered rays happen to meet "
                "counts too; each where it is better",
            ),
            (
                "SCATTERING",
                "Scattering",
                "Only what scattered rays happen to meet: noisy where lamps are small, and lamps without size give no "
                "light. For comparison",
            ),
            (
                "CONNECTIONS",
                "Connections",
                "Only what surfaces aim at, where such rays are known: noisy in mirrors that are nearly smooth. "
                "For comparison",
            ),
        ],
        default="BOTH",
    )
    portal_sampling: BoolProperty(
        name="Portal Sampling",
        description=(
            "Surfaces send more of their rays through the mouths of wormholes: less noise where the light on the other "
            "side is brighter. The mean of the picture is the same"
        ),
        default=True,
    )
    max_bounces: IntProperty(
        name="Max Bounces",
        description="How often light may be scattered on its way to the camera; 0 shows only what shines by itself",
        min=0,
        max=1024,
        soft_max=32,
        default=12,
    )
    transparent_bounces: IntProperty(
        name="Transparent",
        description="How many transparent surfaces a ray may pass straight through; the rest look black",
        min=0,
        max=1024,
        soft_max=32,
        default=8,
    )
    clamp_direct: FloatProperty(
        name="Clamp Direct",
        description="Brightest light that a path may bring by its first bounce: less noise, but darker. 0: off",
        min=0.0,
        soft_max=100.0,
        default=0.0,
    )
    clamp_indirect: FloatProperty(
        name="Clamp Indirect",
        description="Brightest light that a path may bring after its first bounce: less noise, but darker. 0: off",
        min=0.0,
        soft_max=100.0,
        default=0.0,
    )
    blur_glossy: FloatProperty(
        name="Filter Glossy",
        description=(
            "Blurs reflections and refractions that are seen by way of a blurry bounce, as in Cycles: less noise, but "
            "soft caustics. 0: off"
        ),
        min=0.0,
        max=10.0,
        default=0.0,
    )
    caustics_reflective: BoolProperty(
        name="Reflective Caustics",
        description=(
            "Light that glossy surfaces throw on diffuse ones. Without it the picture is darker and has less noise"
        ),
        default=True,
    )
    caustics_refractive: BoolProperty(
        name="Refractive Caustics",
        description="Light that glass throws on diffuse surfaces. Without it the picture is darker and has less noise",
        default=True,
    )
    light_threshold: FloatProperty(
        name="Light Threshold",
        description=(
            "Light that would bring a pixel less than this is followed by chance only: a little more noise, no bias, "
            "and less time. 0: all light is followed"
        ),
        min=0.0,
        max=1.0,
        default=0.01,
        precision=4,
    )
    pixel_filter: EnumProperty(
        name="Pixel Filter",
        description="How the light that falls around a pixel is weighted",
        items=[
            ("BLACKMAN_HARRIS", "Blackman-Harris", "Smooth and sharp; best for most scenes"),
            ("GAUSSIAN", "Gaussian", "Smoother"),
            ("BOX", "Box", "Exactly the light that falls on the pixel, at width 1"),
        ],
        default="BLACKMAN_HARRIS",
    )
    cycles_before: StringProperty(
        name="Settings Before",
        description="What Use in Cycles has changed in Cycles' settings, old and new",
        options={"HIDDEN"},
    )


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


class BentlightObjectSettings(bpy.types.PropertyGroup):
    """object.bentlight: what an object does to spacetime. Any object may; usually it is an empty."""

    kind: EnumProperty(
        name="Spacetime",
        description="What this object does to space and light around it",
        items=[
            ("NONE", "Flat", "Nothing"),
            ("BLACK_HOLE", "Black Hole", "Bends light around itself and swallows what comes too close"),
            ("WORMHOLE", "Wormhole", "A mouth that leads to another place in the scene"),
        ],
        default="NONE",
        update=_refit,
    )
    mass: FloatProperty(
        name="Mass",
        description=(
            "Size of the black hole, as a length in the object's own units (times its scale). Without spin the horizon "
            "is drawn with half this radius, and seen from afar the shadow has a radius of 5.2 masses"
        ),
        min=0.0,
        soft_max=10.0,
        default=1.0,
        precision=4,
        subtype="DISTANCE",
        update=_refit,
    )
    spin: FloatProperty(
        name="Spin",
        description=(
            "Rotation about the object's local Z axis, as a fraction of the most a black hole can have, from -0.9999 "
            "to 0.9999. Drags light around and makes the shadow lopsided"
        ),
        min=-0.9999,
        max=0.9999,
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
            "with half this radius. Both mouths need the same"
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
        description="The other mouth: what goes in here comes out there, and the other way round",
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
            "which this one bends light; outside all spheres light is straight. 0: half-way to the nearest other one"
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
            "Radius, in the object's own units (times its scale), inside which Cycles bends light. "
            "0: that of the sphere of influence"
        ),
        min=0.0,
        soft_max=100.0,
        default=0.0,
        subtype="DISTANCE",
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


def _passes_changed(self: "BentlightViewLayerSettings", context: bpy.types.Context) -> None:
    if context.view_layer:
        context.view_layer.update_render_passes()


class BentlightViewLayerSettings(bpy.types.PropertyGroup):
    """view_layer.bentlight: the passes that Blender has no switch for."""

    use_pass_error: BoolProperty(
        name="Error",
        description="Estimated error of the direction of camera rays, in radians; pi where a ray could not be resolved",
        default=False,
        update=_passes_changed,
    )
    use_pass_winding: BoolProperty(
        name="Winding",
        description="How many half turns camera rays make around black holes and wormholes",
        default=False,
        update=_passes_changed,
    )
    use_pass_fate: BoolProperty(
        name="Fate",
        description="What becomes of camera rays: 0 unresolved, 1 sky, 2 captured, 3 a wormhole's far sky, 4 a surface",
        default=False,
        update=_passes_changed,
    )
    use_pass_denoising: BoolProperty(
        name="Denoising Data",
        description="Albedo and normal of what camera rays meet, seen through mirrors, for the Denoise compositor node",
        default=False,
        update=_passes_changed,
    )


_CLASSES = (
    BentlightSceneSettings,
    BentlightDiskSettings,
    BentlightObjectSettings,
    BentlightWorldSettings,
    BentlightViewLayerSettings,
)
_OWNERS = (
    (bpy.types.Scene, BentlightSceneSettings),
    (bpy.types.Object, BentlightObjectSettings),
    (bpy.types.World, BentlightWorldSettings),
    (bpy.types.ViewLayer, BentlightViewLayerSettings),
)


def check_range(settings: bpy.types.bpy_struct, names: Iterable[str]) -> None:
    """Raises RenderError for a number outside its property's range: drivers and scripts may set any, NaN too."""
    for name in names:
        item, value, owner = settings.bl_rna.properties[name], getattr(settings, name), settings.id_data
        if item.type in {"INT", "FLOAT"} and not item.hard_min <= value <= item.hard_max:
            span = f"between {item.hard_min:g} and {item.hard_max:g}, not {value:g}"
            raise RenderError(f"{owner.bl_rna.name} '{owner.name}': {item.name} must lie {span}")


def register() -> None:
    """Gives every scene, object, world and view layer its settings."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for owner, settings in _OWNERS:
        owner.bentlight = PointerProperty(type=settings)


def unregister() -> None:
    """Takes them back; what users set stays in their files."""
    for owner, _settings in _OWNERS:
        del owner.bentlight
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
