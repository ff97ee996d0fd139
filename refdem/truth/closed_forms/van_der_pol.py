"""x'' - mu (1 - x^2) x' + x = p sin(w t) (1.124) by validated integration; a drive that acts has
two coordinates.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.exact import numbers
from refdem.truth.validated_flow import ValidatedFlow

WITNESS = (
    "Taylor series in rational arithmetic from the power series of x; heyoka in multiprecision at"
    " literal values"
)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mu, p, drive, x0, v0; `scale` of x and v.

    x [m] and v [m/s] at t >= 0.
    """
    values = numbers(p, "mu", "p", "drive", "x0", "v0")

    def field(y: Sequence[Any]) -> list[Any]:
        """The rates of (x, v), and of (sin w t, cos w t) where a drive acts."""
        x, v, *phase = y
        # x'' = mu (1 - x^2) x' - x + p sin(w t).
        acceleration = values["mu"] * (1 - x * x) * v - x
        if not phase:
            return [v, acceleration]
        sine, cosine = phase
        driven = acceleration + values["p"] * sine
        # (sin w t)' = w cos w t, (cos w t)' = -w sin w t.
        return [v, driven, values["drive"] * cosine, -values["drive"] * sine]

    start = [values["x0"], values["v0"]]
    if values["p"]:
        # sin 0 and cos 0.
        start += [Fraction(0), Fraction(1)]
    return ValidatedFlow(
        field,
        start,
        lambda y: {"x": y[0], "v": y[1]},
        scale,
        state=("x", "v"),
        moved=(0, 1),
        witness=WITNESS,
    )
