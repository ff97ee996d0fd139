"""Section 1.6.4: polyhedra that add up the weights of their corners in different orders turn apart,
while their centres fall together.
"""

from fractions import Fraction
from math import log, pi, sqrt

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.corner_weights import INERTIA, SPIN, Array, Copies, fallen
from refdem.gallery.runs import command, instance, remember

LASTS = 36.0
"""Duration [s], after which all that turn over have done so."""
FITTED = (1e-12, 1e-3)
"""Angles [rad] between which they grow exponentially: far above rounding, and far below 1."""
SIZE = (380, 300)
QUARTERS = 36
"""Quarter turns, pi/2/SPIN each, over which the growth of the certified S is taken."""
FROM = Fraction(10)
"""When they begin [s]."""
CAPTION = (
    "An octahedron, J = (2, 3, 4) kg m^2, falls and turns at 4 rad/s while the weights of its"
    " six corners, whose torques cancel, are added up: 24 copies, each in another order, which"
    " changes nothing but rounding. About the intermediate axis (orange) attitudes part"
    " exponentially until some copies are upside down; about the third (blue) they agree to"
    " round-off, and so do all centres. The dashed line has the rate of (1.134)-(1.136)."
)


def figure() -> Figure:
    """The angles between copies about the intermediate axis and about the third, and the distances
    of their centres.
    """
    about_second, about_third = fallen((1, 2), LASTS)
    rates = growth_rates(about_second)
    expected = SPIN * sqrt(
        (INERTIA[1] - INERTIA[0]) * (INERTIA[2] - INERTIA[1]) / (INERTIA[0] * INERTIA[2])
    )
    farthest = max(float(copies.distance.max()) for copies in (about_second, about_third))
    numbers = {
        "other orders of summation": float(about_second.angle.shape[1]),
        "of them turn over otherwise than the first": float(len(rates)),
        "rate at which their angles grow [1/s]": float(rates.mean()),
        "its standard error [1/s]": float(rates.std(ddof=1) / np.sqrt(len(rates))),
        "omega sqrt((J2 - J1)(J3 - J2)/(J1 J3)) [1/s]": expected,
        "rate at which the certified bound S grows [1/s]": certified_rate(),
        "largest angle about the intermediate axis [rad]": float(about_second.angle.max()),
        "largest angle about the third axis [rad]": float(about_third.angle.max()),
        "height that they fall [m]": float(np.ptp(about_second.height[:, 0])),
        "largest distance of their centres [m]": farthest,
    }
    return Figure(
        id="summation-order",
        title="Orders of summation",
        caption=CAPTION,
        panels=(angles(about_second, about_third, expected), distances(about_second)),
        columns=2,
        numbers=numbers,
        digits=6,
    )


def growth_rates(copies: Copies) -> Array:
    """The rate [1/s] of every copy that parts from the first, by a line through the logarithm of
    its angle.
    """
    low, high = FITTED
    found = []
    for angle in copies.angle.T:
        if angle.max() < high:
            continue
        end = int(np.argmax(angle > high))
        begin = int(np.flatnonzero(angle[:end] < low)[-1]) + 1
        line = np.polynomial.Polynomial.fit(copies.t[begin:end], np.log(angle[begin:end]), 1)
        found.append(line.convert().coef[1])
    return np.array(found)


def certified_rate() -> float:
    """The mean rate [1/s] at which the certified bound S of a free body about this axis grows."""
    case_instance = instance(
        "free-rigid-body",
        inertia=tuple(INERTIA.tolist()),
        omega_body=(0, SPIN, 0),
        attitude="1,2,3,4",
        duration=LASTS,
    )
    remember(command(case_instance))
    truth = case_instance.truth()
    lasts = Fraction(QUARTERS * pi / 2 / SPIN)
    growth = truth.sensitivity(FROM + lasts) / truth.sensitivity(FROM)
    return log(growth) / float(lasts)


def angles(about_second: Copies, about_third: Copies, rate: float) -> Panel:
    """The angle from the first copy to every other one over time, on a logarithmic axis."""
    series = []
    for copies, ink, label in (
        (about_third, 0, "about the third axis"),
        (about_second, 1, "about the intermediate axis"),
    ):
        for n, angle in enumerate(copies.angle.T):
            name = ""
            if n == 0:
                name = label
            # An angle of 0 has no logarithm: the curve breaks there.
            shown = np.where(angle > 0, angle, np.nan)
            series.append(Series(x=copies.t[::8], y=shown[::8], ink=ink, label=name, width=1))
    t = np.array([4.0, 26.0])
    grown = 1e-16 * np.exp(rate * (t - t[0]))
    series.append(Series(x=t, y=grown, ink=GREY, dashed=True))
    return Panel(
        series=tuple(series),
        x=Axis(title="t [s]"),
        y=Axis(title="angle from the first copy [rad]", ends=(1e-17, 10.0), is_log=True),
        size=SIZE,
    )


def distances(copies: Copies) -> Panel:
    """The largest distance of a centre from that of the first copy."""
    largest = copies.distance.max(axis=1) / 1e-15
    return Panel(
        series=(Series(x=copies.t, y=largest, ink=1, width=1),),
        x=Axis(title="t [s]"),
        y=Axis(title="largest distance of the centres [1e-15 m]"),
        size=SIZE,
    )
