"""Witness of the heavy top: Euler's equations about the tip in body axes, with the vertical as it
is seen from the body.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration of Euler's equations and of the vertical in body axes at 58 digits,"
    " unproven (refdem/truth/witnesses/tops.py)"
)


def heavy(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """State omega_body, vertical n in body axes, phi, psi; theta = acos n3.

    Of the scalars those of a start at a turning point.
    """
    e = {
        name: arb_of(number(p, name))
        for name in ("theta0", "phidot0", "thetadot0", "spin", "mass", "length", "gravity")
    }
    moments = [arb_of(j) for j in vector(p, "inertia")]
    sine, cosine = e["theta0"].sin_cos()
    start = [e["thetadot0"], e["phidot0"] * sine, e["spin"], arb(0), sine, cosine, arb(0), arb(0)]
    found = Solution(partial(toppling, moments, e["mass"] * e["gravity"] * e["length"]), start)
    for t in times:
        s = found.at(t)
        rate = -sinking(s) / (s[3] * s[3] + s[4] * s[4]).sqrt()
        yield t, {"theta": s[5].acos(), "phi": s[6], "psi": s[7], "thetadot": rate}
    if "period" in claimed and number(p, "thetadot0") == 0:
        near = float(claimed["period"])
        turned = found.at(found.crossing(sinking, near / 2, near / 128))[5].acos()
        low, high = sorted((turned, e["theta0"]), key=float)
        yield (
            None,
            {
                "period": found.crossing(sinking, near, near / 128),
                "nutation_min": low,
                "nutation_max": high,
            },
        )


def sinking(s: Sequence[arb]) -> arb:
    """d cos theta/dt = n1 omega2 - n2 omega1."""
    return s[3] * s[1] - s[4] * s[0]


def toppling(moments: Sequence[arb], weight: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """J omega' = J omega x omega + torque, n' = n x omega, phi' from omega across the axis, psi' =
    omega3 - phi' n3.
    """
    a, b, c, x, y, z, _, _ = s
    across, along = moments
    round_ = (a * x + b * y) / (x * x + y * y)
    spins = [
        ((across - along) * b * c + weight * y) / across,
        ((along - across) * c * a - weight * x) / across,
        c * 0,
    ]
    return [*spins, y * c - z * b, z * a - x * c, x * b - y * a, round_, c - round_ * z]


WITNESSES = {"heavy-top": Witness(METHOD, heavy)}
