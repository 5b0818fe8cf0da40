"""Copies of node trees: every node there is, every setting."""

import contextlib

import bpy
import pytest

from blender_addon.cycles import node_copy

SKIPPED = {"ShaderNodeCustomGroup", "ShaderNodeTree", "ShaderNode"}


def kinds():
    return sorted(
        name
        for name in dir(bpy.types)
        if name.startswith("ShaderNode") and name not in SKIPPED and hasattr(getattr(bpy.types, name), "bl_rna")
    )


def altered(prop, value):
    """Another value that the setting may have."""
    if prop.type == "BOOLEAN" and not prop.is_array:
        return not value
    if prop.type == "ENUM" and not prop.is_enum_flag:
        return next((item.identifier for item in prop.enum_items if item.identifier != value), value)
    if prop.type in {"INT", "FLOAT"} and not prop.is_array:
        return min(max(value + 1, prop.hard_min), prop.hard_max)
    return value


@pytest.mark.parametrize("kind", kinds())
def test_a_node_is_copied_with_its_settings(scene, kind):
    """Its default, and with each of its settings and inputs changed."""
    tree, other = (bpy.data.materials.new(name).node_tree or enable(name) for name in ("from", "to"))
    try:
        node = tree.nodes.new(kind)
    except RuntimeError:
        assert not getattr(bpy.types, kind).is_registered_node_type()
        return
    for prop in node.bl_rna.properties:
        if prop.is_readonly or prop.identifier in {"name", "label", "parent", "mute", "hide", "select"}:
            continue
        with contextlib.suppress(TypeError):  # a choice that this Blender does not offer
            setattr(node, prop.identifier, altered(prop, getattr(node, prop.identifier)))
    for i, socket in enumerate(node.inputs):
        if socket.type == "VALUE":
            socket.default_value = 0.125 * (i + 1)
    other.nodes.clear()
    data = node_copy.describe(tree)
    node_copy.build(other, data)
    assert node_copy.describe(other) == data


def enable(name):
    material = bpy.data.materials[name]
    material.use_nodes = True
    return material.node_tree


def test_ramps_curves_and_links_are_copied(scene):
    tree, other = (bpy.data.materials.new(name).node_tree or enable(name) for name in ("from", "to"))
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.interpolation = "EASE"
    ramp.color_ramp.elements.new(0.3).color = (1, 0.5, 0.25, 0.125)
    curve = tree.nodes.new("ShaderNodeRGBCurve")
    curve.mapping.curves[1].points.new(0.25, 0.75).handle_type = "VECTOR"
    tree.links.new(ramp.outputs["Color"], curve.inputs["Color"])
    other.nodes.clear()
    made = node_copy.build(other, node_copy.describe(tree))
    assert node_copy.describe(other) == node_copy.describe(tree)
    assert made[curve.name].inputs["Color"].links[0].from_node == made[ramp.name]
    for at in (0.0, 0.2, 0.3, 0.6, 1.0):
        assert tuple(made[ramp.name].color_ramp.evaluate(at)) == tuple(ramp.color_ramp.evaluate(at))
        assert made[curve.name].mapping.evaluate(made[curve.name].mapping.curves[1], at) == pytest.approx(
            curve.mapping.evaluate(curve.mapping.curves[1], at), abs=1e-6
        )
