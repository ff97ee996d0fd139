"""Truth without time: scalars only, as exact numbers or as balls at a rising precision."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Self

from flint import arb

from refdem.errors import NotCertifiedError
from refdem.truth.closed_form import ClosedForm
from refdem.truth.growth import Grows, Told


@dataclass(frozen=True)
class Timeless(ClosedForm):
    """`values` gives every value at the current precision."""

    method = "closed form"
    state = ()

    values: Callable[[], Mapping[str, arb]]
    witness: str

    def constants(self) -> dict[str, arb]:
        """The values of the case, by name."""
        return dict(self.values())

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The values: nothing depends on time."""
        return self.constants()

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """There is no start to displace: raises NotCertifiedError."""
        raise NotCertifiedError("the case has no start; its values are scalars")

    def growth(self) -> Grows:
        """The growth S = 1: without time an error does not grow."""
        return Told(lambda t: arb(1))
