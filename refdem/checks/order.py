"""Observed order of convergence: halving the step must divide the error by 2^p."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import Array, certified, errors, judged, no_truth, undecided
from refdem.core.refinement import COUNTING_FLOOR, scored
from refdem.core.variant import Variant


class Order(Check):
    """Pairs of neighbouring levels reach the claimed order as the step falls."""

    name = "order"
    title = "Observed order"
    kills = "a wrong coefficient in the integrator, a force taken at the wrong time level"

    def applies(self, trial: Trial) -> str | None:
        """Methods with a fixed step."""
        return None if trial.method.control == "step" else f"the method is controlled by {trial.method.control}, not by a step"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return trial.plain

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """One finding for the state: the largest scaled error of any quantity."""
        truth = certified(trial)
        if truth is None:
            return [undecided(self.name, "state", no_truth(trial))]
        counting, common = _counting(trial)
        if len(counting) < 3:
            why = f"of {len(trial.levels)} levels {len(counting)} can count (a bound between 20 x round-off and 0.1); 3 are needed"
            return [undecided(self.name, "state", why)]
        floor = [COUNTING_FLOOR * _floor(trial, h) for h in counting]
        scaled = [errors(trial.instance, runs[Variant(h)].trajectory, truth, trial.method.delay(h)) for h in counting]
        seen = [max(float(np.max(error[:common])) for error in quantities.values()) for quantities in scaled]
        if all(error <= low for error, low in zip(seen, floor, strict=True)):
            return [
                judged(
                    check=self.name,
                    quantity="state",
                    value=max(seen),
                    bound=max(floor),
                    unit="1",
                    basis="20 times round-off, so there is no truncation error left to halve",
                    what="The error at every level",
                )
            ]
        return [self._deficit(trial, seen, floor)]

    def _deficit(self, trial: Trial, seen: list[float], floor: list[float]) -> Finding:
        """What the order lacks; a pair whose finer error is round-off has nothing to show."""
        claimed = trial.method.order_for(trial.instance.scene.features)
        orders = [float(np.log2(a / b)) for (a, b), low in zip(pairwise(seen), floor[1:], strict=True) if b > low] or [float(claimed)]
        listed = ", ".join(f"{order:.2f}" for order in orders)
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

    Where the sensitivity carries every bound past a tenth, the levels are compared on the samples that the third finest scores.
    """
    truth = trial.truth
    assert truth is not None
    ranges = {h: scored(trial.bound(h)) for h in trial.levels}
    common = min(len(truth.growth()), max(sorted(ranges.values(), reverse=True)[min(2, len(ranges) - 1)], 0))
    if common < 2:
        return [], 0
    allowed: dict[float, Array] = {h: trial.bound(h)[:common] for h in trial.levels}
    counting = [h for h in trial.levels if ranges[h] >= common and allowed[h][-1] >= COUNTING_FLOOR * _floor(trial, h)]
    return counting, common


def _floor(trial: Trial, level: float) -> float:
    """Round-off at a level, times the sensitivity."""
    assert trial.truth is not None
    return trial.round_off(level) * float(trial.truth.growth()[-1])


CHECK = Order()
