"""Observed order of convergence: halving the step must divide the error by 2^p."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    MIXED,
    SMALL,
    Array,
    certified,
    errors,
    judged,
    no_truth,
    order_statement,
    predictable,
    signed,
    undecided,
)
from refdem.core.refinement import COUNTING_FLOOR, SCATTER, kinked, order_levels, scored, smoothness
from refdem.core.smoothness import singularities
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant

SURE = 3.5
"""Standard deviations by which a mean order must miss the claimed one: 1 in 4000 by chance."""
STUDENT = (float("inf"), 318.3, 22.3, 10.2, 7.2)
"""The same where the scatter is that of the errors themselves: 1 in 1000 by Student's t, by degrees
of freedom (Student 1908).
"""

LINE = 0.8
"""What an order must lack at least before errors on a line speak against it.

Halving a step doubles the place of a kink within it, so a place near the start of a step moves on
in order, and errors that kinks scatter may lie on a line for some octaves. Measured: of 3000
motions of velocity Verlet across fields with two random edges, a mean order that lacks 0.5 or more
on a line fails 13 at six levels; 0.8 or more, 3. A method of first order is failed in all 3000.
"""

WHOLE = 0.9
"""What one pair of levels must lack to speak against a claim: about a whole order.

It cannot tell a lack from a cancellation.
"""

CANCELLED = 0.1
"""Part of the errors that terms of the claimed order may leave. A term of the order below that
makes a tenth of them leaves 0.04, one that makes all of them 0.38. Measured where leading terms
cancel: 0.002 (RK4, Duffing's oscillator, pairs 5.6, 3.2, 3.5, 3.8)."""

RISE = 0.25
"""Octaves by which an error must rise from level to level to grow: errors that cancel, or scatter a
little, do so once.
"""

Seen = Mapping[float, Mapping[str, Array]]
"""Scaled errors (until,) by level and quantity."""


class Order(Check):
    """Pairs of neighbouring levels reach the claimed order as the step falls; with kinks in the
    motion, the mean over all levels.
    """

    name = "order"
    title = "Observed order"
    kills = "a wrong coefficient in the integrator, a force taken at the wrong time level"

    def applies(self, subject: Subject) -> str | None:
        """None for methods with a fixed step, else the reason why not."""
        if subject.method.control == "step":
            return None
        return f"the step control of the method is {subject.method.control}, not a fixed step"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level, and of finer ones where one pair shows little."""
        return tuple(Variant(level) for level in order_levels(subject.instance, subject.levels))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for the state: the largest scaled error of any quantity; one more if errors
        can be seen to grow or fall.
        """
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "state", no_truth(subject))]
        found = _seen(subject, runs, truth)
        if not found[subject.levels[0]]:
            return [undecided(self.name, "state", MIXED)]
        return [self._state(subject, runs, truth, found), *self._growth(subject, found)]

    def _state(
        self,
        subject: Subject,
        runs: Mapping[Variant, CompletedRun],
        truth: SampledTruth,
        found: Seen,
    ) -> Finding:
        """The observed order against the claimed one."""
        counting, common = _counting(subject)
        if len(counting) < 3:
            levels = len(self.needs(subject))
            why = (
                f"only {len(counting)} of {levels} refinement levels are usable (bound"
                " between 20 x round-off and 0.1 of the scale); 3 are needed"
            )
            return undecided(self.name, "state", why)
        floor = [COUNTING_FLOOR * _floor(subject, h) for h in counting]
        seen = [_largest(found[h], common) for h in counting]
        if all(error <= low for error, low in zip(seen[1:], floor[1:], strict=True)):
            return self._nothing_left(seen, floor)
        if kinked(subject.instance):
            above = [k for k in range(len(seen)) if seen[k] > floor[k]]
            return self._mean(subject, [counting[k] for k in above], [seen[k] for k in above])
        pairs = list(zip(pairwise(seen), floor[1:], strict=True))
        orders = [
            float(np.log2(a / b)) for (a, b), low in pairs if b > low
        ]  # no order in what is round-off
        shown = [h for h, error, low in zip(counting, seen, floor, strict=True) if error > low][-3:]
        # An error b that is rounded by a part r of itself is off by r/ln 2 octaves, and so is the
        # one before, by less.
        rounded = max(low / COUNTING_FLOOR / b for (_, b), low in pairs if b > low)
        before = [_largest(found[h], common) for h in subject.levels if h > counting[0]]
        earlier = [
            float(np.log2(a / b)) for a, b in pairwise([*before, seen[0]]) if b > 0 and a < SMALL
        ]
        expected = expected_lack([*earlier, *orders], subject.order) + 2 * rounded / float(
            np.log(2.0)
        )
        return self._deficit(
            subject, orders, expected, _misfits(subject, runs, truth, shown, common)
        )

    def _growth(self, subject: Subject, found: Seen) -> list[Finding]:
        """Errors at the three finest levels must not grow as the step falls, whatever bound they
        are within.

        Seen on the samples up to which all three are small: beyond, errors have no order. Where
        kinks scatter errors, all levels together must show it beyond chance.
        """
        levels = sorted(found, reverse=True)
        if len(levels) < 3:
            return []
        common = min(predictable(found[h]) for h in levels[-3:])
        if common < 2:
            return []
        seen = [_largest(found[h], common) for h in levels]
        above = all(
            error > COUNTING_FLOOR * _floor(subject, h)
            for h, error in zip(levels[-3:], seen[-3:], strict=True)
        )
        if not above:
            return []
        rises = [float(np.log2(fine / coarse)) for coarse, fine in pairwise(seen[-3:])]
        grows = min(rises) > RISE
        if kinked(subject.instance):
            slope, deviation, _ = mean_order(levels, seen)
            grows = grows and slope < -RISE and subject.order - slope > SURE * deviation
        rise = 0.0
        if grows:
            rise = max(0.0, sum(rises))
        listed = ", ".join(f"{error:.2g}" for error in seen)
        return [
            judged(
                check=self.name,
                quantity="growth",
                value=rise,
                bound=0.0,
                unit="octaves",
                basis=(
                    "the error of a convergent method cannot grow over three levels above"
                    " round-off as the step falls"
                ),
                what=(
                    "The growth of the error over the three finest levels (errors, coarse to"
                    f" fine: {listed})"
                ),
            )
        ]

    def _nothing_left(self, seen: list[float], floor: list[float]) -> Finding:
        """Round-off at every level but perhaps the coarsest."""
        first = 0
        what = "The error at every level"
        if not seen[0] <= floor[0]:
            first = 1
            what = "The error at every level but the coarsest"
        return judged(
            check=self.name,
            quantity="state",
            value=max(seen[first:]),
            bound=max(floor[first:]),
            unit="1",
            basis=(
                "20 times round-off, so no truncation error is left from which to observe an order"
            ),
            what=what,
        )

    def _deficit(
        self, subject: Subject, orders: list[float], expected: float, misfits: "Misfits | None"
    ) -> Finding:
        """What the order lacks at the end; one pair alone shows no limit, and decides only where it
        is nearer to another order.

        A lack that grows from pair to pair fails however small it is, if terms of a lower order
        tell the errors better.
        """
        claimed = subject.order
        tolerance = max(0.15, 0.05 * claimed)
        listed = ", ".join(f"{order:.2f}" for order in orders)
        lacking = lack(orders, claimed)
        if len(orders) == 1 and tolerance < claimed - orders[0] < WHOLE:
            why = (
                f"only one pair of levels is above round-off; its observed order {listed}"
                f" may still rise to the claimed {claimed}"
            )
            return undecided(self.name, "state", why)
        if lacking > tolerance and misfits is not None and not misfits.is_lower:
            return self._cancelled(subject, orders, misfits)
        basis = (
            f"order {claimed} is claimed, and pairs of levels must reach it within"
            " max(0.15, 0.05 p) as the step falls"
        )
        if expected < tolerance and (
            lacking <= expected or (misfits is not None and misfits.is_lower)
        ):
            tolerance = expected
            basis = (
                f"order {claimed} is claimed, and the deficit of pairs of levels must fall with the"
                " step"
            )
        return judged(
            check=self.name,
            quantity="state",
            value=lacking,
            bound=tolerance,
            unit="1",
            basis=basis,
            statement=order_statement(
                orders[-1], claimed, lacking, tolerance, f"by pairs of levels: {listed}"
            ),
            order_seen=orders[-1],
            order_claimed=float(claimed),
        )

    def _cancelled(self, subject: Subject, orders: list[float], misfits: "Misfits") -> Finding:
        """Pairs lack order because leading terms cancel: the errors themselves are made of terms of
        the claimed order and more.
        """
        claimed = subject.order
        listed = ", ".join(f"{order:.2f}" for order in orders)
        if misfits.claimed > CANCELLED:
            why = (
                f"the observed orders are {listed}, and error terms of order"
                f" {claimed - 1:g} fit the errors as well as those of order {claimed}"
            )
            return undecided(self.name, "state", why)
        return judged(
            check=self.name,
            quantity="state",
            value=misfits.claimed,
            bound=CANCELLED,
            unit="1",
            basis=(
                f"leading terms cancel here; a fit with orders {claimed - 1:g} and"
                f" {claimed:g} leaves {misfits.lower:.2g}"
            ),
            what=(
                f"The relative residual of the errors after a fit of a h^{claimed:g} + b"
                f" h^{claimed + 1:g} (observed orders {listed})"
            ),
            order_seen=orders[-1],
            order_claimed=float(claimed),
        )

    def _mean(self, subject: Subject, steps: list[float], seen: list[float]) -> Finding:
        """What the mean order lacks where the constant scatters: nearer to the claimed order than
        to the one below, or surely not.
        """
        claimed = subject.order
        limit = smoothness(subject.instance, subject.method)
        basis = (
            f"order {claimed} is claimed; kinks in the motion scatter the errors by a factor of 2,"
            " so the mean order is compared"
        )
        if limit is not None and claimed < subject.method.order_for(
            subject.instance.problem.features
        ):
            basis = (
                f"a force that varies as |s|^{limit.exponent:g} limits fixed steps to"
                f" order {claimed:g}; the method may declare {limit.key}"
            )
        if len(steps) < 2:
            return undecided(self.name, "state", "only one level is above round-off")
        slope, deviation, shown = mean_order(steps, seen)
        lacking = claimed - slope
        sure = min(
            SURE * deviation, max(LINE, STUDENT[min(len(steps) - 2, len(STUDENT) - 1)] * shown)
        )
        if 0.5 < lacking <= sure:
            why = (
                f"kinks scatter the errors; {len(steps)} levels above round-off cannot"
                f" distinguish the mean order {slope:.2f} from {claimed}"
            )
            return undecided(self.name, "state", why)
        if lacking > 0.5:
            basis += "; " + _declared(subject)
        return judged(
            check=self.name,
            quantity="state",
            value=max(0.0, lacking),
            bound=0.5,
            unit="1",
            basis=basis,
            statement=order_statement(
                slope,
                claimed,
                max(0.0, lacking),
                0.5,
                f"mean over {len(steps)} levels, standard deviation {deviation:.2f}",
            ),
            order_seen=slope,
            order_claimed=float(claimed),
        )


