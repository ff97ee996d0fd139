"""The area of an outline in phase space against Liouville's theorem: kept, falling as exp(-2 delta
t), or deposited (1.107)-(1.111).
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
"""Roundings in a product of the shoelace formula, each of the size of place times rate."""


COARSE = 0.01
"""Part of the area: a polygon that may be off by more is not judged, nor what comes after it."""
MIN_SAMPLES = 2
SMOOTH = 0.45
BROKEN = 4.0
"""Parts of that difference. Below a half, a point that is astray is seen: it is in one of the two
polygons with twice the area that it has in the whole. Where friction breaks sides at turning
points, 60 random heads needed up to 1.1."""


class PhaseArea(Check):
    """The area that the outline encloses, sample by sample."""

    name = "phase-area"
    title = "Area in phase space"
    judges = (Ensemble,)
    kills = (
        "hidden damping or driving, phase-space volume that is not conserved,"
        " points that are left behind"
    )

    def applies(self, subject: Subject) -> str | None:
        """None for cases whose starts are an outline, else the reason why not."""
        if isinstance(subject.instance.case, EnsembleCase):
            return None
        return "the initial states do not form an outline"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest error in units of the area at the start."""
        truth = certified(subject)
        case = subject.instance.case
        if truth is None or "area" not in truth.values:
            return [undecided(self.name, "area", no_truth(subject))]
        assert isinstance(case, EnsembleCase)
        x, v = case.outline(subject.instance.p, runs[subject.finest].trajectory)
        first = abs(truth.value("area")[0])
        part = SMOOTH
        if "friction" in subject.instance.problem.features:
            part = BROKEN
        straight = polygon(x, v, part) / first
        until = truth.until
        too_coarse = np.flatnonzero(straight > COARSE)
        if len(too_coarse):
            until = min(until, int(too_coarse[0]))
        if until < MIN_SAMPLES:
            return [
                undecided(
                    self.name, "area", "the outline has too few points for the way it stretches"
                )
            ]
        error = np.abs(phase_area(x, v)[:until] - truth.value("area")[:until]) / first
        allowed = (
            straight[:until] + rounding(subject, x, v)[:until] * truth.growth()[:until] / first
        )
        return [
            worst(
                check=self.name,
                quantity="area",
                t=subject.instance.times[:until],
                values=np.maximum(0.0, error - truth.radius("area")[:until] / first),
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
    """How far off (T,) the area of the outline's polygon may be: `part` of what polygons of half
    and of a quarter of its points differ by.

    Straight sides leave out areas that fall with the square of their length: all of them together
    are a twelfth of that difference where everything is smooth, and more where a turning point
    breaks a side.
    """
    differ = np.abs(phase_area(x[:, ::2], v[:, ::2]) - phase_area(x[:, ::4], v[:, ::4]))
    found: Array = part * np.maximum.accumulate(differ)
    return found


def rounding(subject: Subject, x: Array, v: Array) -> Array:
    """Round-off (T,) of an area: that of the points along the whole outline."""
    shift_x, shift_v = (np.abs(column).max(axis=1) for column in (x, v))
    around: Any = shift_v * _way(x) + shift_x * _way(v)
    found: Array = CORNER_ROUNDINGS * subject.round_off(subject.levels[-1]) * around
    return found


def _way(column: Array) -> Array:
    """The way (T,) that a coordinate goes on once round the outline."""
    found: Array = np.abs(np.diff(column, axis=1, append=column[:, :1])).sum(axis=1)
    return found


CHECK = PhaseArea()
