"""A fingerprint of what a scene shows: equal scenes have the same. No bpy here."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np


def fingerprint(data: Any) -> str:
    """Hexadecimal digest of dataclasses, arrays, dictionaries, sequences and plain values, to the last bit."""
    digest = hashlib.sha256()
    _add(digest, data)
    return digest.hexdigest()


def _add(digest: Any, data: Any) -> None:
    """Adds a value with its type and length, so that different trees never give the same bytes."""
    if isinstance(data, np.ndarray):
        digest.update(f"array {data.dtype.str} {data.shape};".encode())
        digest.update(np.ascontiguousarray(data).data)
    elif dataclasses.is_dataclass(data):
        digest.update(f"{type(data).__name__};".encode())
        for field in dataclasses.fields(data):
            _add(digest, getattr(data, field.name))
    elif isinstance(data, dict):
        digest.update(f"dict {len(data)};".encode())
        for key in sorted(data, key=repr):
            _add(digest, key)
            _add(digest, data[key])
    elif isinstance(data, (list, tuple)):
        digest.update(f"sequence {len(data)};".encode())
        for item in data:
            _add(digest, item)
    else:
        digest.update(f"{type(data).__name__} {data!r};".encode())
