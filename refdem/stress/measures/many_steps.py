"""As many steps as time allows: the quadratic form that a method's own linear map conserves must
stay constant.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from refdem.core import refinement
from refdem.core.case import Canonical, Instance
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.engine import Method
from refdem.core.finding import Finding
from refdem.core.judgement import undecided, worst
from refdem.core.refinement import HORIZON
from refdem.core.variant import Variant
from refdem.stress.measures.measure import Measure

SAMPLES = 256
"""Sample intervals of a point; points are multiples of it, so that a sample falls on a step."""
PER_TAU = 10
"""Steps per tau (63 a period). Not a power of two: sums of such steps would be exact and hide an
inaccurate clock.
"""
ILL = 1e4
"""Condition number of the fit above which the samples cover too little of the ellipse."""


@dataclass(frozen=True)
class ManySteps(Measure):
    """The point is the number of steps of a harmonic oscillator, a multiple of SAMPLES; methods
    without steps run as long.
    """

    needs_truth: bool = False

    def instance(self, case: Canonical, parameters: Mapping[str, str], x: Fraction) -> Instance:
        """The case with the duration of x steps of tau/PER_TAU."""
        tau = case.at(**parameters).scales.tau
        duration = x * Fraction(tau) / PER_TAU
        return case.at(**{"samples": str(SAMPLES), **parameters, "duration": str(duration)})

    def levels(self, instance: Instance, method: Method, x: Fraction) -> tuple[float, ...]:
        """The step; for methods with a tolerance the finest one."""
        if method.control == "step":
            return (float(instance.times[1]) / float(x / SAMPLES),)
        return super().levels(instance, method, x)

    def checks(self, subject: Subject, x: Fraction) -> tuple[Check, ...]:
        """The check of secular drift."""
        return (Drift(),)


class Drift(Check):
    """The quadratic form that the run conserves in its first quarter is constant to the end.

    A symplectic step of a linear oscillator conserves a quadratic form a x^2 + b x v + c v^2
    exactly, close to the energy but different. So its change is drift alone, without the
    oscillation that truncation makes of the energy (Hairer, Lubich and Wanner 2006, IX).
    """

    name = "drift"
    title = "Drift"
    kills = "energy drift, biased round-off, accumulated error of the clock"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Always: the sweeps are on oscillators without loss."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the only level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest change of the quadratic form."""
        run = runs[subject.finest].trajectory
        level = subject.levels[-1]
        scales = subject.instance.scales
        x = run.position[:, 0, 0] / scales.length
        v = run.velocity[:, 0, 0] / scales.speed
        terms = np.stack([x * x, x * v, v * v], axis=1)
        quarter = len(terms) // 4
        first = terms[:quarter]
        if not np.all(np.isfinite(terms)) or np.linalg.cond(first) > ILL:
            return [undecided(self.name, "form", "the samples cover too little of the motion")]
        # a, b, c of a x^2 + b x v + c v^2 = 1, fitted to the first quarter.
        coefficients, *_ = np.linalg.lstsq(first, np.ones(len(first)), rcond=None)
        form = terms @ coefficients
        allowed, basis = bound(subject, level)
        # The fit distributes a change within the first quarter over all of its samples, so that the
        # bound there is that at its end.
        allowed = np.maximum(allowed, allowed[quarter])
        if allowed[-1] > HORIZON:
            return [
                undecided(
                    self.name, "form", "truncation error may exceed a tenth of the quadratic form"
                )
            ]
        return [
            worst(
                check=self.name,
                quantity="form",
                t=run.t,
                values=np.abs(form - 1.0),
                allowed=allowed,
                unit="1",
                basis=basis,
                what=(
                    "The relative change of the quadratic form that is conserved in the first"
                    " quarter of the run"
                ),
            )
        ]


def bound(subject: Subject, level: float) -> tuple[Array, str]:
    """Largest change of the form (T,) with its basis: round-off c u sqrt(n) for symplectic and
    exact methods, else truncation too.

    The rounded frequency shifts the phase by u T/tau, to which no quadratic form is sensitive: that
    part of the ordinary round-off is left out.
    """
    scales = subject.instance.scales
    own_steps = refinement.steps_at(subject.instance, subject.method, level)
    steps = own_steps + refinement.CLOCK_STEPS * (scales.duration / scales.tau)
    # Twice c u sqrt(n): of x and of v.
    largest = 2 * refinement.ROUND_OFF_FACTOR * subject.method.round_off * math.sqrt(steps)
    rounding = np.full(len(subject.instance.times), largest)
    if subject.method.symplectic or subject.method.control == "exact":
        return (
            rounding,
            (
                "a symplectic step conserves a quadratic form, so only round-off, c u"
                " sqrt(n) in x and in v, may change it"
            ),
        )
    return (
        rounding + 2 * subject.truncation(level),
        "truncation error of the claimed order, in x and in v",
    )
