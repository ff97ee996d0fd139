"""Derivatives that a program computes, compared with the certified derivatives of a case.

A program differentiates the states x that it reports by numbers s of its scene. With the numbers p
of the case this is a matrix of its quantities q,

    D_qp = dq/dp = sum over s of dq/dx dx/ds ds/dp + dq/dp at fixed x   (core/scene_numbers.py).

Each column is judged in units of its own size G_p = max |D_qp| / scale_q so far, the largest of any
quantity at any sample up to then. The derivatives of a method of order p are those of the equations
of first variation by the same method, so that they have its order: the error of a column is at most

    PREDICTION_FACTOR bound(h) max(G_p, 1/|p|).

The second term is for a number to which the motion is insensitive: an error bound(h) of the state
that depends on p may change by all of itself when p does by all of itself. Where the
error falls as h^p, it follows from the changes by the last halvings of the step, as for a state
(checks/error.py): e(h/2) = |D(h) - D(h/2)| / (2^p - 1). A program may take its derivatives by
central differences of its runs: the rounding that these leave is allowed.

A step that is left out is an error of order h, which shows where p is 2 or more.

Fixed steps across a force that goes as |s|^n leave an error h^(n+1) in the state, and h^n in a
derivative: p is at most n there, and the claimed bound(h) of order n + 1 is one of h^n less
(tau/h)^(p-n). Where a force jumps, n = 0: derivatives of the steps are none of the motion, however
small the step, and fail.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from refdem.checks._crossings import crossings, has_crossings
from refdem.checks.order import order_deficit
from refdem.core.check import Array, CertifiedMatrix, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    ATTITUDE,
    PREDICTION_FACTOR,
    SMALL,
    Sight,
    certified,
    judged,
    no_truth,
    observed_order,
    order_statement,
    undecided,
)
from refdem.core.refinement import COUNTING_FLOOR, kinked, scored
from refdem.core.scene_numbers import (
    CaseNumber,
    known_rates,
    observed_slopes,
    rounding_of_differences,
    rounding_of_slopes,
)
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import NotCertifiedError
from refdem.scene.singularity import JUMP, sharpest_exponent

MOST_BODIES = 100
"""Largest number of bodies of a scene for which derivatives are requested."""
PARTS = (0.25, 0.5, 0.75, 1.0)
"""Parts of the certified motion after which derivatives are judged."""
DIFFERENCES = 2.0**-36
"""Relative error of the differences by which scene and quantities are differentiated: 2^-43, by
cancellation up to a hundred times as much. Rounding adds to it (core/scene_numbers.py).
"""
FELT = 2.0**-10
"""Smallest |p| G_p of a column that sets the scale of its errors: the change of a quantity, in
units of its scale, for a relative change 1 of p. Below it, errors are judged in units of FELT/|p|.
"""
LARGEST = 1e250
"""Size of a derivative from which on sums and products with scales may overflow."""
TOLERANCE = 0.5
"""Deficit of the order of derivatives that is allowed. Terms of higher order are larger in
derivatives than in states, and the order of an incorrect derivative is lower by one.
"""


@dataclass(frozen=True, eq=False)
class Column:
    """The derivatives by one number of the case in units of their size, at the judged samples.

    `errors` and `slopes` (levels, quantities, samples) are those of every level, `floor` (samples,)
    is the error that rounding may cause, `weak` (samples,) is the factor max(1, 1/(|p| G_p)) on the
    claimed error of a column of this size.
    """

    number: str
    quantities: tuple[str, ...]
    errors: Array
    slopes: Array
    floor: Array
    weak: Array


class Gradient(Check):
    """Every derivative that a method computes converges to the certified one with the order of the
    method.
    """

    name = "gradient"
    title = "Derivatives"
    kills = (
        "a derivative without that of the impact time, with the wrong sign or unit, of another"
        " number, or of the step before"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Methods in double precision that differentiate, and scenes of few bodies."""
        if not subject.method.differentiates:
            return "the method does not differentiate"
        if subject.method.precision != "double":
            return "derivatives are judged in double precision only"
        if len(subject.instance.scene.bodies) > MOST_BODIES:
            return f"derivatives are asked for of at most {MOST_BODIES} bodies"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """Every level with its derivatives."""
        return tuple(Variant(level, "differentiated") for level in subject.levels)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding on the size of the errors, and one on their order where they show one."""
        truth = certified(subject)
        if truth is None or subject.derivatives is None:
            return [undecided(self.name, "matrix", no_truth(subject))]
        samples = _samples(subject, truth)
        if not samples:
            why = "no sample before the predictability horizon is clear of events"
            return [undecided(self.name, "matrix", why)]
        try:
            times = tuple(float(subject.instance.times[n]) for n in samples)
            matrix = subject.derivatives(subject, times)
        except NotCertifiedError as error:
            return [undecided(self.name, "matrix", str(error))]
        failure = _missing_derivatives(subject, runs, matrix)
        if failure:
            return [failure]
        columns = _columns(subject, runs, truth, samples, matrix)
        if not columns:
            return [undecided(self.name, "matrix", "no derivative is certified at these numbers")]
        findings = [self._matrix(subject, columns, samples)]
        order = self._order(subject, columns)
        if order is not None:
            findings.append(order)
        return findings

    def _matrix(
        self, subject: Subject, columns: Sequence[Column], samples: Sequence[int]
    ) -> Finding:
        """The finding on the derivative that is furthest out of its bound at the finest level."""
        # PREDICTION_FACTOR (tau/h)^(p - n) bound(h).
        of_state = subject.bound(subject.levels[-1])[list(samples)]
        claimed = PREDICTION_FACTOR * _lost_order(subject) * of_state
        worst: tuple[float, float, float, str] | None = None
        for column in columns:
            allowed = _allowed(subject, column, claimed)
            # Largest error over its bound, by sample; the sample where this is largest is reported.
            share = np.max(column.errors[-1] / allowed, axis=0)
            sample = int(np.argmax(share))
            quantity = int(np.argmax(column.errors[-1][:, sample]))
            derivative = f"derivative of {column.quantities[quantity]} by {column.number}"
            what = (
                f"The error of the {derivative} at"
                f" {subject.instance.times[samples[sample]]:.6g} s, in units of the largest"
                " derivative by that number,"
            )
            entry = (
                float(share[sample]),
                float(column.errors[-1][quantity, sample]),
                float(allowed[sample]),
                what,
            )
            if worst is None or entry[0] > worst[0]:
                worst = entry
        assert worst is not None
        _, value, bound, what = worst
        return judged(
            check=self.name,
            quantity="matrix",
            value=value,
            bound=bound,
            unit="1",
            basis="the claimed order, and what the last halvings of the step change",
            what=what,
            sight=Sight(bound, 1.0),
        )

    def _order(self, subject: Subject, columns: Sequence[Column]) -> Finding | None:
        """The finding on the order of the largest error of any derivative; None where no two levels
        have errors that show one.
        """
        if subject.method.control != "step" or kinked(subject.instance, subject.method):
            return None
        usable = _usable(columns)
        if len(usable) < 2:
            return None
        orders = [observed_order(coarse, fine) for coarse, fine in pairwise(usable)]
        claimed = _derivative_order(subject)
        deficit = order_deficit(orders, claimed)
        statement = order_statement(
            orders[-1], claimed, deficit, TOLERANCE, "largest error of any derivative"
        )
        return judged(
            check=self.name,
            quantity="order",
            value=deficit,
            bound=TOLERANCE,
            unit="1",
            basis="derivatives of a method have its order",
            statement=statement,
            order_seen=orders[-1],
            order_claimed=claimed,
        )


def _missing_derivatives(
    subject: Subject, runs: Mapping[Variant, CompletedRun], matrix: CertifiedMatrix
) -> Finding | None:
    """The failure of a run that lacks the derivatives by some requested number, or whose
    derivatives overflow; None if there is none.
    """
    for number in matrix.numbers:
        rates = _rates(subject, matrix, number) or {}
        for level in subject.levels:
            run = runs[Variant(level, "differentiated")].trajectory
            for key in rates:
                reason = _refusal(run, key)
                if reason:
                    return Finding(
                        check="gradient", quantity="matrix", outcome="fail", sentence=reason
                    )
    return None


def _rates(
    subject: Subject, matrix: CertifiedMatrix, number: CaseNumber
) -> dict[str, float] | None:
    """The derivatives of the scene by a number of the case by which the method differentiates."""
    start_only = subject.method.start_only
    return known_rates(subject.instance, matrix.p, number, start_only=start_only)


def _refusal(run: Trajectory, key: str) -> str:
    """The reason why the derivatives of a run by a number of the scene cannot be compared; empty
    if they can be.
    """
    if key not in run.derivatives:
        return f"The run has no derivatives by {key}, which the request asked for."
    largest = float(np.max(np.abs(run.derivatives[key]), initial=0.0))
    if largest > LARGEST:
        return (
            f"The run has a derivative by {key} of size {largest:.2g}; expected at most"
            f" {LARGEST:g}, as sums of larger ones overflow."
        )
    return ""


def _usable(columns: Sequence[Column]) -> list[float]:
    """The largest error of any derivative at every level at which it is clear of rounding, of those
    columns that are so at the most levels.
    """
    of_columns = []
    for column in columns:
        # An error shows an order where it is above rounding and below SMALL.
        largest = np.max(column.errors, axis=(1, 2))
        floor = COUNTING_FLOOR * float(np.max(column.floor))
        of_columns.append(largest[(floor < largest) & (largest < SMALL)])
    most = max(len(errors) for errors in of_columns)
    clear = [errors for errors in of_columns if len(errors) == most]
    return [float(error) for error in np.max(clear, axis=0)]


def _derivative_order(subject: Subject) -> float:
    """The order to which derivatives are held: that of the state, or n where fixed steps cross a
    force that goes as |s|^n.
    """
    method = subject.method
    order = float(subject.order)
    if method.control != "step" or method.locates_events:
        return order
    scene = subject.instance.scene
    # The state has order n + 1 there, and its derivative by a parameter one less.
    continuous = [limit for _, limit in scene.singularities() if limit.exponent > JUMP]
    return min(order, sharpest_exponent(continuous))


def _lost_order(subject: Subject) -> float:
    """(tau/h)^(p-n): how much more than the state a derivative may err at the finest level."""
    # p - n, the claimed order of the state less that of derivatives.
    lost = subject.order - _derivative_order(subject)
    if lost <= 0.0:
        return 1.0
    return float((subject.instance.scales.tau / subject.levels[-1]) ** lost)


def _scatters(subject: Subject) -> bool:
    """True if kinks scatter the error from step to step."""
    return kinked(subject.instance, subject.method) and not subject.method.locates_events


def _samples(subject: Subject, truth: SampledTruth) -> list[int]:
    """The samples at which derivatives are judged: the last ones before PARTS of the motion up to
    the predictability horizon that are clear of events.

    They are further from every event than an eighth of the sample interval, and, for fixed steps,
    than the coarsest step.
    """
    count = scored(subject.bound(subject.levels[-1]))
    times = subject.instance.times
    margin = abs(float(subject.instance.problem.interval)) / 8
    if subject.method.control == "step":
        margin = max(margin, subject.levels[0])
    events: list[float] = []
    if has_crossings(subject.instance.scene):
        known = crossings(subject, truth).values()
        events = [crossing.time for of_kind in known for crossing in of_kind]
    chosen = []
    for part in PARTS:
        sample = round(part * (count - 1))
        while sample > 0 and any(abs(times[sample] - event) <= margin for event in events):
            sample -= 1
        if sample > 0:
            chosen.append(sample)
    return sorted(set(chosen))


def _columns(
    subject: Subject,
    runs: Mapping[Variant, CompletedRun],
    truth: SampledTruth,
    samples: Sequence[int],
    matrix: CertifiedMatrix,
) -> list[Column]:
    """The column of every number p of the case by which derivatives are certified.

    With D_q the certified derivative of the quantity q by p, r_q the radius of its certified
    interval and s_q the scale of q, errors and slopes are in units of s_q G, where

        G(t) = max(FELT/|p|, max over q and s <= t of |D_q(s)|/s_q).
    """
    # floor(h) S(t) + DIFFERENCES, with the growth S of errors made earlier.
    rounding = subject.floor(subject.levels[-1]) * truth.growth()[list(samples)] + DIFFERENCES
    columns = []
    for number in matrix.numbers:
        rates = _rates(subject, matrix, number)
        proved = [of_time for of_time in matrix.of if number.name in next(iter(of_time.values()))]
        if rates is None or len(proved) < len(samples):
            continue
        reported = []
        value = abs(float(number.of(matrix.p))) or 1.0
        noise = subject.noise(subject.levels[-1])
        left = 0.0
        for level in subject.levels:
            run = runs[Variant(level, "differentiated")].trajectory
            left = max(left, rounding_of_slopes(subject.instance, matrix.p, number, run, rates))
            of_program = rounding_of_differences(subject.instance, matrix.p, run, rates, noise)
            left = max(left, of_program)
            reported.append(observed_slopes(subject.instance, matrix.p, number, run, rates))
        names = tuple(name for name in reported[0] if name in matrix.of[0] and name not in ATTITUDE)
        if not names:
            continue
        scales = np.array([subject.instance.quantities[name].scale for name in names])[:, None]
        proven = np.array([[row[name][number.name] for row in matrix.of] for name in names])
        # G(t) = max(FELT/|p|, max over q and s <= t of |D_q(s)|/s_q).
        sizes = np.maximum.accumulate(np.max(np.abs(proven[..., 0]) / scales, axis=0))
        sizes = np.maximum(sizes, FELT / value)
        unit = scales * sizes
        # max(0, |D_run - D_q| - r_q) / (s_q G).
        slopes = np.array([[of[name][list(samples)] for name in names] for of in reported])
        errors = np.maximum(0.0, np.abs(slopes - proven[..., 0]) - proven[..., 1])
        # floor(h) S(t) + DIFFERENCES + left/G;   weak = max(1, 1/(|p| G)).
        floor = rounding + left / sizes
        weak = np.maximum(1.0, 1.0 / (value * sizes))
        columns.append(Column(number.name, names, errors / unit, slopes / unit, floor, weak))
    return columns


def _allowed(subject: Subject, column: Column, claimed: Array) -> Array:
    """The error (samples,) that is allowed at the finest level: the claimed one, or what the last
    halvings of the step imply if that is less; and rounding.
    """
    claimed = claimed * column.weak
    allowed = claimed
    levels = len(subject.levels)
    if subject.method.control == "step" and levels >= 3 and not _scatters(subject):
        ratio = 2.0 ** _derivative_order(subject)
        # c_k = max over q of |D(h_k) - D(h_(k+1))|, the change by each halving of the step.
        changes = np.max(np.abs(np.diff(column.slopes, axis=0)), axis=1)
        # Terms of the last change may cancel; the change before it implies 2^-p times its own.
        change = np.maximum(changes[-1], changes[-2] / ratio)
        # PREDICTION_FACTOR max over s <= t of c(s) / (2^p - 1): what a sum of further changes, each
        # 2^-p of the one before, leaves.
        implied = PREDICTION_FACTOR * np.maximum.accumulate(change) / (ratio - 1.0)
        allowed = np.minimum(claimed, implied)
    bound: Array = allowed + column.floor
    return bound


CHECK = Gradient()
