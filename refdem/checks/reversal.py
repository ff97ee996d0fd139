"""Time reversal: a run is continued from its end with velocities reversed, or with negative steps,
back to the start.

The *forward run* goes from the start to the end time T, the *backward run* from its final state to
the start. The *return defect* is the distance of the final state of the backward run from the
initial state, in units of each quantity's scale. S is the truth's bound on the growth of errors.
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
"""Largest bound on the return defect, relative to the scales, with which the finest level of the
plan decides; else that of `_predictable_level` is run as well.
"""
STEPS_LATE = 2.0
"""Steps by which fixed steps may be late for an impact: bodies that overlap at the end of one step
may change their velocities in the next.
"""
MAX_RETURN_HALVINGS = 4
"""Largest number of halvings of the finest step for which both runs are made. Errors grow in the
forward and in the backward run, so a motion may be predictable in the first and not in the second.
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
        """The finding on the order q of the return defect between a level and the next coarser one
        with a backward run: q = p if p is odd, q = p + 1 if p is even.

        The backward run, with reversed velocities, cancels a leading error term of even order. The
        observed order is

            log(d(h_c)/d(h)) / log(h_c/h)

        with the return defects d at the steps h and h_c > h. There is no finding where d(h) is at
        round-off, below the next term of the error, or larger than d(h_c), or if d(h_c) is at least
        HORIZON.
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

    It is the smallest of three bounds: from the claims of the method (`_claimed_defect`), from the
    error of the forward run against truth (`_defect_from_observed_error`), and from the defect at a
    larger step (`_extrapolated_defect`).
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
    """True if the backward run returns to the start to round-off: a reversible or exact method.

    Fixed steps that detect an impact late are excepted: the backward run detects it late as well,
    at another position.
    """
    is_reversible = subject.method.reversible and not _detects_impacts_late(subject)
    return is_reversible or subject.method.control == "exact"


def _detects_impacts_late(subject: Subject) -> bool:
    """True for fixed steps at whose ends collisions of rigid bodies are detected."""
    method = subject.method
    is_late = method.control == "step" and not method.locates_events
    return is_late and "contact:rigid" in subject.instance.scene.features


def _meets_too_soon(subject: Subject, level: float, bound: float) -> str | None:
    """None, or the reason why the backward run may end before it detects the first impact of the
    motion, which it meets last.

    The final velocities are then those that the motion has after that impact. An error of
    positions, `bound` in units of the length L, delays an impact by `bound` L/c, c the closing
    speed [m/s].
    """
    if not _detects_impacts_late(subject):
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

    Let D(s) be the Jacobian of the flow from the start to time s. An error e made at time s of the
    forward run is D(T) D(s)^-1 e at the end. To first order the backward run multiplies it by
    D(T)^-1, so that D(s)^-1 e is left at the start: the growth from s to T cancels. The backward
    run adds the same again.
    """
    # Reversible methods: e is round-off. Others: |D(s)^-1 e| <= E(T) min(columns, S), where
    # E(T) is the bound on the error at the end of the forward run.
    reached = _claimed_forward_error(subject, level)
    if _is_exact(subject):
        return _defect_bound(subject, _returned_rounding(subject, level), reached)
    return _defect_bound(subject, reached * _return_amplification(subject), reached)


def _returned_rounding(subject: Subject, level: float) -> float:
    """Bound on the error at the start due to the roundings e of one run, the sum of D(s)^-1 e.

    Roundings of random sign add as the root of the sum of their squares. For fixed steps they are
    made at all times s, so |D(s)^-1| enters by its root mean square over the run; else by its bound
    at the end. Roundings of equal terms (`flight`) have equal signs: they multiply velocities by a
    factor and move positions in proportion to time. Where only gravity acts, this equals a motion
    with scaled time, so that |D(s)^-1 e| <= (1 + 2 T/tau) |e| bounds them as well.
    """
    assert subject.truth is not None
    growth = subject.truth.growth()
    # |D(s)^-1| <= S(s) min(columns, S(s)), with S at the later end of each sample interval.
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
    """Factor min(columns, S) by which the backward run may amplify the error at the end of the
    forward run, which contains the factor S already.

    The flow of a reversible scene is symplectic: D^T J D = J, so D^-1 = J^-1 D^T J is D transposed,
    with rows and columns permuted and with signs. In the maximum norm, with |D| <= S,

        |D^-1| <= S columns,   and   |D^-1| <= S^2.
    """
    assert subject.truth is not None
    return min(_columns(subject), float(subject.truth.growth()[-1]))


