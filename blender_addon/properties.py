"""The one declaration of the user's settings, on scenes, objects, worlds and view layers."""

from collections.abc import Iterable

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .properties_accuracy import AccuracyProperties
from .properties_disk import BentlightDiskSettings
from .properties_object import BentlightObjectSettings
from .properties_overlay import BentlightOverlaySettings
from .properties_stars import BentlightWorldSettings
from .report import RenderError


class BentlightSceneSettings(AccuracyProperties, bpy.types.PropertyGroup):
    """scene.bentlight: how to render."""

    integrator: EnumProperty(
        name="Integrator",
        description="How light is followed. Both show the same picture, with more noise or less",
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
        description=(
            "Paths per pixel, 1 and more. 64: grainy, 1000: nearly clean. Four times the samples halve the noise"
        ),
        min=1,
        max=1 << 24,
        soft_max=4096,
        default=128,
    )
    preview_samples: IntProperty(
        name="Viewport Samples",
        description="Paths per pixel in the viewport, which shows what it has so far, 1 and more. 0: it never stops",
        min=0,
        max=1 << 24,
        soft_max=4096,
        default=1024,
    )
    use_adaptive_sampling: BoolProperty(
        name="Noise Threshold",
        description="Take fewer samples where the picture is already clean",
        default=True,
    )
    adaptive_threshold: FloatProperty(
        name="Noise Threshold",
        description=(
            "Noise at which a pixel gets no more samples, measured as in Cycles, from 0.0001 to 1. 0.1: grainy, 0.01: "
            "clean. Smaller is cleaner and slower"
        ),
        min=1e-4,
        max=1.0,
        default=0.01,
        precision=4,
    )
    adaptive_min_samples: IntProperty(
        name="Min Samples",
        description=(
            "Samples that every pixel gets at least, up to 4096: more find small bright things that few would "
            "miss. 0: chosen by the noise threshold"
        ),
        min=0,
        max=4096,
        default=0,
    )
    relay_parts: IntProperty(
        name="Relay Parts",
        description=(
            "Relay camera in Cycles: each pixel is cut into this many parts in each direction, with a curved ray for "
            "every part; where the image is compressed, into three or five times as many, as far as 1.5 GiB of maps "
            "allow. From 1, with jagged edges, to 16"
        ),
        min=1,
        max=16,
        default=4,
    )
    motion_slices: IntProperty(
        name="Slices",
        description=(
            "The time that the shutter is open is cut into this many slices, from 2 to 1024 but not more than there "
            "are samples, and in each the scene stands as it does then. What moves by more pixels shows ghosts. Each "
            "takes time to set up"
        ),
        min=2,
        max=1024,
        soft_max=256,
        default=64,
    )
    relay_slices: IntProperty(
        name="Shutter Slices",
        description=(
            "Relay camera in Cycles, with motion blur: the time that the shutter is open is cut into this many "
            "slices, from 2 to 64, with curved rays for each. All of them together have at least as many rays as a "
            "still picture. Fewer show ghosts of what moves fast"
        ),
        min=2,
        max=64,
        default=4,
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
            "are spread, so that rings have less grain and flicker less. From 1, all pixels take as many, to 64"
        ),
        min=1,
        max=64,
        default=8,
    )
    sky_filter: FloatProperty(
        name="Sky Filter",
        description=(
            "Averages images of the sky around each camera ray, in Cycles stars too, over this part of the distance "
            "between a pixel's rays, however bending stretches it: details smaller than a pixel flicker less. More "
            "samples make it narrower. 0: off"
        ),
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description=(
            "Stop taking samples after this time, in seconds. The picture is whole, with as many samples everywhere "
            "but where the "
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
        description="Another seed, 0 and more, gives another pattern of noise of the same strength",
        min=0,
        default=0,
        options={"ANIMATABLE"},
    )
    tolerance: FloatProperty(
        name="Ray Tolerance",
        description=(
            "Largest error of a ray's direction, in radians, from 1e-12 to 0.1; a tenth of a pixel where that is "
            "smaller. Larger: reflections and shadows near a black hole are a little out of place. Smaller is slower"
        ),
        min=1e-12,
        max=0.1,
        soft_min=1e-8,
        soft_max=0.01,
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
        description=(
            "How often light may be scattered on its way to the camera, from 0, which shows only what shines by "
            "itself, "
            "to 1024. 12 is enough for most rooms"
        ),
        min=0,
        max=1024,
        soft_max=32,
        default=12,
    )
    transparent_bounces: IntProperty(
        name="Transparent",
        description=(
            "How many transparent surfaces a ray may pass straight through, from 0 to 1024; the rest look black"
        ),
        min=0,
        max=1024,
        soft_max=32,
        default=8,
    )
    clamp_direct: FloatProperty(
        name="Clamp Direct",
        description=(
            "Brightest light that a path may bring by its first bounce, as a value of a pixel: less noise, but darker. "
            "10 takes the worst dots away. 0: off"
        ),
        min=0.0,
        soft_max=100.0,
        default=0.0,
    )
    clamp_indirect: FloatProperty(
        name="Clamp Indirect",
        description=(
            "Brightest light that a path may bring after its first bounce, as a value of a pixel: less noise, but "
            "darker. 10 takes the worst dots away. 0: off"
        ),
        min=0.0,
        soft_max=100.0,
        default=0.0,
    )
    blur_glossy: FloatProperty(
        name="Filter Glossy",
        description=(
            "Blurs reflections and refractions that are seen by way of a blurry bounce, as in Cycles: less noise, but "
            "soft caustics. From 0, off, to 10"
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
            "and less time. From 0, all light is followed, to 1"
        ),
        min=0.0,
        max=1.0,
        default=0.01,
        precision=4,
    )
    pixel_filter: EnumProperty(
        name="Pixel Filter",
        description="How the light that falls around a pixel is weighted: how sharp the picture is",
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
    overlay: PointerProperty(
        name="Overlay",
        description="What 3D viewports draw of black holes and wormholes",
        type=BentlightOverlaySettings,
    )


def _passes_changed(self: "BentlightViewLayerSettings", context: bpy.types.Context) -> None:
    if context.view_layer:
        context.view_layer.update_render_passes()


class BentlightViewLayerSettings(bpy.types.PropertyGroup):
    """view_layer.bentlight: the passes that Blender has no switch for."""

    use_pass_error: BoolProperty(
        name="Error",
        description=(
            "Estimated error of the direction of camera rays, in radians: bright where they are hard to follow, pi "
            "where one could not be resolved"
        ),
        default=False,
        update=_passes_changed,
    )
    use_pass_winding: BoolProperty(
        name="Winding",
        description=(
            "How many half turns camera rays make around black holes and wormholes: the more, the nearer to the edge "
            "of the shadow"
        ),
        default=False,
        update=_passes_changed,
    )
    use_pass_fate: BoolProperty(
        name="Fate",
        description="Mask of what each ray sees: 0 unresolved, 1 sky, 2 captured, 3 a wormhole's far sky, 4 a surface",
        default=False,
        update=_passes_changed,
    )
    use_pass_deflection: BoolProperty(
        name="Deflection",
        description=(
            "ST map that bends a flat picture: for each pixel the place, from 0 to 1 from the lower left corner, where "
            "the same camera sees the same thing in flat space; third channel: 1 where there is such a place"
        ),
        default=False,
        update=_passes_changed,
    )
    use_pass_frequency_shift: BoolProperty(
        name="Frequency Shift",
        description="Frequency of light at the camera over that where it was sent out: below 1 redder, above bluer",
        default=False,
        update=_passes_changed,
    )
    use_pass_image_order: BoolProperty(
        name="Image Order",
        description="0 in direct images, 1 in those by way of a hole's other side, and one more for each half turn",
        default=False,
        update=_passes_changed,
    )
    use_pass_disk: BoolProperty(
        name="Disk",
        description="Light of accretion disks alone, as the camera sees them directly",
        default=False,
        update=_passes_changed,
    )
    use_pass_sample_count: BoolProperty(
        name="Sample Count",
        description="Number of samples that each pixel took, 0 and more: high where noise or bending asked for them",
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
    BentlightOverlaySettings,
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
            text = "{} '{}': {} must lie between {:g} and {:g}, not {:g}"
            raise RenderError(text, owner.bl_rna.name, owner.name, item.name, item.hard_min, item.hard_max, value)


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
