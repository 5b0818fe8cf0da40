"""What an extension could leave behind in a running Blender and in the user's folder."""

import threading
from pathlib import Path

import bpy

_NAME = "bentlight"
# What Blender itself writes or keeps, whatever is installed: its settings, and the state of its repositories.
_OF_BLENDER = ("config/", "extensions/.cache", "extensions/user_default/.blender_ext", "cache/")


def in_blender() -> set[str]:
    """Classes, properties, handlers, menu entries, preset folders and threads, each by a name.

    Presets that the user has made are the user's: `files` tells of those.
    """
    presets = bpy.utils.user_resource("SCRIPTS", path="presets")
    return {
        *(f"class {name}" for name in dir(bpy.types)),
        *(f"class {cls.__name__}" for cls in _python_classes(bpy.types.bpy_struct)),
        *(f"property {name}" for name in _properties()),
        *(f"handler {name}" for name in _handlers()),
        *(f"entry {name}" for name in _menu_entries()),
        *(f"presets {path}" for path in bpy.utils.preset_paths(_NAME) if not path.startswith(presets)),
        *(f"thread {thread.name}" for thread in threading.enumerate()),
    }


def files() -> set[str]:
    """Files in the user's folder, those left out that are Blender's own; and folders of the extension."""
    user = Path(bpy.utils.resource_path("USER"))
    found = {str(path.relative_to(user)) for path in user.rglob("*") if path.is_file() or _NAME in path.name}
    return {name for name in found if not f"{name}/".startswith(_OF_BLENDER)}


def _python_classes(base: type) -> list[type]:
    """Registered classes of the extension below `base`: only those have their `bl_rna` themselves."""
    below = [cls for sub in base.__subclasses__() for cls in (sub, *_python_classes(sub))]
    return [cls for cls in below if _NAME in cls.__module__ and getattr(cls, "is_registered", False)]


def _properties() -> list[str]:
    """Blender's own types with a property of the extension."""
    types = {name: getattr(getattr(bpy.types, name), "bl_rna", None) for name in dir(bpy.types)}
    names = [(name, item.identifier) for name, rna in types.items() if rna for item in rna.properties]
    return [f"{owner}.{name}" for owner, name in names if _NAME in name]


def _handlers() -> list[str]:
    return [
        f"{event} {function.__module__}.{function.__name__}"
        for event in dir(bpy.app.handlers)
        if isinstance(functions := getattr(bpy.app.handlers, event), list)
        for function in functions
    ]


def _menu_entries() -> list[str]:
    """What is appended to menus, panels and headers."""
    draws = [getattr(getattr(bpy.types, name), "draw", None) for name in dir(bpy.types)]
    functions = [function for draw in draws for function in getattr(draw, "_draw_funcs", ())]
    return [f"{function.__module__}.{function.__name__}" for function in functions]
