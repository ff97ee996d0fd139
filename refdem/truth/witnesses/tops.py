"""Witness of the heavy top: Euler's equations about the tip in body axes, together with the upward
vertical unit vector n in body axes.

The state is omega_body (3), n (3), phi and psi; cos theta = n3. J1 is the moment of inertia about
an axis through the tip across the axis of the body, J3 the one about the axis of the body.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration of Euler's equations and of the vertical in body axes at 58 digits,"
    " unproven (refdem/truth/witnesses/tops.py)"
)


def heavy(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The angles and thetadot = -(cos theta)'/sin theta, and the scalars of the nutation.

    The scalars are given for a start with theta' = 0. The other end of the nutation is then the
    first turning point of theta after the start, and the period the time of the second one.
    """
    names = ("theta0", "phidot0", "thetadot0", "spin", "mass", "length", "gravity")
    e = {name: arb_of(number(p, name)) for name in names}
    moments = [arb_of(j) for j in vector(p, "inertia")]
    sine, cosine = e["theta0"].sin_cos()
    # phi = psi = 0 at the start: omega_body = (theta', phi' sin theta, w3) and n = (0, sin theta,
    # cos theta).
    omega_body = [e["thetadot0"], e["phidot0"] * sine, e["spin"]]
    vertical = [arb(0), sine, cosine]
    start = [*omega_body, *vertical, arb(0), arb(0)]
    solution = Solution(partial(toppling, moments, e["mass"] * e["gravity"] * e["length"]), start)
    for t in times:
        s = solution.at(t)
        n1, n2, n3 = s[3:6]
        phi, psi = s[6:]
        # theta' = -(cos theta)'/sin theta, sin theta = sqrt(n1^2 + n2^2)
        thetadot = -cosine_rate(s) / (n1 * n1 + n2 * n2).sqrt()
        yield t, {"theta": n3.acos(), "phi": phi, "psi": psi, "thetadot": thetadot}
    if "period" in claimed and number(p, "thetadot0") == 0:
        period = float(claimed["period"])
        first_turn = solution.crossing(cosine_rate, period / 2, period / 128)
        other_end = solution.at(first_turn)[5].acos()
        low, high = sorted((other_end, e["theta0"]), key=float)
        second_turn = solution.crossing(cosine_rate, period, period / 128)
        yield None, {"period": second_turn, "nutation_min": low, "nutation_max": high}


def cosine_rate(s: Sequence[arb]) -> arb:
    """d cos theta/dt = n1 omega2 - n2 omega1."""
    return s[3] * s[1] - s[4] * s[0]


def toppling(moments: Sequence[arb], weight: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The right-hand side of the equations of a heavy top; `weight` is m g l [N m].

    J omega' = (J omega) x omega + m g l (n2, -n1, 0),    n' = n x omega,
    phi' = (omega1 n1 + omega2 n2)/(n1^2 + n2^2),    psi' = omega3 - phi' n3.
    """
    w1, w2, w3, n1, n2, n3, _, _ = s
    j1, j3 = moments
    phi_rate = (w1 * n1 + w2 * n2) / (n1 * n1 + n2 * n2)
    # J omega' = (J omega) x omega + m g l (n2, -n1, 0), with J1 about both axes across the body.
    omega_rate = [
        ((j1 - j3) * w2 * w3 + weight * n2) / j1,
        ((j3 - j1) * w3 * w1 - weight * n1) / j1,
        w3 * 0,
    ]
    # n' = n x omega, as the vertical is constant in space.
    vertical_rate = [n2 * w3 - n3 * w2, n3 * w1 - n1 * w3, n1 * w2 - n2 * w1]
    return [*omega_rate, *vertical_rate, phi_rate, w3 - phi_rate * n3]


WITNESSES = {"heavy-top": Witness(METHOD, heavy)}
