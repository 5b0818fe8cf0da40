"""scene.bentlight.overlay: what 3D viewports draw of spacetime over any shading."""

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty


class BentlightOverlaySettings(bpy.types.PropertyGroup):
    """In the popover of the viewport's overlays."""

    show_circles: BoolProperty(
        name="Horizons and Orbits",
        description=(
            "Thin lines around black holes and wormholes: horizon, photon sphere (with spin the orbits of light around "
            "the equator), last stable orbit, edges of the disk, throat. As large as they are drawn in the scene; "
            "what a camera sees of them is larger, as light is bent"
        ),
        default=True,
    )
    show_labels: BoolProperty(
        name="Names", description="The name of each line, drawn beside it where it is large enough", default=True
    )
    rays: EnumProperty(
        name="Rays",
        description="Curved rays of light as thin lines, followed as a render follows them until they meet a surface",
        items=[
            ("OFF", "Off", "None"),
            ("CAMERA", "Camera", "From the scene's camera, side by side, at the height of the nearest hole or mouth"),
            ("CURSOR", "3D Cursor", "From the 3D cursor in all directions, in a plane with the nearest hole or mouth"),
        ],
        default="OFF",
    )
    ray_count: IntProperty(
        name="Count",
        description="How many rays are drawn, from 1 to 256. More take longer whenever something changes",
        min=1,
        max=256,
        soft_max=64,
        default=15,
    )
