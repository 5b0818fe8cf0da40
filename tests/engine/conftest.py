"""Every test of this folder starts from an empty scene."""

from tests.engine.stage import blender  # noqa: F401 (a fixture)
