"""What the object's panel says about spheres of influence."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..cycles import radius
from ..sync import left_out, spacetime


def describe_influence(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer, lenses: bool = False) -> str:
    """How far an object bends light, and the bending that this leaves out; with `lenses`, in Cycles.

    Raises RenderError as a render would.
    """
    items = [
        _read(other, lenses) for other in view_layer.objects if other.bentlight.kind != "NONE" and not other.hide_render
    ]
    spacetime.check(items)
    for item, used in zip(items, spacetime.influence_radii(items), strict=True):
        if item.name == obj.name:
            if used == float("inf"):
                return iface_("Not set up for Cycles") if lenses else iface_("Bends light everywhere, exactly")
            within = iface_("Bends light within {:.4g}").format(used)
            missing = left_out.missing_bending(item, used, radius.soft_edge(obj) if lenses else 0.0)
            if missing == float("inf"):
                return f"{within}; {iface_('leaves out rays that would fall in')}"
            return f"{within}; {iface_('leaves out up to {:.2g} rad').format(missing)}"
    return iface_("Not rendered")


def _read(obj: bpy.types.Object, lenses: bool) -> spacetime.SpacetimeData:
    item = spacetime.read_spacetime(obj, obj.matrix_world)
    return radius.with_lens_radius(item, obj) if lenses else item
