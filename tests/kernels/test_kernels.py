"""Kernels are loaded by family, fingerprinted by what was compiled, and given no array that they
cannot use.
"""

import numpy as np
import pytest

from refdem import kernels
from refdem.errors import EngineMissingError


def test_every_c_file_that_is_a_family_is_built() -> None:
    built = {
        path.name.partition(".")[0][1:]
        for path in kernels.Path(kernels.__file__).parent.glob("_*.so")
    }
    assert "recorder" in built
    for family in built:
        assert kernels.load(family).lib is not None


def test_a_family_that_is_not_there_says_what_to_do() -> None:
    with pytest.raises(EngineMissingError, match="make develop"):
        kernels.load("astrology")


def test_fingerprints_tell_families_apart_and_stay() -> None:
    one = kernels.fingerprint("recorder")
    both = kernels.fingerprint("recorder", "rigid_body")
    assert len(one) == len(both) == 64
    assert one != both
    assert one == kernels.fingerprint("recorder")


def test_a_pointer_shares_the_array_it_was_made_from() -> None:
    array = np.arange(3.0)
    kernels.pointer("recorder", array, output=True)[1] = 7.0
    assert array.tolist() == [0.0, 7.0, 2.0]


@pytest.mark.parametrize(
    "array",
    [np.arange(3), np.arange(6.0)[::2], np.zeros((2, 3)).T],
    ids=["integers", "strided", "transposed"],
)
def test_an_array_that_c_would_misread_is_refused(array: np.ndarray) -> None:
    with pytest.raises(TypeError, match="contiguous float64"):
        kernels.pointer("recorder", array)


def test_a_frozen_array_is_refused_as_an_output() -> None:
    array = np.zeros(3)
    array.setflags(write=False)
    kernels.pointer("recorder", array)
    with pytest.raises(TypeError, match="contiguous float64"):
        kernels.pointer("recorder", array, output=True)
