"""What the user is told: errors that stop a render, and warnings that are said once."""

from __future__ import annotations

from collections.abc import Callable

from bpy.app.translations import pgettext_rpt


def told(text: str, *values: object) -> str:
    """A text in the user's language. It has a place, {}, for each value, such as an object's name: those are the user's
    own, and the text is what translators find."""
    translated = pgettext_rpt(text) if text else text
    return translated.format(*values) if values else translated


class RenderError(Exception):
    """A reason why this scene cannot be rendered, in the user's words and naming the object at fault."""

    def __init__(self, text: str, *values: object) -> None:
        """As `told` takes them."""
        super().__init__(told(text, *values))


class Reporter:
    """Passes warnings on, each text once.

    `send(level, text)` is Blender's `report` with level in {'INFO', 'WARNING', 'ERROR'}. A quiet one keeps warnings.
    """

    def __init__(self, send: Callable[[set[str], str], None], quiet: bool = False) -> None:
        self._send = send
        self._quiet = quiet
        self._said: set[str] = set()

    def warn(self, text: str, *values: object) -> None:
        """Something is not as the user may expect, but the render goes on; as `told` takes it."""
        text = told(text, *values)
        if self._quiet or text in self._said:
            return
        self._said.add(text)
        self._send({"WARNING"}, text)

    def error(self, text: str) -> None:
        """Fails the operator that started the render."""
        self._send({"ERROR"}, text)
