"""How much memory this process holds, in MiB, where the operating system says so cheaply."""

from __future__ import annotations

import os
import sys
from pathlib import Path

_MIB = 1 << 20


def used_and_peak() -> tuple[float, float]:
    """Memory in use now and the most so far; zeros where unknown, as on Windows."""
    try:
        import resource  # not on Windows
    except ImportError:
        return 0.0, 0.0
    unit = 1 if sys.platform == "darwin" else 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / _MIB
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except (OSError, ValueError, IndexError):
        return peak, peak
    used = pages * os.sysconf("SC_PAGE_SIZE") / _MIB
    return used, max(used, peak)  # Linux keeps the two books apart and brings the peak's up to date a little later
