"""Witness of a polygon in phase space: each corner as its flow's own witness moves it, areas by
their rate and by triangles.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number
from refdem.truth.witnesses import contacts, oscillators, points
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration of each corner; area by dA/dt = A div F, unproven"
    " (refdem/truth/witnesses/flows.py)"
)


def carried(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The motion of every corner of the outline, and the area; under dry friction that at the start
    alone.
    """
    corners = p["corners"]
    (x, v), halves = corners[0], Fraction(0)
    for (xa, va), (xb, vb) in pairwise(corners[1:]):
        halves += (xa - x) * (vb - v) - (xb - x) * (va - v)
    yield None, {"area_0": arb_of(halves / 2)}
    for k, corner in enumerate(corners):
        for t, values in moved(p, corner, times):
            if t is not None:
                place, rate = (
                    values[name]
                    for name in (("theta", "thetadot") if p["flow"] == "pendulum" else ("x", "v"))
                )
                yield t, {f"x_{k}": place, f"v_{k}": rate}
    if p["flow"] != "coulomb":
        if p["flow"] == "viscous":
            lost = 2 * arb_of(number(p, "delta"))
        else:
            lost = arb(0)
        shrinking = Solution(lambda t, y: [-lost * y[0]], [arb_of(halves / 2)])
        for t in times:
            yield t, {"area": shrinking.at(t)[0]}


def moved(
    p: Mapping[str, Exact], corner: tuple[Fraction, Fraction], times: Sequence[Fraction]
) -> Said:
    """The motion of one corner of the outline."""
    if p["flow"] == "pendulum":
        return points.pendulum({**p, "theta0": corner[0], "thetadot0": corner[1]}, times, {})
    start = {**p, "gravity": Fraction(0), "x0": corner[0], "v0": corner[1]}
    if p["flow"] == "coulomb":
        return contacts.coulomb(start, times, {})
    if p["flow"] == "viscous":
        name = "viscous-oscillator"
    else:
        name = "harmonic-oscillator"
    return oscillators.WITNESSES[name].values(start, times, {})


WITNESSES = {"phase-flow": Witness(METHOD, carried)}
