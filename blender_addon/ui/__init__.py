"""Bentlight's own panels, one module for each tab of the Properties editor."""

import bpy

from . import camera, cycles, motion_blur, object, overlay, render, simplify, view_layer, warnings, world

CLASSES = (
    *warnings.CLASSES,
    *render.CLASSES,
    *simplify.CLASSES,
    *view_layer.CLASSES,
    *world.CLASSES,
    *object.CLASSES,
    *motion_blur.CLASSES,  # below what a black hole does
    *camera.CLASSES,
    *cycles.CLASSES,
    *overlay.CLASSES,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
