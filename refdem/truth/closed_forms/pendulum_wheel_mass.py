"""Certified pendulum, wheel and mass: validated integration of r, theta, r', theta'.

From Lagrange's equations with A = M + m + J/R^2 and u = r' - R theta':

    A u' = m r theta'^2 - M g + m g cos theta,
    d/dt (m r^2 theta' - A R u) = M g R - m g (R cos theta + r sin theta).

The first equation inserted into the second gives r theta'' = R theta'^2 - 2 r' theta' - g sin
theta; r'' = u' + R theta''.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

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
    """The rates of (r, theta, r', theta'), by the equations above."""
    m = p["mass"]
    counter = p["counter_mass"]
    radius = p["wheel_radius"]
    g = p["gravity"]
    # A = M + m + J/R^2; for R = 0 the inertia of the wheel does not enter.
    string_mass = m + counter
    if radius:
        string_mass += p["wheel_inertia"] / radius**2

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        # u' = (m r theta'^2 + m g cos theta - M g)/A
        # theta'' = (R theta'^2 - 2 r' theta' - g sin theta)/r,  r'' = u' + R theta''
        r, theta, rdot, thetadot = y
        u_rate = (r * thetadot * thetadot * m + theta.cos() * (m * g) - counter * g) / string_mass
        angular = (thetadot * thetadot * radius - rdot * thetadot * 2 - theta.sin() * g) / r
        return rdot, thetadot, u_rate + angular * radius, angular

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, counter_mass [kg], wheel_radius [m], wheel_inertia [kg m^2],
    gravity [m/s^2] and the start r0, theta0, rdot0, thetadot0.
    """
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
        remark=drawn_onto_wheel,
    )


def drawn_onto_wheel(y: Sequence[arb], t: float) -> str:
    """The reason of a proof that ends at the time t [s] in the state y, if the string's speed would
    bring the pendulum to the wheel within as much time again: the equations divide by r.
    """
    r, _, rdot, _ = (float(value.mid()) for value in y)
    if not r + rdot * t < 0:
        return ""
    return (
        f"; there {r:.3g} m of free string are left, which become shorter by {-rdot:.3g} m/s: where"
        " none is left the pendulum is on the wheel, and the equations end; ask for an earlier time"
    )
