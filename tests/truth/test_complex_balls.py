"""Complex numbers and matrices as pairs of balls, against those of python-flint, and their
derivatives against differences.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction

import pytest
from flint import acb, acb_mat, arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.complex_balls import Complex, ComplexMatrix
from refdem.truth.dual import parameters, slopes_of

PLACE = [Fraction(3, 7), Fraction(-5, 4), Fraction(2), Fraction(1, 3)]
STEP = Fraction(1, 2**60)
FORMULAS = {
    "sum": lambda z, w: z + w - -z,
    "product": lambda z, w: z * w * z,
    "conjugate": lambda z, w: z.conjugate() * w,
}


def pairs(numbers: Sequence[arb]) -> tuple[Complex, Complex]:
    """Two complex numbers of four real ones."""
    a, b, c, d = numbers
    return Complex(a, b), Complex(c, d)


@pytest.mark.parametrize("name", FORMULAS)
def test_numbers_are_those_of_flint(name: str) -> None:
    formula = FORMULAS[name]
    z, w = pairs([arb_of(x) for x in PLACE])
    found = formula(z, w)
    expected = formula(acb(z.real, z.imag), acb(w.real, w.imag))
    assert acb(found.real, found.imag).overlaps(expected)
    assert abs(found).overlaps(abs(expected))
    assert found.arg().overlaps(expected.arg())
    half = found / arb(2)
    assert acb(half.real, half.imag).overlaps(expected / 2)


def test_matrices_are_those_of_flint() -> None:
    z, w = pairs([arb_of(x) for x in PLACE])
    matrix = ComplexMatrix.of([[z, w], [-w, z * w]])
    found = matrix * matrix.adjoint() + matrix / arb(3) - -matrix
    a, b = acb(z.real, z.imag), acb(w.real, w.imag)
    entries = [[a, b], [-b, a * b]]
    other = acb_mat(entries)
    adjoint = acb_mat([[entries[j][i].conjugate() for j in (0, 1)] for i in (0, 1)])
    expected = other * adjoint + other * (acb(1) / 3) + other
    for i in (0, 1):
        for j in (0, 1):
            assert acb(found[i, j].real, found[i, j].imag).overlaps(expected[i, j])
    determinant = matrix.determinant()
    assert acb(determinant.real, determinant.imag).overlaps(other.det())


@pytest.mark.parametrize("part", ["real", "imag", "size", "phase"])
def test_derivatives_are_those_of_differences(part: str) -> None:
    parts: dict[str, Callable[[Complex], arb]] = {
        "real": lambda number: number.real,
        "imag": lambda number: number.imag,
        "size": abs,
        "phase": Complex.arg,
    }

    def value(numbers: Sequence[arb]) -> arb:
        """The part of a determinant of a matrix of two numbers."""
        z, w = pairs(numbers)
        matrix = ComplexMatrix.of([[z, w.conjugate()], [-w, z * w]])
        return parts[part]((matrix * matrix).determinant())

    with precision(256):
        slopes = slopes_of(value(parameters([arb_of(x) for x in PLACE])))
        for i in range(4):
            ahead, behind = (
                value([arb_of(x + sense * STEP * (i == j)) for j, x in enumerate(PLACE)])
                for sense in (1, -1)
            )
            assert abs((ahead - behind) / arb_of(2 * STEP) - slopes[i]) < 1e-29
