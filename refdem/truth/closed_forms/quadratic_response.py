"""x'' + 2 delta x' + w0^2 x + eps x^2 = f1 cos(w1 t) + f2 cos(w2 t) by validated integration; each
drive with f != 0 adds the coordinates cos(w t) and sin(w t).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.escape import Repulsion
from refdem.truth.exact import numbers, vector
from refdem.truth.validated_flow import Escape, ValidatedFlow, never

WITNESS = (
    "Taylor series in rational arithmetic from the power series of x; heyoka in multiprecision at"
    " literal values"
)


def infinite_to_one_side(repulsion: Repulsion, side: int, y: Sequence[arb]) -> arb | None:
    """A bound of the time until x is infinite where -eps x^2 repels: `side` is the sign of -eps."""
    x, v = y[:2]
    return repulsion.infinite_within(side * x, side * v)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters w0, eps, delta, f0 (two), drive (two), x0, v0; `scale` of x and v.

    x [m] and v [m/s] at t >= 0.
    """
    values = numbers(p, "w0", "eps", "delta", "x0", "v0")
    drives = [
        (force, w) for force, w in zip(vector(p, "f0"), vector(p, "drive"), strict=True) if force
    ]

    def field(y: Sequence[Any]) -> list[Any]:
        """The rates of (x, v) and of (cos w t, sin w t) for each drive."""
        x, v, *phases = y
        # x'' = -2 delta v - (w0^2 + eps x) x + sum of f cos(w t); (cos w t)' = -w sin w t and
        # (sin w t)' = w cos w t.
        acceleration = -2 * values["delta"] * v - (values["w0"] ** 2 + values["eps"] * x) * x
        phase_rates = []
        for number, (force, w) in enumerate(drives):
            cosine, sine = phases[2 * number : 2 * number + 2]
            acceleration = acceleration + force * cosine
            phase_rates += [-w * sine, w * cosine]
        return [v, acceleration, *phase_rates]

    start = [values["x0"], values["v0"], *([Fraction(1), Fraction(0)] * len(drives))]
    escape: Escape = never
    if values["eps"]:
        force = sum((abs(force) for force, _ in drives), Fraction(0))
        # z = -sgn(eps) x: z'' = |eps| z^2 - w0^2 z - 2 delta z' + f with |f| <= sum |f_i|.
        repulsion = Repulsion(2, abs(values["eps"]), values["w0"] ** 2, values["delta"], force)
        if values["eps"] > 0:
            side = -1
        else:
            side = 1
        escape = partial(infinite_to_one_side, repulsion, side)
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
