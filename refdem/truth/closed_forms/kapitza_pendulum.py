"""Certified Kapitza pendulum: theta'' = (g - a W^2 cos W t)/l sin theta by validated integration,
cos W t and sin W t carried along.

About the top x'' = (g - a W^2 cos W t)/l x (Mathieu's equation). Its solutions (1, 0) and (0, 1)
after one period 2 pi/W have the determinant 1 and a trace D = x1 + x2', so the multipliers are (D
+- sqrt(D^2 - 4))/2: real if |D| > 2, else of modulus 1 (Floquet 1883).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.exact import numbers
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import ValidatedFlow
from refdem.truth.validated_ivp.integration import Integration

WILDEST = 128
"""Largest exponent of growth in a period, 2 pi sqrt((g/W^2 + a)/l), at which multipliers are
integrated.
"""


WITNESS = (
    "multiprecision integration (refdem/truth/witnesses/linked.py); Hill's determinant for the"
    " multipliers"
)
SEEN = ("theta", "thetadot")


def trace(p: Mapping[str, Fraction]) -> arb:
    """D at the current precision."""
    start = [arb(value) for value in (1, 0, 0, 1, 1, 0)]
    period = Integration(about_the_top(p), lambda: start, ctx.prec)
    x1, _, _, v2, *_ = period.at(2 * arb.pi())
    return x1 + v2


def multipliers(p: Mapping[str, Fraction]) -> dict[str, arb]:
    """floquet_1, the multiplier of larger modulus, and floquet_2; 1 twice where the top is
    stable.
    """
    # 2 pi sqrt((g/W^2 + a)/l)
    square = (p["gravity"] / p["drive"] ** 2 + p["drive_amplitude"]) / p["length"]
    exponent = 2 * arb.pi() * arb_of(square).sqrt()
    if exponent > WILDEST:
        told = (
            "precision: in a period of so slow a drive the multipliers may grow by"
            f" exp({float(exponent):.3g}); take a faster drive"
        )
        raise NotCertifiedError(told, code="precision")
    d = trace(p)
    rest = d * d - 4
    if rest < 0:
        return {"floquet_1": arb(1), "floquet_2": arb(1)}
    if not rest > 0:
        raise UndecidedError(f"on the border of stability: D^2 - 4 is {rest}")
    largest = (d + rest.sqrt() * d.sgn()) / 2
    return {"floquet_1": largest, "floquet_2": 1 / largest}


def shaken(p: Mapping[str, Fraction]) -> Field:
    """The rates of theta, thetadot, cos W t and sin W t."""
    drive = p["drive"]
    push = p["drive_amplitude"] * p["drive"] ** 2

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        theta, rate, cosine, sine = y
        return (
            rate,
            (p["gravity"] - cosine * push) * theta.sin() / p["length"],
            sine * -drive,
            cosine * drive,
        )

    return rates


def about_the_top(p: Mapping[str, Fraction]) -> Field:
    """The rates of two solutions (x, x') of the linear equation, and of cosine and sine, with the
    phase W t as time.
    """
    weight = p["gravity"] / (p["length"] * p["drive"] ** 2)
    push = p["drive_amplitude"] / p["length"]

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        x1, v1, x2, v2, cosine, sine = y
        stiffness = weight - cosine * push
        return v1, stiffness * x1, v2, stiffness * x2, -sine, cosine

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (length, gravity, drive_amplitude, drive, theta0,
    thetadot0): theta (continuous, from the top) and thetadot; scalars are the multipliers.
    """
    exact = numbers(p, "length", "gravity", "drive_amplitude", "drive", "theta0", "thetadot0")
    return ValidatedFlow(
        shaken(exact),
        [exact["theta0"], exact["thetadot0"], Fraction(1), Fraction(0)],
        lambda y: dict(zip(SEEN, y, strict=False)),
        scale,
        state=SEEN,
        moved=(0, 1),
        witness=WITNESS,
        constants=lambda flow: multipliers(exact),
    )
