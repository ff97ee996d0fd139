"""x'' + 2 delta x' + alpha x + beta x^3 = f0 cos(w t) by validated integration; cos and sin of the
drive are coordinates.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.escape import Repulsion
from refdem.truth.exact import numbers
from refdem.truth.validated_flow import Escape, ValidatedFlow, never

WITNESS = (
    "Taylor series in rational arithmetic from the power series of x; heyoka in multiprecision at"
    " literal values"
)


def infinite_to_either_side(repulsion: Repulsion, y: Sequence[arb]) -> arb | None:
    """Where beta < 0 the spring repels beyond some |x|, to either side alike."""
    x, v = y[:2]
    if x > 0:
        side = 1
    else:
        side = -1
    # The equation keeps its form under (x, f0) -> (-x, -f0), and the theorem holds for |f| <= F.
    return repulsion.infinite_within(side * x, side * v)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters alpha, beta, delta, f0, drive, x0, v0; `scale` of x and v.

    x [m] and v [m/s] at t >= 0.
    """
    values = numbers(p, "alpha", "beta", "delta", "f0", "drive", "x0", "v0")

    def field(y: Sequence[Any]) -> list[Any]:
        """The rates of (x, v, cos w t, sin w t)."""
        x, v, cosine, sine = y
        # x'' = f0 cos(w t) - 2 delta x' - (alpha + beta x^2) x.
        acceleration = (
            values["f0"] * cosine
            - 2 * values["delta"] * v
            - (values["alpha"] + values["beta"] * (x * x)) * x
        )
        # (cos w t)' = -w sin w t, (sin w t)' = w cos w t.
        return [v, acceleration, -values["drive"] * sine, values["drive"] * cosine]

    # (x0, v0, cos 0, sin 0).
    start = [values["x0"], values["v0"], Fraction(1), Fraction(0)]
    escape: Escape = never
    if values["beta"] < 0:
        # z'' = k z^3 - w z - 2 d z' + f with k = -beta, w = alpha, d = delta and |f| <= |f0|.
        repulsion = Repulsion(
            3, -values["beta"], values["alpha"], values["delta"], abs(values["f0"])
        )
        escape = partial(infinite_to_either_side, repulsion)
    return ValidatedFlow(
        field,
        start,
        lambda y: {"x": y[0], "v": y[1]},
        scale,
        state=("x", "v"),
        moved=(0, 1),
        witness=WITNESS,
        escape=escape,
    )