def mean_order(steps: list[float], errors: list[float]) -> tuple[float, float, float]:
    """Slope of log error over log step by least squares; its standard deviation if errors scatter
    by SCATTER octaves, and as shown.

    Errors that lie on a line of another slope show no scatter that could excuse it. Two points show
    none: infinite.
    """
    x = np.log2(steps) - np.mean(np.log2(steps))
    y = np.log2(errors) - np.mean(np.log2(errors))
    spread = float(x @ x)
    slope = float(x @ y) / spread
    left = len(x) - 2
    rest = float(np.sum((y - slope * x) ** 2))
    expected = SCATTER / float(np.sqrt(spread))
    # The standard error of a slope: residual variance over the spread of the abscissae.
    shown = float("inf")
    if left:
        shown = float(np.sqrt(rest / (left * spread)))
    return slope, expected, shown


def lack(orders: list[float], claimed: float) -> float:
    """What the orders of all pairs, coarse to fine, lack of the claimed one in the limit of small
    steps.

    An error term of lower order dominates at the finest pair, so that pair decides. Where terms of
    higher order still cancel part of the leading one, the lack halves at least from pair to pair:
    what is left of it when twice its fall is taken off the pair before counts, if the finest pair
    is already nearer to the claimed order than to the one below.
    """
    last = claimed - orders[-1]
    if len(orders) > 1 and last < 0.5:
        last = min(last, 2 * last - (claimed - orders[-2]))
    return max(0.0, last)


