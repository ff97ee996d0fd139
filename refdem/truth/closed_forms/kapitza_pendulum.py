"""Certified Kapitza pendulum: theta'' = (g - a W^2 cos W t)/l sin theta by validated integration,
with cos W t and sin W t as coordinates of the state.

theta [rad] counts from the top; the pivot moves as a cos W t (`drive_amplitude` a [m], `drive` W
[rad/s]).

Stability of the top: near it x'' = (g - a W^2 cos W t)/l x (Mathieu's equation). Its solutions x1,
x2 with (x, x') = (1, 0) and (0, 1) at the start form after one period 2 pi/W a matrix of
determinant 1 and trace D = x1 + x2'. So Floquet's multipliers, its eigenvalues, are (D +- sqrt(D^2
- 4))/2: real if |D| > 2, else of modulus 1 (Floquet 1883).
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
    """The trace D = x1 + x2' after one period of the drive, at the current precision."""
    # (x1, x1', x2, x2', cos, sin) at the phase 0.
    start = [arb(value) for value in (1, 0, 0, 1, 1, 0)]
    period = Integration(about_the_top(p), lambda: start, ctx.prec)
    x1, _, _, v2, *_ = period.at(2 * arb.pi())
    return x1 + v2


def multipliers(p: Mapping[str, Fraction]) -> dict[str, arb]:
    """The multipliers: floquet_1, that of larger modulus, and floquet_2 = 1/floquet_1.

    Where the top is stable both are given as their modulus 1. Raises NotCertifiedError where they
    may be too large to be integrated, UndecidedError where a ball of D^2 - 4 holds 0.
    """
    # In a period x grows by at most exp(2 pi sqrt((g/W^2 + a)/l)): |x''| <= (g + a W^2)/l |x|.
    square = (p["gravity"] / p["drive"] ** 2 + p["drive_amplitude"]) / p["length"]
    exponent = 2 * arb.pi() * arb_of(square).sqrt()
    if exponent > WILDEST:
        message = (
            "precision: in a period of so slow a drive the multipliers may grow by"
            f" exp({float(exponent):.3g}); take a faster drive"
        )
        raise NotCertifiedError(message, code="precision")
    # (D +- sqrt(D^2 - 4))/2: complex of modulus 1 for D^2 < 4, real for D^2 > 4.
    d = trace(p)
    discriminant = d * d - 4
    if discriminant < 0:
        return {"floquet_1": arb(1), "floquet_2": arb(1)}
    if not discriminant > 0:
        raise UndecidedError(f"on the border of stability: D^2 - 4 is {discriminant}")
    # The root of the same sign as D, so that nothing cancels; the product of both is 1.
    larger = (d + discriminant.sqrt() * d.sgn()) / 2
    return {"floquet_1": larger, "floquet_2": 1 / larger}


def field(p: Mapping[str, Fraction]) -> Field:
    """The rates of the state (theta, thetadot, cos W t, sin W t).

    theta'' = (g - a W^2 cos W t) sin theta/l.
    """
    drive = p["drive"]
    pivot_acceleration = p["drive_amplitude"] * p["drive"] ** 2

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        theta, thetadot, cosine, sine = y
        # theta'' = (g - a W^2 cos W t) sin theta/l.
        angular_acceleration = (
            (p["gravity"] - cosine * pivot_acceleration) * theta.sin() / p["length"]
        )
        return (thetadot, angular_acceleration, sine * -drive, cosine * drive)

    return rates


def about_the_top(p: Mapping[str, Fraction]) -> Field:
    """The rates of (x1, x1', x2, x2', cos, sin): two solutions of Mathieu's equation.

    Time is the phase W t, so that x'' = (g/(l W^2) - (a/l) cos) x and the period is 2 pi.
    """
    weight = p["gravity"] / (p["length"] * p["drive"] ** 2)
    push = p["drive_amplitude"] / p["length"]

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        x1, v1, x2, v2, cosine, sine = y
        # x'' = (g/(l W^2) - (a/l) cos) x for both solutions.
        stiffness = weight - cosine * push
        return v1, stiffness * x1, v2, stiffness * x2, -sine, cosine

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters length [m], gravity [m/s^2], drive_amplitude [m], drive [rad/s],
    theta0 [rad], thetadot0 [rad/s].

    Quantities are theta (continuous, from the top) and thetadot; scalars are the multipliers.
    """
    exact = numbers(p, "length", "gravity", "drive_amplitude", "drive", "theta0", "thetadot0")
    return ValidatedFlow(
        field(exact),
        [exact["theta0"], exact["thetadot0"], Fraction(1), Fraction(0)],
        lambda y: dict(zip(SEEN, y, strict=False)),
        scale,
        state=SEEN,
        moved=(0, 1),
        witness=WITNESS,
        constants=lambda flow: multipliers(exact),
    )
