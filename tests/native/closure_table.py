"""One of each closure that materials can be made of, for the tests that every one must pass."""

import itertools

from bentlight_native import OPERATIONS
from bsdf_tools import (
    diffuse,
    glass,
    glossy,
    immediates_of,
    metallic,
    principled,
    refraction,
    sheen,
    translucent,
    under_film,
)

# Lobes that scatter into a range of directions.
ROUGH = {
    "diffuse": (diffuse(0.7),),
    "oren_nayar": (diffuse((0.9, 0.5, 0.1), 0.8),),
    "glossy": (glossy((0.9, 0.6, 0.3), 0.5),),
    "glossy_single": (glossy(0.9, 0.4, distribution="GGX"),),
    "metallic_single": (metallic(0.9, 0.7, 0.4, distribution="GGX"),),
    "conductor_single": (metallic((0.2, 1.1, 3.0), (3.9, 2.4, 0.5), 0.4, physical=True, distribution="GGX"),),
    "plastic_single": (principled("GGX", roughness=0.4),),
    "glass": (glass((0.9, 1.0, 0.8), 0.5, 1.5),),
    "glass_single": (glass(1.0, 0.7, 1.33, distribution="GGX"),),
    "refraction": (refraction((0.9, 1.0, 0.8), 0.5, 1.4),),
    "refraction_thin": (refraction(1.0, 0.6, 0.7),),
    "translucent": (translucent((0.9, 0.5, 0.1)),),
    "plastic": (principled(roughness=0.5, base_color=(0.8, 0.3, 0.1)),),
    "metal": (principled(metallic=1.0, roughness=0.6, base_color=(1.0, 0.7, 0.3), specular_tint=(0.5, 0.8, 1.0)),),
    "metallic": (metallic((0.9, 0.6, 0.3), (0.5, 0.8, 1.0), 0.6, anisotropy=0.7, rotation=0.2),),
    "conductor": (metallic((0.2, 1.1, 3.0), (3.9, 2.4, 0.5), 0.5, physical=True),),
    "stretched": (glossy((0.9, 0.6, 0.3), 0.6, anisotropy=0.7, rotation=0.1),),
    "stretched_across": (glossy(0.8, 0.5, anisotropy=-0.6, distribution="GGX"),),
    "stretched_plastic": (principled(roughness=0.6, base_color=(0.8, 0.3, 0.1), anisotropy=0.9, rotation=0.3),),
    "coat": (principled(roughness=0.8, metallic=0.5, coat_weight=0.8, coat_roughness=0.4, coat_tint=(0.9, 0.5, 0.7)),),
    "sheen": (sheen((0.9, 0.5, 0.1), 0.4),),
    "sheen_rough": (sheen(1.0, 1.0),),
    "iridescent": (under_film(principled(roughness=0.4, base_color=0.8), 400.0),),
    "iridescent_glass": (under_film(glass((0.9, 1.0, 0.8), 0.5), 300.0, 1.8),),
    "iridescent_metal": (under_film(metallic(0.9, 0.7, 0.4, distribution="GGX"), 300.0),),
    "beckmann": (glossy((0.9, 0.6, 0.3), 0.6, distribution="BECKMANN"),),
    "beckmann_stretched": (glossy(0.8, 0.6, distribution="BECKMANN", anisotropy=0.6, rotation=0.2),),
    "beckmann_metal": (metallic((0.9, 0.6, 0.3), 0.8, 0.7, distribution="BECKMANN", anisotropy=0.5),),
    "beckmann_conductor": (metallic((0.2, 1.1, 3.0), (3.9, 2.4, 0.5), 0.5, physical=True, distribution="BECKMANN"),),
    "beckmann_glass": (glass((0.9, 1.0, 0.8), 0.5, 1.5, distribution="BECKMANN"),),
    "beckmann_refraction": (refraction((0.9, 1.0, 0.8), 0.5, 1.4, distribution="BECKMANN"),),
    "ashikhmin_shirley": (glossy((0.9, 0.6, 0.3), 0.6, distribution="ASHIKHMIN_SHIRLEY"),),
    "ashikhmin_shirley_stretched": (glossy(0.8, 0.6, distribution="ASHIKHMIN_SHIRLEY", anisotropy=0.5, rotation=0.1),),
    "velvet": (sheen((0.9, 0.5, 0.1), 0.6, distribution="ASHIKHMIN"),),
    "fuzzy": (principled(roughness=0.6, sheen_weight=0.8, sheen_roughness=0.3, coat_weight=0.5, coat_roughness=0.5),),
    "everything": (principled(metallic=0.3, transmission=0.4, diffuse_roughness=0.6, specular_level=0.9),),
    "mixed": (diffuse(0.5, weight=0.3), glossy(1.0, 0.5, weight=0.5), glass(1.0, 0.6, weight=0.2)),
}

# Closures that scatter into single directions, or to elsewhere.
SHARP = {"transparent", "subsurface", "subsurface_layer"}


def closure_choices():
    """(operation, immediates) of all that add lobes, as the core lists them: what is new there is here too."""
    without = {"emission", "holdout", "aov"}
    adding = {name: row for name, row in OPERATIONS.items() if row.outputs == 0 and name not in without}
    choices = {name: [names for names in row.choices if names] for name, row in adding.items()}  # no plain numbers
    return {(name, choice) for name in adding for choice in itertools.product(*choices[name])}


def choices_of(*closures):
    """(operation, immediates) that closures use, their layers included."""
    used = set()
    for operation, _, immediates, _, *layers in closures:
        used.add((operation, immediates_of(immediates)))
        used.update((layer, () if layer == "film" else immediates_of(choice)) for layer, _, choice in layers)
    return used
