"""Turns and mirrors that map the axes on each other: numbers are exchanged and change their signs,
and none is rounded.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

AXES = "xyz"


@dataclass(frozen=True)
class SignedTurn:
    """A vector's component i becomes signs[i] times what was its component axes[i]."""

    axes: tuple[int, int, int]
    signs: tuple[int, int, int]

    @property
    def handedness(self) -> int:
        """The determinant: -1 for a mirror."""
        inversions = sum(a > b for a, b in itertools.combinations(self.axes, 2))
        return (-1) ** inversions * self.signs[0] * self.signs[1] * self.signs[2]

    def sign(self, axis: int, kind: str) -> int:
        """The sign of a component of a `polar` vector, or of an `axial` one such as a spin."""
        if kind == "axial":
            return self.handedness * self.signs[axis]
        return self.signs[axis]

    def turned(self, vector: Sequence[Fraction], kind: str) -> list[Fraction]:
        """A vector after the turn; `sizes` along the axes have no sign."""
        if kind == "sizes":
            return [vector[axis] for axis in self.axes]
        return [self.sign(i, kind) * vector[axis] for i, axis in enumerate(self.axes)]

    def component(self, name: str, kind: str) -> tuple[str, int]:
        """Where a component x, y or z goes, and its sign there; of a matrix, xx to zz."""
        new = ""
        sign = 1
        for letter in name:
            axis = self.axes.index(AXES.index(letter))
            new += AXES[axis]
            sign *= self.sign(axis, kind)
        return new, sign


ALL = [
    SignedTurn((axes[0], axes[1], axes[2]), (signs[0], signs[1], signs[2]))
    for axes in itertools.permutations(range(3))
    for signs in itertools.product((1, -1), repeat=3)
]
INVERSION = SignedTurn((0, 1, 2), (-1, -1, -1))
