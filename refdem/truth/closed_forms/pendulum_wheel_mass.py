"""Certified pendulum, wheel and mass: validated integration of r, theta, r', theta'.

From Lagrange's equations with A = M + m + J/R^2 and u = r' - R theta': A u' = m r theta'^2 - M g +
m g cos theta and d/dt (m r^2 theta' - A R u) = M g R - m g (R cos theta + r sin theta), solved for
r'' and theta''.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.exact import numbers
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import ValidatedFlow

NAMES = ("r", "theta", "rdot", "thetadot")


WITNESS = (
    "multiprecision integration (refdem/truth/witnesses/linked.py); energy and, where it holds, the"
    " second integral"
)


def field(p: Mapping[str, Fraction]) -> Field:
    """The rates of the four numbers."""
    m = p["mass"]
    counter = p["counter_mass"]
    radius = p["wheel_radius"]
    g = p["gravity"]
    whole = m + counter + (p["wheel_inertia"] / radius**2 if radius else 0)

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        r, theta, rdot, rate = y
        string = (r * rate * rate * m + theta.cos() * (m * g) - counter * g) / whole
        turning = (rate * rate * radius - rdot * rate * 2 - theta.sin() * g) / r
        return rdot, rate, string + turning * radius, turning

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters."""
    exact = numbers(
        p,
        "mass",
        "counter_mass",
        "wheel_radius",
        "wheel_inertia",
        "gravity",
        "r0",
        "theta0",
        "rdot0",
        "thetadot0",
    )
    start = [exact[name] for name in ("r0", "theta0", "rdot0", "thetadot0")]
    return ValidatedFlow(
        field(exact),
        start,
        lambda y: dict(zip(NAMES, y, strict=True)),
        scale,
        state=NAMES,
        moved=range(4),
        witness=WITNESS,
    )
