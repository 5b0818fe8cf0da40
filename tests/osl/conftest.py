"""Scenes of the tests of shaders start empty, with the add-on registered."""

import sys
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).parents[2] / folder) for folder in ("examples", "tests/images")]


@pytest.fixture
def scene():
    """An empty scene for small pictures of pixels that are points, and the view layer's own settings."""
    import common

    made = common.new_scene("CYCLES", samples=1, resolution=(64, 64))
    made.cycles.pixel_filter_type, made.cycles.filter_width = "BOX", 0.01
    made.view_settings.view_transform = "Raw"
    return made
