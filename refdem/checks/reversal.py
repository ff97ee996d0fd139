"""Time reversal: a run is continued from its end with velocities reversed, or with negative steps,
back to the start.

The return defect is the distance of the state that comes back from the initial state, in units of
each quantity's scale. S is the truth's bound on the growth of errors.
"""

import math
from collections.abc import Mapping

import numpy as np

from refdem.checks._crossings import (
    closing_speed,
    is_corner_impact,
    is_impact,
    is_impacts_alone,
)
from refdem.checks._impacts import listed
from refdem.checks._kinks import may_straddle, straddled
from refdem.checks.order import WHOLE
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    PREDICTION_FACTOR,
    certified,
    judged,
    largest_so_far,
    no_truth,
    observed_order,
    order_statement,
    room_of,
    undecided,
)
from refdem.core.problem import Motion
from refdem.core.refinement import HORIZON, clock, flight, kinked, of_far_places, turning
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Change, Variant
from refdem.mechanics.quaternion import angle_between
from refdem.scene import Scene
from refdem.scene.elements.uniform_gravity import UniformGravity

CANCELLING = 0.5
"""Order beyond the claimed one with which an error falls where its leading terms cancel."""
SHARP = 1e-3
"""A bound on the return error, as a part of the scale, with which the finest level of the plan
decides: a motion that came back so closely was reversed.
"""
STEPS_LATE = 2.0
"""Steps by which fixed steps may be late for an impact: bodies that overlap at the end of one step
may change their velocities in the next.
"""
MAX_RETURN_HALVINGS = 4
"""Halvings of the finest step that are tried for the way back: errors grow on both ways, so a
motion may be predictable forward and not back.
"""


