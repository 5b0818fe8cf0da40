"""Cryptomatte: names as numbers, and the manifests by which compositors find them again.

Friedman & Jones, "Fully automatic ID mattes with support for motion blur and transparency" (SIGGRAPH 2015 posters), and
the Cryptomatte specification 1.2.0: MurmurHash3_32 of a name, its bits as a float32 that is neither zero, denormal nor
NaN.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable

_WORD = 0xFFFFFFFF


def _rotated(word: int, bits: int) -> int:
    return (word << bits | word >> (32 - bits)) & _WORD


def _scrambled(block: int) -> int:
    return _rotated(block * 0xCC9E2D51 & _WORD, 15) * 0x1B873593 & _WORD


def murmur_hash(data: bytes) -> int:
    """MurmurHash3 for 32 bits, x86, of seed 0 (Appleby 2011, public domain)."""
    whole = len(data) & ~3
    state = 0
    for (block,) in struct.iter_unpack("<I", data[:whole]):
        state = (_rotated(state ^ _scrambled(block), 13) * 5 + 0xE6546B64) & _WORD
    state ^= _scrambled(int.from_bytes(data[whole:], "little")) if len(data) > whole else 0
    state ^= len(data)
    state = (state ^ state >> 16) * 0x85EBCA6B & _WORD
    state = (state ^ state >> 13) * 0xC2B2AE35 & _WORD
    return state ^ state >> 16


def _bits(name: str) -> int:
    """The hash of a name, with an exponent that makes a usual float."""
    value = murmur_hash(name.encode())
    return value ^ (1 << 23) if (value >> 23 & 255) in (0, 255) else value


def name_as_float(name: str) -> float:
    """The number that stands for a name; 0 for none."""
    return struct.unpack("<f", struct.pack("<I", _bits(name)))[0] if name else 0.0


def metadata(layer: str, names: Iterable[str]) -> dict[str, str]:
    """Fields of a picture's metadata that describe the mattes of a layer, as in "ViewLayer.CryptoObject"."""
    prefix = f"cryptomatte/{murmur_hash(layer.encode()):08x}"[: len("cryptomatte/") + 7]
    manifest = {name: f"{_bits(name):08x}" for name in sorted(set(names)) if name}
    return {
        f"{prefix}/name": layer,
        f"{prefix}/hash": "MurmurHash3_32",
        f"{prefix}/conversion": "uint32_to_float32",
        f"{prefix}/manifest": json.dumps(manifest, ensure_ascii=False, separators=(",", ":")),
    }
