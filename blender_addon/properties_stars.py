"""The user's settings for stars, on worlds."""

import bpy
from bpy.props import EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty


def _tag(self: "BentlightWorldSettings", context: bpy.types.Context) -> None:
    """Blender knows of no change in a setting of ours that a script makes."""
    self.id_data.update_tag()


class BentlightWorldSettings(bpy.types.PropertyGroup):
    """world.bentlight: points of light in the sky."""

    stars: EnumProperty(
        name="Stars",
        description="Points of light in the sky, without size and without noise, magnified by what bends their light",
        items=[
            ("OFF", "Off", "None"),
            ("PROCEDURAL", "Procedural", "As many as wanted, in random places, with the colors of the stars we see"),
            ("CATALOG", "Catalog", "From a text file: right ascension, declination, magnitude, color index B-V"),
        ],
        default="OFF",
        update=_tag,
    )
    star_count: IntProperty(
        name="Count",
        description="How many stars there are in the whole sky, up to 1000000. The naked eye sees 5000",
        min=1,
        max=1_000_000,
        soft_max=50_000,
        default=5000,
        update=_tag,
    )
    star_seed: IntProperty(
        name="Seed",
        description="Another seed, 0 and more, puts the stars in other places",
        min=0,
        default=0,
        update=_tag,
    )
    star_brightest: FloatProperty(
        name="Brightest",
        description=(
            "Magnitude of the brightest star, from -30 to 30; our sky's is -1.5. Five less are a hundred times the "
            "light"
        ),
        min=-30.0,
        max=30.0,
        soft_min=-5.0,
        soft_max=5.0,
        default=-1.0,
        precision=1,
        update=_tag,
    )
    star_slope: FloatProperty(
        name="Faint Ones",
        description=(
            "How the number of stars grows with their magnitude: by a factor of ten to this power for each. 0.6 where "
            "space is evenly filled, about 0.5 in our sky; smaller is brighter"
        ),
        min=0.05,
        max=2.0,
        default=0.5,
        precision=2,
        subtype="FACTOR",
        update=_tag,
    )
    star_catalog: StringProperty(
        name="Catalog",
        description=(
            "Text file with one star a line: right ascension and declination in degrees, magnitude, and, if known, "
            "color index B-V, with commas between them"
        ),
        subtype="FILE_PATH",
        update=_tag,
    )
    star_strength: FloatProperty(
        name="Strength",
        description=(
            "Light of a star of magnitude 0, in millionths of a sun of strength 1, 0 and more. With 100 the stars of a "
            "clear night are seen before a dark gray world"
        ),
        min=0.0,
        soft_max=1000.0,
        default=100.0,
        update=_tag,
    )
    star_rotation: FloatVectorProperty(
        name="Rotation",
        description=(
            "Turns the sky, and so where its stars are seen, by angles about X, Y and Z. Without it, declination "
            "counts from the XY plane and right ascension from X"
        ),
        subtype="EULER",
        size=3,
        update=_tag,
    )
