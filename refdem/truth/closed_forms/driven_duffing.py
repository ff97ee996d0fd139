"""x'' + 2 delta x' + alpha x + beta x^3 = f0 cos(w t) by validated integration; cos and sin of the drive are coordinates."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.exact import numbers
from refdem.truth.validated_flow import ValidatedFlow


class DrivenDuffing(ValidatedFlow):
    """x [m] and v [m/s] at t >= 0."""

    witness = "Taylor series in rational arithmetic from the power series of x; heyoka in multiprecision at literal values"


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters alpha, beta, delta, f0, drive, x0, v0; `scale` of x and v."""
    values = numbers(p, "alpha", "beta", "delta", "f0", "drive", "x0", "v0")

    def field(y: Sequence[Any]) -> list[Any]:
        x, v, c, s = y
        push = values["f0"] * c - 2 * values["delta"] * v - (values["alpha"] + values["beta"] * (x * x)) * x
        return [v, push, -values["drive"] * s, values["drive"] * c]

    start = [values["x0"], values["v0"], Fraction(1), Fraction(0)]
    return DrivenDuffing(field, start, lambda y: {"x": y[0], "v": y[1]}, scale, state=("x", "v"), moved=(0, 1))
