"""The memory of large arrays: glibc gives it back to the system as soon as it is free."""

import ctypes
import sys

M_TRIM_THRESHOLD = -1
M_MMAP_THRESHOLD = -3
"""Parameters of mallopt(3), from <malloc.h>."""
LARGE = 2**24
"""Bytes from which a block is one of its own: a page of a new block costs time, so that it is above
the arrays of most checks.
"""
TOP = 2**24
"""Bytes that stay free at the end of the heap, so that it need not grow again at once."""


def give_back_large_blocks() -> None:
    """Makes each block of LARGE bytes one that the system gets back when it is freed; without
    glibc, nothing.

    By itself glibc puts blocks of up to 32 MB on its heap once it has freed one of that size. Small
    ones that stay among them then hold on to most of the memory of answers that are long dealt
    with: of a campaign with gases of 1e5 spheres, 100 MB.
    """
    if not sys.platform.startswith("linux"):
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(M_MMAP_THRESHOLD, LARGE)
        mallopt(M_TRIM_THRESHOLD, TOP)
