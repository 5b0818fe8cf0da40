"""Fewer repetitions under the sanitizers, which look for errors of memory and arithmetic: those need no statistics.

The same tests look for truth with all repetitions, on two versions of Blender.
"""

import os

SANITIZED = "BENTLIGHT_SANITIZED" in os.environ  # set by make test-sanitized


def fewer(count: int) -> int:
    """A quarter under the sanitizers, all otherwise."""
    return max(1, count // 4) if SANITIZED else count
