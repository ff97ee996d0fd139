"""Witness of a polygon in phase space: each corner by the witness of its flow, the initial area by
triangles, the area at later times by its rate.
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
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration of each corner; area by dA/dt = A div F, unproven"
    " (refdem/truth/witnesses/flows.py)"
)


def carried(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The motion of every corner of the polygon, and its area from dA/dt = A div F.

    div F is -2 delta with viscous damping, and 0 for the conservative flows. Under dry friction
    only the initial area is given.
    """
    corners = p["corners"]
    # The area as a sum of triangles: 1/2 (a - x) x (b - x) with the first corner x.
    x, v = corners[0]
    double_area = Fraction(0)
    for (xa, va), (xb, vb) in pairwise(corners[1:]):
        double_area += (xa - x) * (vb - v) - (xb - x) * (va - v)
    yield None, {"area_0": arb_of(double_area / 2)}
    if p["flow"] == "pendulum":
        names = ("theta", "thetadot")
    else:
        names = ("x", "v")
    for k, corner in enumerate(corners):
        for t, values in moved(p, corner, times):
            if t is not None:
                yield t, {f"x_{k}": values[names[0]], f"v_{k}": values[names[1]]}
    if p["flow"] != "coulomb":
        if p["flow"] == "viscous":
            decay = 2 * arb_of(number(p, "delta"))
        else:
            decay = arb(0)
        # dA/dt = A div F, div F = -2 delta or 0.
        area = Solution(lambda t, y: [-decay * y[0]], [arb_of(double_area / 2)])
        for t in times:
            yield t, {"area": area.at(t)[0]}


def moved(
    p: Mapping[str, Exact], corner: tuple[Fraction, Fraction], times: Sequence[Fraction]
) -> Results:
    """The motion from the corner (x, v) at t = 0, by the witness of its flow."""
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
