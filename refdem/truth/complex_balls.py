"""Complex numbers and 2 x 2 matrices of them, as pairs of balls, which may carry derivatives.

`acb` of python-flint keeps the balls of a dual number (dual.py) and drops its derivatives; a pair
keeps both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb

from refdem.truth.dual import atan2


@dataclass(frozen=True)
class Complex:
    """The number real + i imag."""

    real: arb
    imag: arb

    def __neg__(self) -> "Complex":
        return Complex(-self.real, -self.imag)

    def __add__(self, other: "Complex") -> "Complex":
        return Complex(self.real + other.real, self.imag + other.imag)

    def __sub__(self, other: "Complex") -> "Complex":
        return Complex(self.real - other.real, self.imag - other.imag)

    def __mul__(self, other: "Complex") -> "Complex":
        real = self.real * other.real - self.imag * other.imag
        imag = self.real * other.imag + self.imag * other.real
        return Complex(real, imag)

    def __truediv__(self, real: arb) -> "Complex":
        return Complex(self.real / real, self.imag / real)

    def __abs__(self) -> arb:
        square: Any = self.real * self.real + self.imag * self.imag
        size: arb = square.sqrt()
        return size

    def conjugate(self) -> "Complex":
        """The conjugate number real - i imag."""
        return Complex(self.real, -self.imag)

    def inverse(self) -> "Complex":
        """The number 1/z = z*/|z|^2."""
        return self.conjugate() / (self.real * self.real + self.imag * self.imag)

    def arg(self) -> arb:
        """The phase [rad] in (-pi, pi]."""
        return atan2(self.imag, self.real)


Row = tuple[Complex, Complex]


@dataclass(frozen=True)
class ComplexMatrix:
    """A complex 2 x 2 matrix, as two rows."""

    rows: tuple[Row, Row]

    @classmethod
    def of(cls, rows: Sequence[Sequence[Complex]]) -> "ComplexMatrix":
        """The matrix with these two rows of two entries."""
        (a, b), (c, d) = rows
        return cls(((a, b), (c, d)))

    def __getitem__(self, place: tuple[int, int]) -> Complex:
        row, column = place
        return self.rows[row][column]

    def __neg__(self) -> "ComplexMatrix":
        return ComplexMatrix.of([[-entry for entry in row] for row in self.rows])

    def __add__(self, other: "ComplexMatrix") -> "ComplexMatrix":
        return ComplexMatrix.of([[self[i, j] + other[i, j] for j in (0, 1)] for i in (0, 1)])

    def __sub__(self, other: "ComplexMatrix") -> "ComplexMatrix":
        return self + -other

    def __mul__(self, other: "ComplexMatrix") -> "ComplexMatrix":
        return ComplexMatrix.of(
            [[self[i, 0] * other[0, j] + self[i, 1] * other[1, j] for j in (0, 1)] for i in (0, 1)]
        )

    def __truediv__(self, real: arb) -> "ComplexMatrix":
        return ComplexMatrix.of([[entry / real for entry in row] for row in self.rows])

    def adjoint(self) -> "ComplexMatrix":
        """The conjugate transpose of the matrix."""
        return ComplexMatrix.of([[self[j, i].conjugate() for j in (0, 1)] for i in (0, 1)])

    def determinant(self) -> Complex:
        """The determinant of the matrix."""
        return self[0, 0] * self[1, 1] - self[0, 1] * self[1, 0]
