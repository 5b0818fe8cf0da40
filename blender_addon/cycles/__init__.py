"""The bridge to Cycles: lenses and a relay camera, whose shaders, from osl/, bend Cycles' rays."""

from . import handlers, operators, relay_operators

_MODULES = (operators, handlers, relay_operators)


def register() -> None:
    """Adds the operators, and the handlers that keep lenses as their holes are."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Removes them."""
    for module in reversed(_MODULES):
        module.unregister()
