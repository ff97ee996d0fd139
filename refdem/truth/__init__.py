"""Certified truth: balls with proven radii, in python-flint; independent of solvers and mechanics.

`load` reads the certified values that come with refdem, with the standard library alone.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from refdem.truth.certified.reader import CertifiedSet


def load(case: str = "", *, folder: "Path | str | None" = None) -> "list[CertifiedSet]":
    """The certified sets of one case, or of all; every hash is checked.

    Raises ValueError with the error and its place.
    """
    from refdem.truth.certified import reader

    return reader.load(case, folder=folder)