def _columns(subject: Subject) -> float:
    """Largest number of columns of D in which one row may differ from 0: two for each coordinate of
    every body. For free bodies D is block diagonal, with two columns for each coordinate of the
    centre of one body, or of its attitude.
    """
    bodies = subject.instance.scene.bodies
    if _are_bodies_free(subject):
        return 2.0 * float(bodies.position.shape[1])
    columns = 2.0 * float(bodies.position.size)
    if "rotation" in subject.instance.scene.features:
        columns *= 2.0
    return columns


def _defect_bound(subject: Subject, each: float, reached: float) -> float:
    """Bound on the return defect from the error `each` that each of the two runs leaves at the
    start, and the error `reached` at the end of the forward run, in units of scales.
    """
    assert subject.truth is not None
    # 2 (each + reached^2 S): the second term is the error of second order.
    return 2 * (each + reached**2 * float(subject.truth.growth()[-1]))


def _claimed_forward_error(subject: Subject, level: float) -> float:
    """Bound on the error at the end of the forward run, from the claims of the method."""
    assert subject.truth is not None
    if not _is_exact(subject):
        return float(subject.bound(level)[-1])
    scattered, alike = _roundings(subject, level)
    return (scattered + alike) * float(subject.truth.growth()[-1])


def _roundings(subject: Subject, level: float) -> tuple[float, float]:
    """Relative round-off of both runs together before it grows: the part of random sign with that
    of the clock, and the part due to sums of equal terms.
    """
    # scattered = c u sqrt(2 n), alike = flight + turning; or scattered = sqrt(2) (far places) and
    # alike = 0 if that is more. The clock adds to `scattered`.
    instance = subject.instance
    scattered = math.sqrt(2.0) * subject.round_off(level)
    alike = flight(instance, subject.method, level)
    # A body that spins about a principal axis turns by the same rotation at every step.
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

    With the observed error E of the forward run, a safety factor f, the round-off floor and the
    error of a step across a kink (`straddled`), the error at the end is

        reached = f E + floor + straddled,

    and the backward run amplifies it by A, the bound being 2 (A reached + reached^2 S).

    - The backward run passes the same positions, and the singular values of a symplectic D come in
      pairs s, 1/s, so D^-1 has the same ones. Errors of no particular direction therefore grow as
      in the forward run, within a factor of `_columns`: A = min(columns, S).
    - Errors of equal steps may have a direction that grows in the backward run only. That of
      symplectic Euler is a displacement of the start (Hairer, Lubich and Wanner 2006, chapter IX),
      and the backward run has another start. For fixed steps A = S.
    - The floor is added since E may be small by chance, for example where no number is rounded.
    - With a tolerance, one run does not determine the steps next to a kink: the bound is infinite.
    """
    truth = certified(subject)
    assert truth is not None
    compared_level = _compared_level(subject, level)
    if truth.until < len(subject.instance.times):
        return math.inf
    if _detects_impacts_late(subject):
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
    # A = S for errors of equal steps, min(columns, S) for others.
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
    """The level whose observed error in the forward run bounds that of the backward run.

    Methods with a tolerance may choose other steps in the backward run, so a looser level is taken.
    """
    if subject.method.control == "tolerance" and len(subject.levels) > 1:
        return subject.levels[-2]
    return level


def _predictable_level(subject: Subject) -> float:
    """The level that decides if the finest one does not: the first of h, h/2, h/4, ...,
    h/2^MAX_RETURN_HALVINGS, from the finest h of the plan, at which the backward run is
    predictable, or h if it is so at none of them.

    The backward run is predictable where `_claimed_defect` is at most HORIZON, a tenth of the
    scale.
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
    """Return defect: the largest difference of the final state of a backward run from the initial
    state, each in units of its scale.

    The scales are L, V, the largest initial angular velocity (1/tau if no body turns), and 1 rad
    for the angle between attitudes.
    """
    start = subject.instance.scene.bodies
    end = back.end()
    scales = subject.instance.scales
    if change == "reversed":
        sign = -1.0
    else:
        sign = 1.0
    omega_scale = np.max(np.linalg.norm(start.omega, axis=1)) or 1.0 / scales.tau
    # A run with reversed velocities ends with minus the initial velocities; `sign` undoes this.
    position = float(np.max(np.abs(end["position"] - start.position)))
    velocity = float(np.max(np.abs(sign * end["velocity"] - start.velocity)))
    omega = float(np.max(np.abs(sign * end["omega"] - start.omega)))
    angle = 0.0
    if "rotation" in subject.instance.scene.features:
        angle = float(np.max(angle_between(end["attitude"], start.attitude)))
    return max(position / scales.length, velocity / scales.speed, omega / float(omega_scale), angle)


CHECK = Reversal()
