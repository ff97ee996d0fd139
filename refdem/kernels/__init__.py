"""C kernels: one extension a family, loaded when first used; its digest is its fingerprint."""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.errors import EngineMissingError

_repeats = 1
"""Times that a kernel does its work within one reading of the clock: once, but in `repeated`."""


@cache
def load(family: str) -> Any:
    """The extension of that family, with attributes `ffi` and `lib`."""
    try:
        return import_module(f"refdem.kernels._{family}")
    except ModuleNotFoundError:
        raise EngineMissingError(
            f"the kernels {family!r} are not built here; run `make develop`, or install refdem"
            " with pip"
        ) from None


@cache
def fingerprint(*families: str) -> str:
    """sha256 of the compiled families: it changes when their source, compiler or flags do."""
    digest = hashlib.sha256()
    for family in families:
        digest.update(Path(load(family).__file__).read_bytes())
    return digest.hexdigest()


def pointer(family: str, array: NDArray[np.float64], *, output: bool = False) -> Any:
    """A `double *` to a C-contiguous float64 array, which the caller keeps alive.

    `output` asks for a writable one.
    """
    if (
        array.dtype != np.float64
        or not array.flags.c_contiguous
        or (output and not array.flags.writeable)
    ):
        raise TypeError(
            f"kernel {family}: got {array.dtype}, contiguous={array.flags.c_contiguous}; expected"
            " contiguous float64"
        )
    return load(family).ffi.from_buffer("double[]", array, require_writable=output)


def repeats() -> int:
    """How often a call is repeated within one reading of the clock; 1 outside of `repeated`."""
    return _repeats


@contextmanager
def repeated(times: int) -> Iterator[None]:
    """Within this context `timed` makes its call that many times: for runs of microseconds, which
    one reading of the clock does not resolve, with code and data in the cache as in a program's own
    loop.
    """
    global _repeats
    before = _repeats
    _repeats = times
    try:
        yield
    finally:
        _repeats = before


def timed(call: Callable[..., Any], *arguments: Any) -> tuple[float, Any]:
    """Seconds of one call of a kernel's function, without the preparation of its arguments; and
    what it returned.

    The function must return the same when it is called again.
    """
    times = range(_repeats)
    answer = None
    started = perf_counter()
    for _ in times:
        answer = call(*arguments)
    return (perf_counter() - started) / _repeats, answer


def prepared(family: str) -> Any:
    """Memory for what a kernel computes from a start before it computes samples: the
    `refdem_<family>_size` doubles of the family.
    """
    module = load(family)
    return module.ffi.new("double[]", getattr(module.lib, f"refdem_{family}_size")())


def folder() -> Path:
    """Where the compiled families are."""
    return Path(__file__).parent
