"""Lyapunov exponents (1.131)-(1.133): neighbours part exponentially where the motion is chaotic,
and as a power of time where not.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import certified, distances, followed, judged, no_truth, undecided
from refdem.core.problem import Iteration, Motion
from refdem.core.variant import Variant
from refdem.mechanics.stability import LARGEST_POWER, Growth, growth

APART = 2**26
"""Units in the last place, 1.5e-8, by which the neighbour starts off: far more than round-off, and
13 e-folds below SATURATED.
"""
SATURATED = 0.01
"""Neighbours further apart than this part of the scale no longer follow the linearised motion."""
LONG = 100.0
"""In units of tau: in a shorter time a regular motion cannot be told from a chaotic one."""
FEWEST = 9
"""Samples from which an exponent can be taken."""
CLEAR = 1.5
"""Times by which truth must pass the limits of the classifier before a run is held to them: chaos
has its quiet times.
"""
ERRORS = 2.0
"""Standard errors by which an exponent must be positive; of truth CLEAR times as many."""
FACTOR = 10.0
"""The neighbour starts off in one direction, S is the growth of the worst: in the mean over the
window they part by such a factor.
"""
FASTER = 2.0
"""S bounds what any start grows by on the same trajectory; neighbours that are not infinitely near
exceed it by at most so much.

Measured: 1.25 for 60 orbits of the logistic map, 1 for billiards and driven-duffing.
"""
SLOWER = 1000.0
"""S holds for all directions, and for what starts later; a start of its own grows less by such a
factor once in some thousand times.

