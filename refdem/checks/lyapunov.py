"""Lyapunov exponents (1.131)-(1.133) of two neighbouring runs.

Their distance grows as exp(lambda t) in a chaotic motion, and as a power of t in a regular one.
`mechanics.stability.growth` fits both to the distance at samples.
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
"""Units in the last place, 1.5e-8 of the state, by which the neighbour's start differs: far above
round-off, and 13 e-folds below SATURATED.
"""
SATURATED = 0.01
"""Distance, relative to the scale, beyond which neighbours no longer follow the linearised
motion.
"""
LONG = 100.0
"""Duration in tau below which a regular motion cannot be distinguished from a chaotic one."""
FEWEST = 9
"""Smallest number of samples from which an exponent is fitted."""
CLEAR = 1.5
"""Factor by which truth must exceed the limits of the classifier before a run is held to them:
chaotic motions have quiet times.
"""
ERRORS = 2.0
"""Standard errors by which an exponent must be positive; for truth CLEAR times as many."""
FACTOR = 10.0
"""Ratio of S, the growth of the worst perturbation, to that of the neighbour's, in the mean over
the fitted window.
"""
FASTER = 2.0
"""Factor by which neighbours may separate faster than S.

S bounds the growth of any infinitesimal perturbation of the same trajectory; neighbours at a finite
distance exceed it a little. Measured: 1.25 for 60 orbits of the logistic map, 1 for billiards and
driven-duffing.
"""
SLOWER = 1000.0
"""Factor by which neighbours may separate more slowly than S.

