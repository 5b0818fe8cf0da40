"""A black hole's mass in nature's units: other ways to read and to set object.bentlight.mass, which alone is stored."""

import bpy
from bpy.props import FloatProperty, StringProperty

from . import scale

_HEAVIEST = 1e30  # suns; what a float32 of kilometers still holds


def meters_per_unit(obj: bpy.types.Object) -> float:
    """Of the object's own units: its scale, and the scene's size of one unit."""
    return obj.matrix_world.col[0].to_3d().length * bpy.context.scene.unit_settings.scale_length


def _get_suns(self: "ScaleProperties") -> float:
    return self.mass * meters_per_unit(self.id_data) / scale.METERS_PER_SUN


def _set_suns(self: "ScaleProperties", suns: float) -> None:
    own = meters_per_unit(self.id_data)
    if own > 0:
        self.mass = suns * scale.METERS_PER_SUN / own


def _get_kilograms(self: "ScaleProperties") -> str:
    return f"{_get_suns(self) * scale.KILOGRAMS_PER_SUN:.6g} kg"


def _set_kilograms(self: "ScaleProperties", text: str) -> None:
    _set_suns(self, scale.parse_suns(text))


def _get_kilometers(self: "ScaleProperties") -> float:
    return _get_suns(self) * scale.METERS_PER_SUN * scale.horizon(self.spin) / 1000


def _set_kilometers(self: "ScaleProperties", kilometers: float) -> None:
    _set_suns(self, kilometers * 1000 / scale.METERS_PER_SUN / scale.horizon(self.spin))


class ScaleProperties:
    """For object.bentlight."""

    mass_suns: FloatProperty(
        name="Solar Masses",
        description=(
            "What the black hole weighs in nature, in suns (1.4766 km of mass each), if a unit of the scene is as long "
            "as Unit Scale says. 5 to 100: the remains of a star; 4.3 million: the hole in the middle of the Milky "
            "Way. Sets the mass"
        ),
        min=0.0,
        max=_HEAVIEST,
        soft_max=1e11,
        precision=6,
        options=set(),
        get=_get_suns,
        set=_set_suns,
    )
    mass_kilograms: StringProperty(
        name="Kilograms",
        description=(
            "What the black hole weighs in nature, in kilograms, as 2e31. Suns can be typed too, as 10 suns. Sets the "
            "mass"
        ),
        options=set(),
        get=_get_kilograms,
        set=_set_kilograms,
    )
    horizon_kilometers: FloatProperty(
        name="Horizon (km)",
        description=(
            "Radius of the horizon in nature, in kilometers: 2.953 for one sun without spin. Its circumference over "
            "2 pi; with spin the radius r of Boyer and Lindquist. Sets the mass"
        ),
        min=0.0,
        max=_HEAVIEST,
        soft_max=1e12,
        precision=6,
        options=set(),
        get=_get_kilometers,
        set=_set_kilometers,
    )