Measured: 50 in 180 motions, where an orbit of the logistic map passed its middle, or a start lay
along what contracts.
"""
BESIDE = 1e-3
"""Part of the scale by which a run may be off and still meet the instability of the true motion at
the same samples.
"""


class Lyapunov(Check):
    """The exponent of two neighbouring runs, with its error bar, against that of truth, and what it
    makes of the motion.
    """

    name = "lyapunov"
    title = "Lyapunov exponent"
    judges = (Motion, Iteration)
    kills = (
        "a state that is rounded, so that neighbouring trajectories merge; energy"
        " that is fed in, so that they diverge"
    )

    def applies(self, subject: Subject) -> str | None:
        """Where the case says that it is chaotic, or that it is not and lasts long; methods whose
        neighbours can be compared.
        """
        scales = subject.instance.scales
        chaotic = subject.instance.case.is_chaotic(subject.instance.p)
        if chaotic is None:
            return "the case does not declare whether its motion is chaotic"
        if subject.method.control == "tolerance" or subject.method.precision != "double":
            return (
                "tolerances or single precision perturb neighbouring trajectories as much"
                " as their initial separation does"
            )
        if not chaotic and scales.duration < LONG * scales.tau:
            return f"a regular motion can be told from a chaotic one only after {LONG:g} tau"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The finest level, and the same from a start beside it."""
        return (subject.finest, Variant(subject.levels[-1], "perturbed", APART))

    def _of_regular_motion(
        self, subject: Subject, run: CompletedRun, apart: Array, seen: Growth
    ) -> Finding:
        """The power by which neighbours (T,) part, held to S where the true motion is unstable for
        a while.
        """
        count = len(apart)
        t = subject.instance.times[:count]
        truth = certified(subject)
        if truth is None or truth.until < count:
            return self._regular(seen, None)
        known = truth.growth()[:count]
        true = growth(t, known)
        is_unstable = true.power > LARGEST_POWER
        if is_unstable:
            follows = followed(subject, subject.levels[-1], run.trajectory, truth, BESIDE)
            if follows < count:
                why = (
                    "the true motion is transiently unstable and the run has left it, so the"
                    " separation of its neighbours does not apply"
                )
                return undecided(self.name, "power", why)
        # Neighbours of a regular motion part as the square of time at most.
        square = (t[-1] - t[0]) ** 2 / subject.instance.scales.tau**2
        if not is_unstable and known[-1] <= square:
            return self._regular(seen, true)
        room = float(np.log2(FASTER * known[-1] * apart[0] / np.max(apart)))
        return self._regular(seen, true, room)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The exponent, and the class of the motion."""
        plain, beside = self.needs(subject)
        if beside not in runs:
            return [
                undecided(
                    self.name, "exponent", "the engine refused the perturbed start during the run"
                )
            ]
        apart = distances(subject.instance, runs[beside].trajectory, runs[plain].trajectory)
        beyond = np.flatnonzero(apart > SATURATED)
        if len(beyond):
            count = int(beyond[0])
        else:
            count = len(apart)
        if not apart[0] > 0:
            return [undecided(self.name, "exponent", "the perturbed start equals the plain one")]
        if count < FEWEST:
            return [
                undecided(
                    self.name,
                    "exponent",
                    (
                        f"neighbouring trajectories saturate after {count} samples; request more"
                        " samples"
                    ),
                )
            ]
        t = subject.instance.times[:count]
        seen = growth(t, np.maximum(apart[:count], apart[0] * 2.0**-20))
        truth = certified(subject)
        if not subject.instance.case.is_chaotic(subject.instance.p):
            return [self._of_regular_motion(subject, runs[plain], apart[:count], seen)]
        if truth is None or truth.until < count:
            if truth:
                why = f"truth is certified for only {truth.until} of {count} samples"
            else:
                why = no_truth(subject)
            return [self._positive(seen), undecided(self.name, "exponent", why)]
        true = growth(t, truth.growth()[:count])
        if not (true.power > CLEAR * LARGEST_POWER and true.exponent > CLEAR * ERRORS * true.error):
            until = subject.instance.problem.when(t[-1])
            size = f"{true.exponent:.2g} +- {true.error:.1g}"
            why = (
                f"until {until} the neighbours of the true motion diverge with exponent"
                f" {size} and power {true.power:.2g}"
            )
            return [
                undecided(
                    self.name, "class", f"{why}, which is not enough to call the motion chaotic"
                )
            ]
        return [self._positive(seen), self._against_truth(subject, seen, true, t)]

    def _regular(self, seen: Growth, true: Growth | None, left: float = 0.0) -> Finding:
        """No faster than a power of the time, or than neighbours of the true motion part at the
        same samples.

        A body that passes close by a centre parts from its neighbour for a moment; samples may show
        that only near the end. Where the true motion is unstable for a while, S bounds how far any
        neighbours part: by `left` octaves more than these.
        """
        bound = LARGEST_POWER
        if true is not None:
            bound = max(bound, true.power)
        if left > 0 and seen.power > bound:
            bound = seen.power + left
        basis = (
            "in a regular motion neighbours separate no faster than t^2 (1.132), so"
            " the exponent is zero"
        )
        if bound > LARGEST_POWER:
            basis += "; those of the true motion separate as fast between these samples"
        return judged(
            check=self.name,
            quantity="power",
            value=max(0.0, seen.power),
            bound=bound,
            unit="1",
            basis=basis,
            what=(
                "The power of time with which neighbours separate at the end (exponent"
                f" {seen.exponent:.2g} +- {seen.error:.1g})"
            ),
        )

    def _positive(self, seen: Growth) -> Finding:
        """The finding that the exponent is two standard errors above zero, and grows faster than
        any power of time.
        """
        if seen.is_exponential(ERRORS):
            contradiction = 0.0
            verdict = "is that of"
        else:
            contradiction = 1.0
            verdict = "is not that of"
        return judged(
            check=self.name,
            quantity="class",
            value=contradiction,
            bound=0.0,
            unit="1",
            basis=(
                "in a chaotic motion neighbours separate as exp(lambda t) with lambda > 0 (1.133)"
            ),
            statement=(
                f"The exponent {seen.exponent:.4g} +- {seen.error:.2g} (power of time"
                f" {seen.power:.3g}) {verdict} a chaotic motion"
            ),
        )

    def _against_truth(self, subject: Subject, seen: Growth, true: Growth, t: Array) -> Finding:
        """The exponent that S has over the same time: error bars count only where the run is not on
        the same trajectory.
        """
        lasts = float(t[-1] - t[0])
        faster = seen.exponent > true.exponent
        bound = 3 * (seen.error + true.error) + float(np.log(FACTOR)) / lasts
        basis = (
            "three standard errors of both exponents, plus ln 10 over the time for"
            " the initial direction"
        )
        if faster:
            factor = FASTER
            beyond = f"except for a factor of {FASTER:g}"
        else:
            factor = SLOWER
            beyond = f"and few grow less by a factor of {SLOWER:g}"
        tight = float(np.log(factor)) / lasts
        if tight < bound and np.max(subject.bound(subject.levels[-1])[: len(t)]) < SATURATED:
            bound = tight
            basis = (
                "the run follows the true trajectory, where no perturbation grows by more"
                f" than S, {beyond}"
            )
        unit = "1"
        if isinstance(subject.instance.problem, Motion):
            unit = "1/s"
        return judged(
            check=self.name,
            quantity="exponent",
            value=abs(seen.exponent - true.exponent),
            bound=bound,
            unit=unit,
            basis=basis,
            what=(
                f"The error of the exponent ({seen.exponent:.4g} +- {seen.error:.2g}, true"
                f" {true.exponent:.4g})"
            ),
        )


CHECK = Lyapunov()
