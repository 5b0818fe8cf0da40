"""One thing that a user should know about a scene."""

from typing import NamedTuple


class Finding(NamedTuple):
    """text: translated. owner: what it is about, of the kind 'OBJECT', 'MATERIAL', 'WORLD' or 'SCENE'.

    about: names of other objects whose panels tell it too; node: the material's node.
    """

    text: str
    kind: str
    owner: str
    about: tuple[str, ...] = ()
    node: str = ""
