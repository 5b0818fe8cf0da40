"""The bridge to Cycles: lenses whose shaders, from osl/, bend Cycles' rays around black holes and wormholes."""

from . import handlers, operators

_MODULES = (operators, handlers)


def register() -> None:
    """Adds the operators, and the handlers that keep lenses as their holes are."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Removes them."""
    for module in reversed(_MODULES):
        module.unregister()
