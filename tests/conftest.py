"""What every test run says first: which native module and which Blender it tests."""

import importlib.metadata

import bentlight_native


def pytest_report_header() -> str:
    """The line under pytest's own header."""
    isa = bentlight_native.instruction_set()
    return f"bentlight_native: {bentlight_native.__path__[0]} ({isa}), bpy: {importlib.metadata.version('bpy')}"
