"""How much memory the C heap of this process holds."""

import ctypes


class _Mallinfo2(ctypes.Structure):
    names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in names.split()]


def allocated_bytes() -> int:
    """What is allocated and not freed, as glibc counts it (mallinfo2(3)); unlike resident memory it does not depend on
    what the allocator keeps for later."""
    libc = ctypes.CDLL(None)
    libc.mallinfo2.restype = _Mallinfo2
    info = libc.mallinfo2()
    return info.uordblks + info.hblkhd