S holds for all directions and for perturbations that start later; one direction grows less by this
factor once in about a thousand times. Measured: 50 in 180 motions, where an orbit of the logistic
map passed its middle, or the initial difference lay along a contracting direction.
"""
BESIDE = 1e-3
"""Error of a run, relative to the scale, up to which it shows the true motion's instability at the
same samples.
"""


class Lyapunov(Check):
    """The exponent of two neighbouring runs with its standard error, against truth, and the class
    of the motion.
    """

    name = "lyapunov"
    title = "Lyapunov exponent"
    judges = (Motion, Iteration)
    kills = (
        "a state that is rounded, so that neighbouring trajectories merge; energy"
        " that is fed in, so that they diverge"
    )

    def applies(self, subject: Subject) -> str | None:
        """Cases that declare themselves chaotic, or regular and long; methods in double precision
        without a tolerance.
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
            return (
                f"a regular motion can be distinguished from a chaotic one only after {LONG:g} tau"
            )
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The finest level, and the same from a perturbed start."""
        return (subject.finest, Variant(subject.levels[-1], "perturbed", APART))

    def _of_regular_motion(
        self, subject: Subject, run: CompletedRun, separation: Array, observed: Growth
    ) -> Finding:
        """The finding on the power of time with which neighbours separate in a regular motion.

        `separation` (T,) is their distance. Where the true motion is unstable for a while (S grows
        faster than t^2), neighbours may separate as fast as S: only if the run follows the true
        motion is this judged.
        """
        count = len(separation)
        t = subject.instance.times[:count]
        truth = certified(subject)
        if truth is None or truth.until < count:
            return self._regular(observed, None)
        sensitivity = truth.growth()[:count]
        true_growth = growth(t, sensitivity)
        is_unstable = true_growth.power > LARGEST_POWER
        if is_unstable:
            follows = followed(subject, subject.levels[-1], run.trajectory, truth, BESIDE)
            if follows < count:
                why = (
                    "the true motion is transiently unstable and the run has left it, so the"
                    " separation of its neighbours does not apply"
                )
                return undecided(self.name, "power", why)
        # Neighbours of a regular motion part as the square of time at most.
        largest_regular = (t[-1] - t[0]) ** 2 / subject.instance.scales.tau**2
        if not is_unstable and sensitivity[-1] <= largest_regular:
            return self._regular(observed, true_growth)
        # log2 of how much further S would let them separate.
        octaves_left = float(np.log2(FASTER * sensitivity[-1] * separation[0] / np.max(separation)))
        return self._regular(observed, true_growth, octaves_left)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Findings on the class of the motion, and, where truth is certified, on the exponent."""
        plain, beside = self.needs(subject)
        if beside not in runs:
            why = "the engine refused the perturbed start during the run"
            return [undecided(self.name, "exponent", why)]
        separation = distances(subject.instance, runs[beside].trajectory, runs[plain].trajectory)
        if not separation[0] > 0:
            return [undecided(self.name, "exponent", "the perturbed start equals the plain one")]
        count = _until_saturated(separation)
        if count < FEWEST:
            why = f"neighbouring trajectories saturate after {count} samples; request more samples"
            return [undecided(self.name, "exponent", why)]
        t = subject.instance.times[:count]
        # Neighbours that meet by rounding have distance 0, whose logarithm is infinite: a floor of
        # 2^-20.
        observed = growth(t, np.maximum(separation[:count], separation[0] * 2.0**-20))
        if subject.instance.case.is_chaotic(subject.instance.p):
            return self._of_chaotic_motion(subject, t, observed)
        return [self._of_regular_motion(subject, runs[plain], separation[:count], observed)]

    def _of_chaotic_motion(self, subject: Subject, t: Array, observed: Growth) -> list[Finding]:
        """The findings that the motion is chaotic and its exponent that of truth, over times t
        (T,).

        Undecided where the true motion itself is not clearly chaotic over this time.
        """
        truth = certified(subject)
        count = len(t)
        if truth is None or truth.until < count:
            if truth:
                why = f"truth is certified for only {truth.until} of {count} samples"
            else:
                why = no_truth(subject)
            return [self._positive(observed), undecided(self.name, "exponent", why)]
        true_growth = growth(t, truth.growth()[:count])
        is_fast = true_growth.power > CLEAR * LARGEST_POWER
        is_positive = true_growth.exponent > CLEAR * ERRORS * true_growth.error
        if not (is_fast and is_positive):
            until = subject.instance.problem.when(t[-1])
            size = f"{true_growth.exponent:.2g} +- {true_growth.error:.1g}"
            why = (
                f"until {until} the neighbours of the true motion diverge with exponent"
                f" {size} and power {true_growth.power:.2g}, which is not enough to call the motion"
                " chaotic"
            )
            return [undecided(self.name, "class", why)]
        return [self._positive(observed), self._against_truth(subject, observed, true_growth, t)]

    def _regular(self, observed: Growth, true: Growth | None, octaves: float = 0.0) -> Finding:
        """The finding that neighbours separate no faster than a power of time, or than those of the
        true motion do.

        A body that passes close by a centre separates from its neighbour for a moment, which the
        samples may show only near the end. Where the true motion is unstable for a while, S allows
        neighbours to separate by `octaves` octaves more than they did.
        """
        bound = LARGEST_POWER
        if true is not None:
            bound = max(bound, true.power)
        if octaves > 0 and observed.power > bound:
            bound = observed.power + octaves
        basis = (
            "in a regular motion neighbours separate no faster than t^2 (1.132), so"
            " the exponent is zero"
        )
        if bound > LARGEST_POWER:
            basis += "; those of the true motion separate as fast between these samples"
        return judged(
            check=self.name,
            quantity="power",
            value=max(0.0, observed.power),
            bound=bound,
            unit="1",
            basis=basis,
            what=(
                "The power of time with which neighbours separate at the end (exponent"
                f" {observed.exponent:.2g} +- {observed.error:.1g})"
            ),
        )

    def _positive(self, observed: Growth) -> Finding:
        """The finding that the exponent is positive by two standard errors and the growth faster
        than any power of time.
        """
        if observed.is_exponential(ERRORS):
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
                f"The exponent {observed.exponent:.4g} +- {observed.error:.2g} (power of time"
                f" {observed.power:.3g}) {verdict} a chaotic motion"
            ),
        )

    def _against_truth(self, subject: Subject, observed: Growth, true: Growth, t: Array) -> Finding:
        """The finding on the exponent against that of S over the same time t (T,).

        The bound is three standard errors plus ln(FACTOR)/T for the initial direction. While the
        run follows the true trajectory, no perturbation grows faster than S, and few much slower:
        ln(FASTER)/T or ln(SLOWER)/T, if that is smaller.
        """
        duration = float(t[-1] - t[0])
        is_faster = observed.exponent > true.exponent
        # 3 (sigma_observed + sigma_true) + ln(FACTOR)/T.
        bound = 3 * (observed.error + true.error) + float(np.log(FACTOR)) / duration
        basis = (
            "three standard errors of both exponents, plus ln 10 over the time for"
            " the initial direction"
        )
        if is_faster:
            factor = FASTER
            exception = f"except for a factor of {FASTER:g}"
        else:
            factor = SLOWER
            exception = f"and few grow less by a factor of {SLOWER:g}"
        # While the run is on the true trajectory, its growth is between S/SLOWER and FASTER S.
        # ln(FASTER)/T or ln(SLOWER)/T.
        tight = float(np.log(factor)) / duration
        if tight < bound and np.max(subject.bound(subject.levels[-1])[: len(t)]) < SATURATED:
            bound = tight
            basis = (
                "the run follows the true trajectory, where no perturbation grows by more"
                f" than S, {exception}"
            )
        unit = "1"
        if isinstance(subject.instance.problem, Motion):
            unit = "1/s"
        return judged(
            check=self.name,
            quantity="exponent",
            value=abs(observed.exponent - true.exponent),
            bound=bound,
            unit=unit,
            basis=basis,
            what=(
                f"The error of the exponent ({observed.exponent:.4g} +- {observed.error:.2g}, true"
                f" {true.exponent:.4g})"
            ),
        )


def _until_saturated(separation: Array) -> int:
    """Number of samples before the distance (T,) of neighbours first exceeds SATURATED."""
    saturated = np.flatnonzero(separation > SATURATED)
    if len(saturated):
        return int(saturated[0])
    return len(separation)


CHECK = Lyapunov()
