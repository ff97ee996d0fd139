"""The area of an outline in phase space against Liouville's theorem (1.107)-(1.111).

Area is conserved in conservative motions, falls as exp(-2 delta t) with viscous damping, and is
deposited on the segment of rest by dry friction. The outline is a polygon of points (x, v), each of
which moves by itself.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from refdem.core.case import EnsembleCase
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, certified, no_truth, undecided, worst
from refdem.core.problem import Ensemble
from refdem.core.variant import Variant
from refdem.mechanics.oscillation import phase_area

CORNER_ROUNDINGS = 8
"""Roundings of a product x dv in the shoelace formula."""


COARSE = 0.01
"""Relative error of a polygon's area from which on the run is no longer judged."""
MIN_SAMPLES = 2
"""Smallest number of samples that are judged."""
SMOOTH = 0.45
"""Share of the difference between polygons of half and of a quarter of the points that bounds the
error of the whole polygon.

Less than a half: a stray point is in one of the two polygons, with twice the area that it has in
the whole.
"""
BROKEN = 4.0
"""The same share where friction breaks sides at turning points; 60 random outlines needed up to
1.1.
"""


class PhaseArea(Check):
    """The area that the outline encloses, at every sample."""

    name = "phase-area"
    title = "Area in phase space"
    judges = (Ensemble,)
    kills = (
        "hidden damping or driving, phase-space volume that is not conserved,"
        " points that are left behind"
    )

    def applies(self, subject: Subject) -> str | None:
        """Cases whose initial states form an outline."""
        if isinstance(subject.instance.case, EnsembleCase):
            return None
        return "the initial states do not form an outline"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest error of the area, in units of the initial area."""
        truth = certified(subject)
        case = subject.instance.case
        if truth is None or "area" not in truth.values:
            return [undecided(self.name, "area", no_truth(subject))]
        assert isinstance(case, EnsembleCase)
        x, v = case.outline(subject.instance.p, runs[subject.finest].trajectory)
        initial = abs(truth.value("area")[0])
        share = SMOOTH
        if "friction" in subject.instance.problem.features:
            share = BROKEN
        polygon_error = polygon(x, v, share) / initial
        count = truth.until
        # From the first sample at which the polygon is too coarse on nothing is judged.
        too_coarse = np.flatnonzero(polygon_error > COARSE)
        if len(too_coarse):
            count = min(count, int(too_coarse[0]))
        if count < MIN_SAMPLES:
            why = "the outline has too few points for the way it stretches"
            return [undecided(self.name, "area", why)]
        # |A(t) - A_true(t)|/A(0) <= polygon error + rounding S(t), with the growth S of errors.
        error = np.abs(phase_area(x, v)[:count] - truth.value("area")[:count]) / initial
        rounding_error = rounding(subject, x, v)[:count] * truth.growth()[:count] / initial
        allowed = polygon_error[:count] + rounding_error
        return [
            worst(
                check=self.name,
                quantity="area",
                t=subject.instance.times[:count],
                values=np.maximum(0.0, error - truth.radius("area")[:count] / initial),
                allowed=allowed,
                signal=1.0,
                unit="1",
                basis=(
                    "round-off of the points, plus the polygon error estimated from half and"
                    " a quarter of the points"
                ),
                what=("The error of the enclosed phase-space area, relative to the initial area,"),
            )
        ]


def polygon(x: Array, v: Array, part: float) -> Array:
    """Bound (T,) on the error of a polygon's area: `part` of the difference between the areas of
    half and of a quarter of its points.

    Straight sides cut off areas that fall with the square of their length. So the whole polygon
    lacks 1/12 of that difference where everything is smooth, and more where a turning point breaks
    a side.
    """
    # part max over s <= t of |A_(N/2)(s) - A_(N/4)(s)|.
    difference = np.abs(phase_area(x[:, ::2], v[:, ::2]) - phase_area(x[:, ::4], v[:, ::4]))
    bound: Array = part * np.maximum.accumulate(difference)
    return bound


def rounding(subject: Subject, x: Array, v: Array) -> Array:
    """Round-off (T,) of an area: one of x times the length of the outline in v, and the
    reverse.
    """
    # CORNER_ROUNDINGS u_n (max|v| length(x) + max|x| length(v)).
    largest_x, largest_v = (np.abs(column).max(axis=1) for column in (x, v))
    perimeter_area: Any = largest_v * _length(x) + largest_x * _length(v)
    area: Array = CORNER_ROUNDINGS * subject.round_off(subject.levels[-1]) * perimeter_area
    return area


def _length(column: Array) -> Array:
    """Total variation (T,) of a coordinate once round the outline."""
    length: Array = np.abs(np.diff(column, axis=1, append=column[:, :1])).sum(axis=1)
    return length


CHECK = PhaseArea()
