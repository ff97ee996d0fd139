"""x'' + 2 delta x' + alpha x + beta x^3 = f0 cos(w t) by validated integration; cos and sin of the
drive are coordinates.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.escape import Repulsion
from refdem.truth.exact import numbers
from refdem.truth.validated_flow import ValidatedFlow


class DrivenDuffing(ValidatedFlow):
    """x [m] and v [m/s] at t >= 0."""

    witness = (
        "Taylor series in rational arithmetic from the power series of x; heyoka in multiprecision"
        " at literal values"
    )
    repulsion: Repulsion | None = None

    def infinite_within(self, y: Sequence[arb]) -> arb | None:
        """Where beta < 0 the spring repels beyond some |x|, to either side alike."""
        if self.repulsion is None:
            return None
        x, v = y[:2]
        if x > 0:
            side = 1
        else:
            side = -1
        return self.repulsion.infinite_within(side * x, side * v)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters alpha, beta, delta, f0, drive, x0, v0; `scale` of x and v."""
    values = numbers(p, "alpha", "beta", "delta", "f0", "drive", "x0", "v0")

    def field(y: Sequence[Any]) -> list[Any]:
        x, v, c, s = y
        push = (
            values["f0"] * c
            - 2 * values["delta"] * v
            - (values["alpha"] + values["beta"] * (x * x)) * x
        )
        return [v, push, -values["drive"] * s, values["drive"] * c]

    start = [values["x0"], values["v0"], Fraction(1), Fraction(0)]
    found = DrivenDuffing(
        field, start, lambda y: {"x": y[0], "v": y[1]}, scale, state=("x", "v"), moved=(0, 1)
    )
    if values["beta"] < 0:
        found.repulsion = Repulsion(
            3, -values["beta"], values["alpha"], values["delta"], abs(values["f0"])
        )
    return found