def expected_lack(orders: Sequence[float], claimed: float) -> float:
    """What an order may lack at the finest of three pairs or more, by what it lacks at those
    before; infinite for fewer.

    The next term of the error, b h^(p+1) beside a h^p, leaves a lack of about |b h/a|, which halves
    from pair to pair. With one term more, the lacks obey d3 = 3/4 d2 - 1/8 d1, so that |d3| is at
    most the larger of |d2| and |d1|/2, also where d1 or d2 is nearly nothing because both terms
    cancel. A term of the order below makes it double.
    """
    if len(orders) < 3:
        return float("inf")
    lacks = [abs(claimed - order) for order in orders]
    return max(lacks[-2], lacks[-3] / 2.0)


class Misfits(NamedTuple):
    """What two terms leave of the errors at the finest level, as a part of them: of the claimed
    order and the next, or one lower.
    """

    claimed: float
    lower: float

    @property
    def is_lower(self) -> bool:
        """The errors look more like those of a lower order."""
        return self.lower < self.claimed


def _misfits(
    subject: Subject,
    runs: Mapping[Variant, CompletedRun],
    truth: SampledTruth,
    levels: Sequence[float],
    common: int,
) -> Misfits | None:
    """How two terms fit the signed errors at three levels.

    None where there are fewer, or velocities lag behind the places.
    """
    if len(levels) < 3 or subject.method.delay(levels[0]) != 0:
        return None
    errors = [signed(subject, runs[Variant(h)].trajectory, truth, common) for h in levels]
    if not errors[-1].size:
        return None
    order = subject.order
    return Misfits(claimed=_left(errors, order, order + 1), lower=_left(errors, order - 1, order))


