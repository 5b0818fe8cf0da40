"""What users can do besides setting properties, and the menus in which they find it."""

from . import add, denoise, find, menus, preset, reset, scale

_MODULES = (add, preset, reset, scale, denoise, find, menus)


def register() -> None:
    """Adds the operators, their presets and their menu entries."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Removes them."""
    for module in reversed(_MODULES):
        module.unregister()
