"""What the user is told: errors that stop a render, and warnings that are said once."""

from __future__ import annotations

import logging
from collections.abc import Callable

log = logging.getLogger(__name__)


class RenderError(Exception):
    """A reason why this scene cannot be rendered, in the user's words and naming the object at fault."""


class Reporter:
    """Passes warnings on, each text once.

    `send(level, text)` is Blender's `report` with level in {'INFO', 'WARNING', 'ERROR'}.
    """

    def __init__(self, send: Callable[[set[str], str], None]) -> None:
        self._send = send
        self._said: set[str] = set()

    def warn(self, text: str) -> None:
        """Something is not as the user may expect; the render goes on."""
        if text in self._said:
            return
        self._said.add(text)
        log.warning(text)
        self._send({"WARNING"}, text)

    def error(self, text: str) -> None:
        """The reason why the operator failed."""
        log.error(text)
        self._send({"ERROR"}, text)
