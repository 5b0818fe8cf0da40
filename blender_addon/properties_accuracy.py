"""The choice of accuracy: another way to read and to set scene.bentlight.tolerance, which alone is what counts."""

from bpy.props import BoolProperty, EnumProperty

from . import accuracy


def _get(self: "AccuracyProperties") -> int:
    choice = "CUSTOM" if self.accuracy_is_custom else accuracy.choice_of(self.tolerance)
    return accuracy.CHOICES.index(choice)


def _set(self: "AccuracyProperties", number: int) -> None:
    choice = accuracy.CHOICES[number]
    self.accuracy_is_custom = choice == "CUSTOM"
    if not self.accuracy_is_custom:
        self.tolerance = accuracy.TOLERANCES[choice]


class AccuracyProperties:
    """For scene.bentlight."""

    accuracy: EnumProperty(
        name="Accuracy",
        description=(
            "How exactly curved rays are followed. Camera rays are never off by more than a tenth of a pixel; "
            "reflections, shadows and what is seen near a black hole's edge gain by more"
        ),
        items=[
            ("PREVIEW", "Preview", "Directions to 0.001 radians: quickest, for looking around"),
            ("PRODUCTION", "Production", "Directions to 0.0001 radians: for final pictures"),
            ("REFERENCE", "Reference", "Directions to 0.000001 radians: for measurements and comparisons; slower"),
            ("CUSTOM", "Custom", "By a number of your own, in radians"),
        ],
        default=1,
        options=set(),
        get=_get,
        set=_set,
    )
    accuracy_is_custom: BoolProperty(
        name="Custom Accuracy",
        description="The number is shown, even where it is that of one of the choices",
        default=False,
        options={"HIDDEN"},
    )