def _left(errors: Sequence[Array], first: float, second: float) -> float:
    """Largest part of the errors at h/4 that a h^first + b h^second, fitted to those at h and h/2,
    does not tell.

    Such errors obey e(h/4) = (x + y) e(h/2) - x y e(h) with x = 2^-first, y = 2^-second.
    """
    coarse, middle, fine = errors
    x = 2.0**-first
    y = 2.0**-second
    told = (x + y) * middle - x * y * coarse
    return float(np.max(np.abs(fine - told)) / np.max(np.abs(fine)))


def _declared(subject: Subject) -> str:
    """What to declare if the method has a lower order here and its author knows: the key of
    `refdem.toml`.
    """
    limits = [limit for _, limit in singularities(subject.instance.scene)]
    if limits:
        return f"if the method has a lower order here, declare {min(limits).key}"
    return "no force in the scene explains a lower order"


def _seen(subject: Subject, runs: Mapping[Variant, CompletedRun], truth: SampledTruth) -> Seen:
    """Scaled errors of every quantity at every level that an order is read from."""
    levels = order_levels(subject.instance, subject.levels)
    return {
        h: errors(subject.instance, runs[Variant(h)].trajectory, truth, subject.method.delay(h))
        for h in levels
    }


def _largest(scaled: Mapping[str, Array], common: int) -> float:
    """The largest error of any quantity at the first `common` samples."""
    return max(float(np.max(error[:common])) for error in scaled.values())


def _counting(subject: Subject) -> tuple[list[float], int]:
    """Levels whose bound lies between 20 x round-off and a tenth of the scale, and the samples that
    all of them score.

    Where the sensitivity carries every bound past a tenth, the levels are compared on the samples
    that the third finest scores, or the fourth where kinks scatter the errors.
    """
    truth = subject.truth
    assert truth is not None
    levels = order_levels(subject.instance, subject.levels)
    ranges = {h: scored(subject.bound(h)) for h in levels}
    if kinked(subject.instance):
        third = 3
    else:
        third = 2
    common = min(
        len(truth.growth()),
        max(sorted(ranges.values(), reverse=True)[min(third, len(ranges) - 1)], 0),
    )
    if common < 2:
        return [], 0
    allowed: dict[float, Array] = {h: subject.bound(h)[:common] for h in levels}
    counting = [
        h
        for h in levels
        if ranges[h] >= common and allowed[h][-1] >= COUNTING_FLOOR * _floor(subject, h)
    ]
    return counting, common


def _floor(subject: Subject, level: float) -> float:
    """Round-off at a level, that of the clock too, times the sensitivity."""
    assert subject.truth is not None
    return subject.noise(level) * float(subject.truth.growth()[-1])


CHECK = Order()
