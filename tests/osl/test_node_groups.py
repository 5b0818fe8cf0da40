"""Trees without their groups show in Cycles what the trees with them do."""

import bpy
import numpy as np
import objects
import pytest
import rendering

from blender_addon.cycles import node_copy, node_groups

VALUES = {"Float": 0.25, "Int": 2, "Bool": True, "Vector": (0.1, 0.2, 0.7), "Color": (0.3, 0.5, 0.9, 1)}


def new_group(inputs, outputs):
    """An empty group, its input and its output node; sockets by name, with their kinds."""
    tree = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    for way, sockets in (("INPUT", inputs), ("OUTPUT", outputs)):
        for name, kind in sockets.items():
            tree.interface.new_socket(name, in_out=way, socket_type=f"NodeSocket{kind}")
    return tree, tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")


def use(tree, group, mute=False):
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.mute = group, mute
    return node


def gradients(tree):
    """A color that differs in every direction, and 1.5 of a coordinate."""
    noise, turned = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMath")
    turned.operation, turned.inputs[1].default_value = "MULTIPLY", 1.5
    tree.links.new(noise.outputs["Color"], turned.inputs[0])
    return noise.outputs["Color"], turned.outputs[0]


def background(tree, color):
    shown = tree.nodes.new("ShaderNodeBackground")
    tree.links.new(color, shown.inputs["Color"])
    return shown.outputs[0]


def nested(tree):
    """A group twice in another one, with and without links."""
    inner, given, result = new_group({"a": "Color", "b": "Float"}, {"c": "Color"})
    mixed = inner.nodes.new("ShaderNodeHueSaturation")
    inner.links.new(given.outputs["a"], mixed.inputs["Color"])
    inner.links.new(given.outputs["b"], mixed.inputs["Hue"])
    inner.links.new(mixed.outputs[0], result.inputs["c"])
    outer, given, result = new_group({"a": "Color"}, {"c": "Color", "d": "Shader"})
    first, second = use(outer, inner), use(outer, inner)
    first.inputs["b"].default_value, second.inputs["b"].default_value = 0.7, 0.1
    outer.links.new(given.outputs["a"], first.inputs["a"])
    outer.links.new(first.outputs["c"], second.inputs["a"])
    outer.links.new(second.outputs["c"], result.inputs["c"])
    outer.links.new(background(outer, first.outputs["c"]), result.inputs["d"])
    node, both = use(tree, outer), tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(gradients(tree)[0], node.inputs["a"])
    tree.links.new(node.outputs["d"], both.inputs[0])
    tree.links.new(background(tree, node.outputs["c"]), both.inputs[1])
    return both.outputs[0]


def converted(kind):
    """Colors and numbers by way of sockets of a type, and the value of one that nothing is linked to."""

    def make(tree):
        group, given, result = new_group({"a": kind}, {"b": kind})
        group.links.new(given.outputs["a"], result.inputs["b"])
        shown = background(tree, gradients(tree)[0])
        for source in (*gradients(tree), None):
            node, both = use(tree, group), tree.nodes.new("ShaderNodeAddShader")
            if source:
                tree.links.new(source, node.inputs["a"])
            else:
                node.inputs["a"].default_value = VALUES[kind]
            tree.links.new(background(tree, node.outputs["b"]), both.inputs[0])
            tree.links.new(shown, both.inputs[1])
            shown = both.outputs[0]
        return shown

    return make


def muted(tree):
    """Groups and nodes in them that are switched off, and one without a tree."""
    group, given, result = new_group({"a": "Color", "b": "Vector"}, {"c": "Color", "d": "Float"})
    off = group.nodes.new("ShaderNodeInvert")
    off.mute = True
    group.links.new(given.outputs["a"], off.inputs["Color"])
    group.links.new(off.outputs[0], result.inputs["c"])
    off, on, empty, both = use(tree, group, mute=True), use(tree, group), use(tree, None), new_mix(tree)
    for node in (off, on):
        tree.links.new(gradients(tree)[0], node.inputs["a"])
    tree.links.new(off.outputs["c"], both.inputs[1])
    tree.links.new(on.outputs["c"], both.inputs[2])
    assert empty.node_tree is None
    return background(tree, both.outputs[0])


def new_mix(tree):
    mix = tree.nodes.new("ShaderNodeMixRGB")
    mix.inputs[0].default_value = 0.3
    return mix


def several_outputs(tree):
    """Only the active one of two Group Outputs counts; and what it shows where nothing is linked; textures in a group
    see the direction; that to which a group's free input leads, in Blender 4.5 only."""
    group, given, result = new_group({"at": "Vector"}, {"c": "Color", "d": "Color", "e": "Color"})
    other = group.nodes.new("NodeGroupOutput")
    free, told = group.nodes.new("ShaderNodeTexChecker"), group.nodes.new("ShaderNodeTexChecker")
    group.links.new(given.outputs["at"], told.inputs["Vector"])
    for end, source in ((result, told), (other, free)):
        group.links.new(source.outputs[0], end.inputs["c"])
    group.links.new(free.outputs[0], result.inputs["e"])
    result.inputs["d"].default_value = (0.2, 0.4, 0.8, 1)
    other.is_active_output, result.is_active_output = False, True
    node, first, second = use(tree, group), new_mix(tree), new_mix(tree)
    node.inputs["at"].default_value = (0.03, 0.02, 0.01)
    tree.links.new(node.outputs["c"], first.inputs[1])
    tree.links.new(node.outputs["d"], first.inputs[2])
    tree.links.new(node.outputs["e"], second.inputs[1])
    tree.links.new(first.outputs[0], second.inputs[2])
    return background(tree, second.outputs[0])


def muted_link(tree):
    """A link that is switched off leaves an input its own value."""
    shown = tree.nodes.new("ShaderNodeBackground")
    link = tree.links.new(gradients(tree)[0], shown.inputs["Color"])
    link.is_muted = True
    shown.inputs["Color"].default_value = (0.3, 0.2, 0.1, 1)
    return shown.outputs[0]


def picture(scene, make):
    """What the camera sees of a world: `make(tree)` returns the output that it shows."""
    tree = scene.world.node_tree
    tree.nodes.clear()
    scene.world.cycles.sampling_method = "NONE"
    output = tree.nodes.new("ShaderNodeOutputWorld")
    make(tree, output)
    return rendering.render(scene, "CYCLES", 0, 1)


TREES = {make.__name__: make for make in (nested, muted, several_outputs, muted_link)}
TREES |= {kind: converted(kind) for kind in VALUES}


@pytest.mark.parametrize("make", TREES.values(), ids=TREES)
def test_trees_show_the_same_without_groups(make, scene):
    objects.camera((0, 0, 0), (0, 1, 0.2), lens_mm=12)
    rendering.set_size(scene, 48, 32)
    flat = []

    def made(tree, output):
        tree.links.new(make(tree), output.inputs["Surface"])
        flat.append(node_groups.flattened(scene.world).leading_to((output.name,)))

    def copied(tree, output):
        tree.nodes.remove(output)
        node_copy.build(tree, flat[0])

    with_groups = picture(scene, made)
    without = picture(scene, copied)
    assert not [node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeGroup"]
    assert with_groups.std() > 0.01 or make is muted_link
    np.testing.assert_allclose(without, with_groups, rtol=1e-5, atol=1e-6)