class Reversal(Check):
    """A reversible method returns to round-off; any other to its truncation error."""

    name = "reversal"
    title = "Time reversal"
    kills = "a force taken at the wrong time level, hidden dissipation, hidden state"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Scenes without a direction of time, and methods whose final state is complete."""
        if not subject.instance.scene.is_reversible():
            return "the system gains or loses energy, so its motion is not reversible"
        scene = subject.instance.scene
        runs_back = is_impacts_alone(scene) or is_corner_impact(scene)
        if "contact:rigid" in scene.features and not runs_back:
            return (
                "rigid impacts of spheres with each other and with planes, and of one corner with a"
                " plane, alone are run back"
            )
        if subject.method.complete_state:
            return None
        return "the final state of the method is incomplete, so a run cannot be continued from it"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The finest level plain, reversed, and backward where the method can; the two finest
        levels reversed where the defect has an order.
        """
        if _has_order(subject):
            pair = subject.levels[-2:]
        else:
            pair = ()
        variants = (
            *_both_ways(subject, subject.levels[-1]),
            *(Variant(h) for h in pair),
            *(Variant(h, "reversed") for h in pair),
        )
        return tuple(dict.fromkeys(variants))

    def further(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun]
    ) -> tuple[Variant, ...]:
        """The same at the level of `_predictable_level`, unless the finest of the plan decides."""
        level = _predictable_level(subject)
        if level == subject.levels[-1] or self._is_decided(subject, runs):
            return ()
        return _both_ways(subject, level)

    def _is_decided(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> bool:
        """True if the finest level of the plan passes, with bounds that are SHARP, and the order of
        the defect is observed or the defect is round-off.
        """
        level = subject.levels[-1]
        findings = {one.quantity: one for one in self._findings(subject, runs, level)}
        if any(one.outcome != "pass" for one in findings.values()):
            return False
        back = findings.get("reversed")
        if back is None or back.bound is None or back.bound > SHARP:
            return False
        truth = certified(subject)
        assert truth is not None
        round_off = subject.floor(level) * float(truth.growth()[-1]) ** 2
        is_round_off = back.value is not None and back.value <= round_off
        return is_round_off or not _has_order(subject) or "order" in findings

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The return defect against its bound, and, for methods that are not reversible, the order
        with which it falls.
        """
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "return", no_truth(subject))]
        if truth.until < len(subject.instance.times):
            why = (
                "no certified truth at the end, where the way back begins: what errors grow to by"
                " then is not known"
            )
            return [undecided(self.name, "return", why)]
        level = _predictable_level(subject)
        if Variant(level, "reversed") not in runs:
            level = subject.levels[-1]
        return self._findings(subject, runs, level)

    def _findings(
        self, subject: Subject, runs: Mapping[Variant, CompletedRun], level: float
    ) -> list[Finding]:
        """The findings of a level that was run both ways; the subject has truth."""
        truth = certified(subject)
        assert truth is not None
        growth = float(truth.growth()[-1])
        findings: list[Finding] = []
        if _has_order(subject) and len(subject.levels) > 1:
            findings = self._order(subject, runs, level, growth)
        bound, basis = _return_bound(subject, runs, level, growth)
        if bound > HORIZON:
            why = (
                "the bound on the return error exceeds a tenth of the scale: the run is"
                " longer than the predictability horizon"
            )
            return findings or [undecided(self.name, "return", why)]
        too_soon = _meets_too_soon(subject, level, bound)
        if too_soon:
            return [undecided(self.name, "return", too_soon)]
        for variant in _both_ways(subject, level):
            if variant.goes_on:
                findings.append(
                    judged(
                        check=self.name,
                        quantity=variant.change,
                        value=_defect(subject, runs[variant].trajectory, variant.change),
                        bound=bound,
                        unit="1",
                        basis=basis,
                        what=(
                            "The distance from the initial state after running forward and backward"
                            f" ({variant.change}), relative to each scale,"
                        ),
                    )
                )
        refusal = _refuses_negative_steps(subject)
        if subject.method.backward and refusal is not None:
            findings.append(
                Finding(
                    check=self.name,
                    quantity="backward",
                    outcome="unsupported",
                    sentence=f"Steps backwards in time were not tried: {refusal}.",
                )
            )
        return findings

    def _order(
        self,
        subject: Subject,
        runs: Mapping[Variant, CompletedRun],
        level: float,
        growth: float,
    ) -> list[Finding]:
        """The finding on the order of the return defect between a level and the next coarser one
        that is run back: p if p is odd, p + 1 if p is even.

        The backward run cancels a leading error term of even order. The observed order is

            log(d(h_c)/d(h)) / log(h_c/h)

        with the return defects d. There is no finding where the defect is at round-off, or below
        the next term of the error.
        """
        order = subject.order
        if order % 2:
            expected = order
        else:
            expected = order + 1
        run_back = {*subject.levels[-2:], level}
        finest, coarser = sorted(run_back)[:2]
        coarse, fine = (
            _defect(subject, runs[Variant(h, "reversed")].trajectory, "reversed")
            for h in (coarser, finest)
        )
        scales = subject.instance.scales
        method = subject.method
        # With the expected order q the next term of the error is C (T/tau) (h/tau)^(q + 1).
        next_term = (
            method.constant * scales.duration / scales.tau * (finest / scales.tau) ** (expected + 1)
        )
        floor = max(next_term, subject.floor(finest) * growth**2)
        # Below round-off or the next term of the error the leading term cannot be observed.
        if not floor < fine <= coarse < HORIZON:
            return []
        # log(d(h_c)/d(h)) / log(h_c/h).
        observed = math.log2(coarse / fine) / math.log2(coarser / finest)
        tolerance = max(0.15, 0.05 * expected)
        if tolerance < expected - observed < WHOLE:
            why = (
                f"the observed order {observed:.2f} of one pair of steps may still rise to"
                f" {expected}, that of the return error of a reversible method of order {order}"
            )
            return [undecided(self.name, "order", why)]
        return [
            judged(
                check=self.name,
                quantity="order",
                value=max(0.0, expected - observed),
                bound=tolerance,
                unit="1",
                basis=(
                    f"a reversible method of order {order} has a return error of order {expected},"
                    " within max(0.15, 0.05 p)"
                ),
                statement=order_statement(
                    observed,
                    expected,
                    max(0.0, expected - observed),
                    tolerance,
                    "return error at the finest pair of steps",
                ),
            )
        ]


def _return_bound(
    subject: Subject, runs: Mapping[Variant, CompletedRun], level: float, growth: float
) -> tuple[float, str]:
    """The bound on the return defect at a level, with its basis.

    It is the smallest of three: what the claims allow, what the forward run's error against truth
    implies, and what the defect at a larger step implies.
    """
    bound = _claimed_defect(subject, level)
    basis = "truncation error of the forward and backward runs, the first amplified on the way back"
    if _is_exact(subject):
        basis = (
            "a reversible method returns to round-off, c u sqrt(n) forward and"
            " backward, times the sensitivity S of both"
        )
    observed = _defect_from_observed_error(subject, runs, level)
    if observed < bound:
        bound = observed
        basis = "the backward run may add as much error as is observed in the forward run"
    extrapolated = _extrapolated_defect(subject, runs, level, growth)
    if extrapolated < bound:
        bound = extrapolated
        basis = "truncation error extrapolated from a larger step with the claimed order"
    return bound, basis


def _extrapolated_defect(
    subject: Subject, runs: Mapping[Variant, CompletedRun], level: float, growth: float
) -> float:
    """Bound on the defect at a level from that of a coarser level; infinite if unknown.

    With the defect d_c at the step h_c, the bound at the step h is

        PREDICTION_FACTOR d_c (h/h_c)^p + floor(h) S.

    If the error of the forward run falls faster than claimed, as on a circular orbit, terms of the
    error cancel, and they may cancel more in the coarser defect than in this one. Then d_c is the
    larger of the defect and the error of the forward run.
    """
    if not _has_order(subject) or len(subject.levels) < 3:
        return math.inf
    order = subject.order
    coarser = subject.levels[-2]
    coarse = _defect(subject, runs[Variant(coarser, "reversed")].trajectory, "reversed")
    truth = certified(subject)
    if truth is not None:
        forward, finest = (
            float(largest_so_far(subject, h, runs[Variant(h)].trajectory, truth)[-1])
            for h in subject.levels[-2:]
        )
        if observed_order(forward, finest) > order + CANCELLING:
            coarse = max(coarse, forward)
    # PREDICTION_FACTOR d_c (h/h_c)^p + floor(h) S.
    octaves = math.log2(coarser / level)
    of_order: float = PREDICTION_FACTOR * coarse / 2.0 ** (order * octaves)
    return of_order + subject.floor(level) * growth


def _is_exact(subject: Subject) -> bool:
    """True if the way back undoes the way forward to round-off.

    Steps that detect an impact late do so in the backward run as well, at another position.
    """
    is_reversible = subject.method.reversible and not _sees_impacts_late(subject)
    return is_reversible or subject.method.control == "exact"


def _sees_impacts_late(subject: Subject) -> bool:
    """True for fixed steps at whose ends collisions of rigid bodies are detected."""
    method = subject.method
    is_late = method.control == "step" and not method.locates_events
    return is_late and "contact:rigid" in subject.instance.scene.features


def _meets_too_soon(subject: Subject, level: float, bound: float) -> str | None:
    """None, or the reason why a backward run may end before it detects its last impact, the first
    one of the motion.

    It then ends with the velocities of before that impact. An error of positions, `bound` in units
    of the length L, delays an impact by `bound` L over the closing speed.
    """
    if not _sees_impacts_late(subject):
        return None
    truth = certified(subject)
    assert truth is not None
    instance = subject.instance
    impacts = listed(truth.scalars)
    if impacts:
        earliest = impacts[0].time - impacts[0].radius
        closing = impacts[0].closing
    elif _is_one_impact(instance.scene) and "impact_time" in truth.scalars:
        time, radius = truth.scalars["impact_time"]
        earliest = time - radius
        closing, _ = closing_speed(instance.scene)
    else:
        return "steps see impacts late, and truth does not say when the first one is"
    if closing > 0:
        # STEPS_LATE h + bound L/closing.
        delay = STEPS_LATE * level + bound * instance.scales.length / closing
    else:
        delay = math.inf
    if earliest > delay:
        return None
    return (
        f"in the backward run the first impact, {earliest:.3g} s after the start, may be missed:"
        f" steps of {level:.3g} s may detect it {delay:.3g} s late"
    )


def _is_one_impact(scene: Scene) -> bool:
    """True for two spheres, a sphere and a plane, or a box that comes down with one corner."""
    return is_impact(scene) or is_corner_impact(scene)


def _claimed_defect(subject: Subject, level: float) -> float:
    """Bound on the return defect at a level, from the claims of the method; needs truth.

    Let D(s) be the Jacobian of the flow from the start to time s. An error e made at time s becomes
    D(T) D(s)^-1 e at the end, and the way back takes it to D(s)^-1 e: to first order it undoes the
    growth on the way forward, and S counts once.
    """
    reached = _claimed_forward_error(subject, level)
    if _is_exact(subject):
        return _defect_bound(subject, _rounding_come_back(subject, level), reached)
    return _defect_bound(subject, reached * _return_amplification(subject), reached)


def _rounding_come_back(subject: Subject, level: float) -> float:
    """Bound on what the roundings of one way have become at the start, D(s)^-1 e of each.

    Roundings e of random sign add up to the root of the sum of squares. If they are spread over the
    steps of the way, D(s)^-1 counts by its root mean square, and not by its largest value. Those of
    equal terms, `flight`, stretch momenta and drift places. Where nothing but weight acts, that is
    a motion scaled in time, and

        D(s)^-1 e <= (1 + 2 T/tau) e,   if D(s)^-1 is not less.
    """
    assert subject.truth is not None
    growth = subject.truth.growth()
    # |D(s)^-1| <= S(s) times the columns, or S(s)^2, with S at the later end of each interval.
    inverse = growth[1:] * np.minimum(_columns(subject), growth[1:])
    if subject.method.control == "step":
        mean_inverse = float(np.sqrt(np.mean(inverse**2)))
    else:
        mean_inverse = float(inverse[-1])
    scattered, alike = _roundings(subject, level)
    alike_grows = mean_inverse
    if _are_bodies_free(subject):
        scales = subject.instance.scales
        alike_grows = min(mean_inverse, 1.0 + 2.0 * scales.duration / scales.tau)
    return scattered * mean_inverse + alike * alike_grows


def _are_bodies_free(subject: Subject) -> bool:
    """True if nothing but weight acts on the bodies."""
    elements = subject.instance.scene.elements
    return all(isinstance(element, UniformGravity) for element in elements)


def _return_amplification(subject: Subject) -> float:
    """Factor by which the way back may amplify errors, if S amplified them forward.

    The flow of a reversible scene is symplectic: D^-1 is D transposed with rows and columns in
    another order. So in the maximum norm |D^-1| is at most S times the number of columns, and at
    most S^2.
    """
    assert subject.truth is not None
    return min(_columns(subject), float(subject.truth.growth()[-1]))


def _columns(subject: Subject) -> float:
    """Columns of D in which a row is not 0: two for each coordinate. Those of free bodies are
    two for each coordinate of the centre of one body, or of its attitude.
    """
    bodies = subject.instance.scene.bodies
    if _are_bodies_free(subject):
        return 2.0 * float(bodies.position.shape[1])
    columns = 2.0 * float(bodies.position.size)
    if "rotation" in subject.instance.scene.features:
        columns *= 2.0
    return columns


def _defect_bound(subject: Subject, each: float, reached: float) -> float:
    """Defect bound 2 (each + reached^2 S): each way adds `each`, and the error `reached` at the end
    adds its square to second order.
    """
    assert subject.truth is not None
    return 2 * (each + reached**2 * float(subject.truth.growth()[-1]))


def _claimed_forward_error(subject: Subject, level: float) -> float:
    """Bound on the error at the end of the forward run, from the claims of the method."""
    assert subject.truth is not None
    if not _is_exact(subject):
        return float(subject.bound(level)[-1])
    scattered, alike = _roundings(subject, level)
    return (scattered + alike) * float(subject.truth.growth()[-1])


def _roundings(subject: Subject, level: float) -> tuple[float, float]:
    """Relative round-off of both ways before it grows: that of random sign with that of the clock,
    and that of sums of equal terms.
    """
    # c u sqrt(2 n), and flight, or that of far places if it is more; and that of the clock.
    instance = subject.instance
    scattered = math.sqrt(2.0) * subject.round_off(level)
    alike = flight(instance, subject.method, level)
    # Who spins about a principal axis turns by the same rotation at every step.
    if "tumbling" not in instance.scene.features:
        alike += turning(instance, subject.method, level)
    far = math.sqrt(2.0) * of_far_places(instance, subject.method, level)
    if far > scattered + alike:
        scattered, alike = far, 0.0
    return scattered + clock(instance, subject.method, level), alike


def _defect_from_observed_error(
    subject: Subject, runs: Mapping[Variant, CompletedRun], level: float
) -> float:
    """Bound on the return defect from the observed error of the forward run against truth; infinite
    if unknown.

    The way back passes the same positions, and D and D^-1 have the same singular values. So errors
    of no particular structure grow as much there as forward, within a factor of the columns. Errors
    of equal steps may have a structure that grows on the way back only: that of symplectic Euler is
    an offset of the start (Hairer, Lubich and Wanner 2006, chapter IX), and the way back starts
    elsewhere. These are given all of S. Round-off is added, since an error may be small by chance,
    as where no number has to be rounded, and so is what a step that straddles a kink is off by. One
    run does not determine the steps that a tolerance makes next to a kink.
    """
    truth = certified(subject)
    assert truth is not None
    compared_level = _compared_level(subject, level)
    if truth.until < len(subject.instance.times):
        return math.inf
    if _sees_impacts_late(subject):
        # The delay with which a step detects an impact is random, and differs in the backward run.
        return math.inf
    has_kinks = kinked(subject.instance, subject.method)
    if subject.method.control == "tolerance" and (has_kinks or compared_level == level):
        return math.inf
    if subject.method.control == "tolerance":
        safety = PREDICTION_FACTOR
    else:
        safety = room_of(subject)
    run = runs[Variant(compared_level)].trajectory
    observed = safety * float(largest_so_far(subject, compared_level, run, truth)[-1])
    reached = observed + subject.floor(level)
    if may_straddle(subject):
        off = straddled(subject, compared_level, run, truth.until)
        reached += max(float(of_quantity[-1]) for of_quantity in off.values())
    # Errors of equal steps may grow by all of S on the way back, others as on the way forward.
    if subject.method.control == "step":
        amplification = float(truth.growth()[-1])
    else:
        amplification = _return_amplification(subject)
    return _defect_bound(subject, reached * amplification, reached)


def _both_ways(subject: Subject, level: float) -> tuple[Variant, ...]:
    """A level plain, reversed, and backward where the method can; and the plain run whose error is
    compared.
    """
    back: tuple[Change, ...] = ("reversed",)
    if subject.method.backward and _refuses_negative_steps(subject) is None:
        back = ("reversed", "backward")
    variants = (
        Variant(level),
        Variant(_compared_level(subject, level)),
        *(Variant(level, change) for change in back),
    )
    return tuple(dict.fromkeys(variants))


def _refuses_negative_steps(subject: Subject) -> str | None:
    """None, or why a method that steps backwards in time does not do so in this scene."""
    instance = subject.instance
    return subject.unsupported(Motion(instance.scene, instance.times[::-1]))


def _compared_level(subject: Subject, level: float) -> float:
    """The level whose observed error stands for that of the way back.

    Methods with a tolerance may choose other steps on the way back, so a looser level is taken.
    """
    if subject.method.control == "tolerance" and len(subject.levels) > 1:
        return subject.levels[-2]
    return level


def _predictable_level(subject: Subject) -> float:
    """The level that decides if the finest one does not: the finest h, or the first of h/2, h/4,
    ..., h/2^MAX_RETURN_HALVINGS at which the way back is predictable.

    It is predictable where the defect that the method claims is at most HORIZON, a tenth of the
    scale. Where it is so at none of these levels the finest of the plan is taken.
    """
    finest = subject.levels[-1]
    if certified(subject) is None or subject.method.control != "step" or _is_exact(subject):
        return finest
    finer = (finest / 2**k for k in range(MAX_RETURN_HALVINGS + 1))
    return next((level for level in finer if _claimed_defect(subject, level) <= HORIZON), finest)


def _has_order(subject: Subject) -> bool:
    """True if the defect is a truncation error, and no kink within a step scatters it."""
    return (
        subject.method.control == "step"
        and not _is_exact(subject)
        and not kinked(subject.instance, subject.method)
    )


def _defect(subject: Subject, back: Trajectory, change: Change) -> float:
    """Largest difference between the initial state and the state that came back, in units of each
    scale.

    The angular velocity is scaled by the largest initial one, or 1/tau if none turns; attitudes
    differ by an angle.
    """
    start = subject.instance.scene.bodies
    end = back.end()
    scales = subject.instance.scales
    if change == "reversed":
        sign = -1.0
    else:
        sign = 1.0
    omega_scale = np.max(np.linalg.norm(start.omega, axis=1)) or 1.0 / scales.tau
    # A reversed run comes back with the initial velocities, of opposite sign.
    position = float(np.max(np.abs(end["position"] - start.position)))
    velocity = float(np.max(np.abs(sign * end["velocity"] - start.velocity)))
    omega = float(np.max(np.abs(sign * end["omega"] - start.omega)))
    angle = 0.0
    if "rotation" in subject.instance.scene.features:
        angle = float(np.max(angle_between(end["attitude"], start.attitude)))
    return max(position / scales.length, velocity / scales.speed, omega / float(omega_scale), angle)


CHECK = Reversal()
