"""How much memory this process holds, in MiB, where the operating system says so cheaply."""

from __future__ import annotations

import sys
from pathlib import Path

_MIB = 1 << 20


def used_and_peak() -> tuple[float, float]:
    """Memory in use now and the most so far; zeros where unknown, as on Windows."""
    if sys.platform == "linux":
        return _of_linux()
    try:
        import resource  # not on Windows
    except ImportError:
        return 0.0, 0.0
    unit = 1 if sys.platform == "darwin" else 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / _MIB
    return peak, peak


def _of_linux() -> tuple[float, float]:
    """From /proc, for getrusage counts as ours what the process that started us had."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
        values = {name: float(value.split()[0]) / 1024 for name, value in _fields(lines) if name in ("VmRSS", "VmHWM")}
        return values["VmRSS"], max(values.values())
    except (OSError, ValueError, LookupError):
        return 0.0, 0.0


def _fields(lines: list[str]) -> list[tuple[str, str]]:
    return [(name, value) for name, _, value in (line.partition(":") for line in lines)]
