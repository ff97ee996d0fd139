"""Observed order of convergence: halving the step must divide the error by 2^p."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import MIXED, Array, certified, errors, judged, no_truth, undecided
from refdem.core.refinement import COUNTING_FLOOR, SCATTER, kinked, order_levels, scored
from refdem.core.variant import Variant

SURE = 3.5
"""Standard deviations by which a mean order must miss the claimed one: 1 in 4000 by chance."""
STUDENT = (float("inf"), 318.3, 22.3, 10.2, 7.2)
"""The same where the scatter is that of the errors themselves: 1 in 1000 by Student's t, by degrees of freedom (Student 1908)."""

LINE = 0.8
"""What an order must lack at least before errors on a line speak against it.

Halving a step doubles the place of a kink within it, so a place near the start of a step moves on in order, and errors that kinks
scatter may lie on a line for some octaves. Measured: of 3000 motions of velocity Verlet across fields with two random edges, a
mean order that lacks 0.5 or more on a line fails 13 at six levels; 0.8 or more, 3. A method of first order is failed in all 3000.
"""


class Order(Check):
    """Pairs of neighbouring levels reach the claimed order as the step falls; with kinks in the motion, the mean over all levels."""

    name = "order"
    title = "Observed order"
    kills = "a wrong coefficient in the integrator, a force taken at the wrong time level"

    def applies(self, trial: Trial) -> str | None:
        """Methods with a fixed step."""
        return None if trial.method.control == "step" else f"the method is controlled by {trial.method.control}, not by a step"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The plain run of every level, and of finer ones where one pair shows little."""
        return tuple(Variant(level) for level in order_levels(trial.instance, trial.levels))

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """One finding for the state: the largest scaled error of any quantity."""
        truth = certified(trial)
        if truth is None:
            return [undecided(self.name, "state", no_truth(trial))]
        counting, common = _counting(trial)
        if len(counting) < 3:
            why = f"of {len(self.needs(trial))} levels {len(counting)} can count (a bound between 20 x round-off and 0.1); 3 are needed"
            return [undecided(self.name, "state", why)]
        floor = [COUNTING_FLOOR * _floor(trial, h) for h in counting]
        scaled = [errors(trial.instance, runs[Variant(h)].trajectory, truth, trial.method.delay(h)) for h in counting]
        if not scaled[0]:
            return [undecided(self.name, "state", MIXED)]
        seen = [max(float(np.max(error[:common])) for error in quantities.values()) for quantities in scaled]
        if all(error <= low for error, low in zip(seen[1:], floor[1:], strict=True)):
            return [self._nothing_left(seen, floor)]
        if kinked(trial.instance):
            above = [k for k in range(len(seen)) if seen[k] > floor[k]]
            return [self._mean(trial, [counting[k] for k in above], [seen[k] for k in above])]
        pairs = zip(pairwise(seen), floor[1:], strict=True)
        return [self._deficit(trial, [float(np.log2(a / b)) for (a, b), low in pairs if b > low])]  # no order in what is round-off

    def _nothing_left(self, seen: list[float], floor: list[float]) -> Finding:
        """Round-off at every level but perhaps the coarsest."""
        from_first = seen[0] <= floor[0]
        return judged(
            check=self.name,
            quantity="state",
            value=max(seen if from_first else seen[1:]),
            bound=max(floor if from_first else floor[1:]),
            unit="1",
            basis="20 times round-off, so there is no truncation error left to halve",
            what="The error at every level" if from_first else "The error at every level but the coarsest",
        )

    def _deficit(self, trial: Trial, orders: list[float]) -> Finding:
        """What the order lacks at the end; one pair alone shows no limit, and decides only where it is nearer to another order."""
        claimed = trial.method.order_for(trial.instance.scene.features)
        listed = ", ".join(f"{order:.2f}" for order in orders)
        if len(orders) == 1 and max(0.15, 0.05 * claimed) < claimed - orders[0] < 0.5:
            why = f"one pair of levels above round-off shows order {listed}, which may still rise to the claimed {claimed}"
            return undecided(self.name, "state", why)
        return judged(
            check=self.name,
            quantity="state",
            value=lack(orders, claimed),
            bound=max(0.15, 0.05 * claimed),
            unit="1",
            basis=f"order {claimed} is claimed and the pairs of levels must reach it, as the step falls, within max(0.15, 0.05 p)",
            what=f"The observed order from pair to pair is {listed}; what it lacks at the end",
            order_seen=orders[-1],
            order_claimed=float(claimed),
        )

    def _mean(self, trial: Trial, steps: list[float], seen: list[float]) -> Finding:
        """What the mean order lacks where the constant scatters: nearer to the claimed order than to the one below, or surely not."""
        claimed = trial.method.order_for(trial.instance.scene.features)
        if len(steps) < 2:
            return undecided(self.name, "state", "one level alone is above round-off")
        slope, deviation, shown = mean_order(steps, seen)
        lacking, sure = claimed - slope, min(SURE * deviation, max(LINE, STUDENT[min(len(steps) - 2, len(STUDENT) - 1)] * shown))
        if 0.5 < lacking <= sure:
            why = f"kinks scatter the errors; {len(steps)} levels above round-off cannot tell the mean order {slope:.2f} from {claimed}"
            return undecided(self.name, "state", why)
        return judged(
            check=self.name,
            quantity="state",
            value=max(0.0, lacking),
            bound=0.5,
            unit="1",
            basis=f"order {claimed} is claimed; kinks in the motion scatter the errors by a factor of 2, so the mean order counts",
            what=f"The observed order over {len(steps)} levels is {slope:.2f} +- {deviation:.2f}; what it lacks",
            order_seen=slope,
            order_claimed=float(claimed),
        )


def mean_order(steps: list[float], errors: list[float]) -> tuple[float, float, float]:
    """Slope of log error over log step by least squares; its standard deviation if errors scatter by SCATTER octaves, and as shown.

    Errors that lie on a line of another slope show no scatter that could excuse it. Two points show none: infinite.
    """
    x, y = np.log2(steps) - np.mean(np.log2(steps)), np.log2(errors) - np.mean(np.log2(errors))
    spread = float(x @ x)
    slope, left = float(x @ y) / spread, len(x) - 2
    rest = float(np.sum((y - slope * x) ** 2))
    return slope, SCATTER / float(np.sqrt(spread)), float(np.sqrt(rest / (left * spread))) if left else float("inf")


def lack(orders: list[float], claimed: int) -> float:
    """What the orders of all pairs, coarse to fine, lack of the claimed one in the limit of small steps.

    An error term of lower order dominates at the finest pair, so that pair decides. Where terms of higher order still cancel
    part of the leading one, the lack halves at least from pair to pair: what is left of it when twice its fall is taken off the
    pair before counts, if the finest pair is already nearer to the claimed order than to the one below.
    """
    last = claimed - orders[-1]
    if len(orders) > 1 and last < 0.5:
        last = min(last, 2 * last - (claimed - orders[-2]))
    return max(0.0, last)


def _counting(trial: Trial) -> tuple[list[float], int]:
    """Levels whose bound lies between 20 x round-off and a tenth of the scale, and the samples that all of them score.

    Where the sensitivity carries every bound past a tenth, the levels are compared on the samples that the third finest scores,
    or the fourth where kinks scatter the errors.
    """
    truth = trial.truth
    assert truth is not None
    levels = order_levels(trial.instance, trial.levels)
    ranges = {h: scored(trial.bound(h)) for h in levels}
    third = 3 if kinked(trial.instance) else 2
    common = min(len(truth.growth()), max(sorted(ranges.values(), reverse=True)[min(third, len(ranges) - 1)], 0))
    if common < 2:
        return [], 0
    allowed: dict[float, Array] = {h: trial.bound(h)[:common] for h in levels}
    counting = [h for h in levels if ranges[h] >= common and allowed[h][-1] >= COUNTING_FLOOR * _floor(trial, h)]
    return counting, common


def _floor(trial: Trial, level: float) -> float:
    """Round-off at a level, that of the clock too, times the sensitivity."""
    assert trial.truth is not None
    return trial.noise(level) * float(trial.truth.growth()[-1])


CHECK = Order()
