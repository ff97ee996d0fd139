"""Impulses between samples of two spheres, or of a sphere and a wall: inside the friction cone, and
of the size that the contact law gives.

    J = m (v(t') - v(t)) = sum over steps and stages of w_k h F_k,   sum of w_k = 1 in each step

Each step adds forces that the law gives for states near the step. So, for any method, the impulse
J = m dv of an interval between two samples is a weighted sum of such forces; J_n is its component
along the mean normal, J_t the size of the part across it.

The scheme determines these states. Position and velocity may belong to the start, the middle or the
end of a step, and to different instants: in velocity Verlet the dashpot uses the velocity of the
half step. Weights sum to 1. They are positive except in multistep and high-order rules (Adams and
Bashforth: -1/2; Dormand and Prince: -0.32 in total), which matters where forces jump in a step.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import undecided, worst
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

Mask = NDArray[np.bool_]

STEPS_A_SAMPLE = 4
"""Smallest number of steps between samples: the normal hardly turns in so few, and no method has
more stages.
"""
MOST_DENSE = 64
"""Largest number of samples in place of one."""
TERMS = 8.0
"""Number of roundings in a difference of two velocities: three coordinates of each of two vectors,
and two normals.
"""
STEPS_OF_SLIP = 2.0
"""Steps of friction within which a slip may alternate: friction of the step before and after."""


def alternating_slip(subject: Subject, run: Trajectory, step: float) -> float | None:
    """The largest slip [m/s] that one step of friction produces where friction may alternate in
    sign from step to step; 0 where it may not.

    It may alternate without a tangential spring, since its direction is that of the slip, and a
    slip of 0 is left with what the last step of friction produced. None where it may alternate in
    a scene that this check does not judge.
    """
    scene = subject.instance.scene
    soft = [law for law in scene.all(Contact) if law.law != "rigid"]
    if not any(law.friction > 0 and law.tangential_stiffness == 0 for law in soft):
        return 0.0
    if CHECK.applies(subject) is not None:
        return None
    contact = _Contact.of(subject, run, step)
    touches = contact.may_touch[1:] | contact.may_touch[:-1]
    # The slip may change its sign where the spheres touch and do not slide throughout.
    alternates = touches & ~contact.slides_throughout
    return float(np.max(contact.slip_change_of_step[alternates], initial=0.0))


def slip_in_scales(subject: Subject, slip: float) -> float:
    """A slip s [m/s] as a change of velocity or of spin, in units of their scales: max(s/V, s/(R
    W)).
    """
    scales = subject.instance.scales
    bodies = subject.instance.scene.bodies
    smallest = float(np.min(bodies.radius[bodies.radius > 0]))
    omega_scale = float(np.max(np.linalg.norm(bodies.omega, axis=1))) or 1.0 / scales.tau
    return max(slip / scales.speed, slip / smallest / omega_scale)


class ContactImpulse(Check):
    """Impulses between samples, for two spheres alone or for one and a wall: a sum of forces, each
    of which obeys the law.

    cone: each force obeys |Ft| <= mu Fn, so it lies in the cone of half angle arctan(mu) about its
    own normal. A cone is convex, so the sum, whatever the weights of the method, lies in the cone
    of half angle arctan(mu) + a about the mean normal, where a is the angle by which normals turn
    between the samples. That is twice what samples within the interval need, and includes stages
    that are evaluated a step ahead. The statement has no truncation error. It is not made for
    tangential springs: a spring at its limit may be extrapolated through a step and pass the limit
    within the order of the method.

    normal: the mean normal force lies between the smallest and the largest force of the law at the
    four samples around the interval, so that forces of the step before or after are covered. The
    bound adds the curvature of the force between samples, from the time scale of the contact and
    from spheres that pass each other; half of its change where a method takes forces of earlier
    steps with negative weights; the change of c d' in a step, since a dashpot may use the velocity
    of another instant than that of the overlap; and the impulse of one step where the force jumps
    between the samples. An error that does not depend on the step is visible at the coarsest one.

    sliding: where a sphere slides along a wall without a tangential spring, each force obeys |Ft| =
    mu Fn, and neither the normal nor, in a plane, the direction of slip turns: the sum obeys it
    too, to round-off. Rolling is excluded: there friction alternates from step to step, and the
    slip is at most the change by one step of friction.
    """

    name = "contact-impulse"
    title = "Impulse between samples"
    kills = (
        "a friction limit of the previous step or without the dashpot, a contact"
        " that ends too early, a wrong contact law, a coefficient of friction"
        " wrong in any retained digit"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """Two free spheres, or one and a wall, under a contact law with an overlap and no other
        force, integrated with fixed steps.
        """
        scene = subject.instance.scene
        laws = scene.all(Contact)
        walls = scene.all(Plane)
        if subject.method.control != "step":
            return f"the step control of the method is {subject.method.control}, not a fixed step"
        if len(scene.elements) != 1 + len(walls) or len(laws) != 1 or laws[0].law == "rigid":
            return "a force acts other than a contact with overlap"
        spheres = all(isinstance(shape, Sphere) for shape in scene.bodies.shape)
        are_two = len(scene.bodies) + len(walls) == 2 and len(walls) <= 1
        if spheres and are_two and not scene.bodies.fixed.any():
            return None
        return "the scene is neither two free spheres nor one sphere and a wall"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The coarsest level, where a force that is late by a step is furthest off, with a sample
        every few steps.
        """
        return (_dense_variant(subject),)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Findings `normal`, `cone` and `sliding`, where they apply, in units of mass times speed
        scale.
        """
        variant = _dense_variant(subject)
        run = runs[variant].trajectory
        scene = subject.instance.scene
        law = scene.all(Contact)[0]
        contact = _Contact.of(subject, run, variant.level)
        unit = scene.bodies.mass[0] * subject.instance.scales.speed
        fastest = float(np.max(np.abs(run.velocity))) / subject.instance.scales.speed
        # Rounding of m dv in units of m V: TERMS u_n max(1, |v|/V).
        rounding = TERMS * subject.round_off(subject.levels[0]) * max(1.0, fastest)
        unresolved = subject.unresolved(variant.level)
        if unresolved:
            findings = [undecided(self.name, "normal", unresolved)]
        else:
            findings = [self._normal(contact, unit, rounding)]
        presses = contact.pushes_throughout
        if law.friction > 0 and law.tangential_stiffness == 0 and presses.any():
            findings.append(
                worst(
                    check=self.name,
                    quantity="cone",
                    t=run.t[1:][presses],
                    # max(0, |J_t| cos(b) - J_n sin(b)) with the half angle b = arctan(mu) + a.
                    values=(_outside_cone(contact) / unit)[presses],
                    allowed=(contact.impulse_of_unlike_step / unit + rounding)[presses],
                    unit="1",
                    basis=(
                        "every force satisfies |Ft| <= mu Fn, hence so does their sum, to"
                        " round-off, at any step, but for the impulse of a step where the"
                        " contact begins or ends or the slip reverses"
                    ),
                    what=(
                        "The impulse between two samples in excess of the friction cone, in units"
                        " of mass times speed,"
                    ),
                )
            )
        if law.friction > 0 and law.tangential_stiffness == 0 and scene.all(Plane):
            findings += self._sliding(contact, unit, rounding)
        return findings

    def _sliding(self, contact: "_Contact", unit: float, rounding: float) -> list[Finding]:
        """The finding | |J_t| - mu J_n | = 0 of the intervals in which a sphere slides along a
        wall; none if it never does.
        """
        friction = contact.law.friction
        is_judged = contact.pushes_throughout & contact.slides_throughout
        if not is_judged.any():
            return []
        # A negative weight on the last step of a contact may reverse the sign of the sum.
        normal_impulse = np.abs(contact.normal_impulse)
        # | |J_t| - mu |J_n| |.
        difference = np.abs(contact.tangential_impulse - friction * normal_impulse)
        # | |J_t| - mu |J_n| | <= mu |J_n| a: forces whose directions differ by at most a, the turn
        # of the slip, have a sum shorter than the sum of their sizes, by at most that.
        turning = friction * normal_impulse * contact.slip_turn
        allowed = rounding * (1 + friction) + turning / unit
        return [
            worst(
                check=self.name,
                quantity="sliding",
                t=contact.run.t[1:][is_judged],
                values=(difference / unit)[is_judged],
                allowed=allowed[is_judged],
                unit="1",
                basis=(
                    "every force of a sliding contact satisfies |Ft| = mu Fn, hence so does"
                    " their sum, to round-off, at any step"
                ),
                what=(
                    "The difference between the tangential impulse between two samples and mu"
                    " times the normal impulse, in units of mass times speed,"
                ),
            )
        ]

    def _normal(self, contact: "_Contact", unit: float, rounding: float) -> Finding:
        """The finding that J_n of every interval lies between those of the smallest and largest
        force of the law nearby.
        """
        interval = np.diff(contact.run.t)
        # low dt <= J_n <= high dt.
        low, high = contact.normal_force_nearby
        below = np.maximum(0.0, low * interval - contact.normal_impulse)
        above = np.maximum(0.0, contact.normal_impulse - high * interval)
        # Within a contact the force deviates from its chord by F'' dt^2/8, with F'' about
        # 4 F/tau^2, hence by F (dt/tau)^2/2. Where a contact begins or ends between two samples,
        # these give the force up to F' dt, with F' about F/tau, hence up to F dt/tau.
        interval_share = interval / contact.tau
        relative_change = np.where(contact.begins_or_ends, interval_share, interval_share**2 / 2.0)
        curvature = contact.largest_force * interval * relative_change
        # Where spheres pass each other, the overlap along straight paths deviates from its chord.
        passing = contact.force_of_passing * interval
        # Multistep weights 3/2 and -1/2 leave half of the last force minus half of the one before
        # the first.
        extrapolated = contact.kept_by_multistep_weights
        # c |d''| h: the dashpot may use the velocity of an instant up to one step away.
        mixed_states = contact.change_of_dashpot * interval
        # c |d'| h: one step across the jump of the dashpot's force at a touch, of negative weight.
        jump = np.where(contact.begins_or_ends, contact.dashpot_nearby * contact.step, 0.0)
        # J_t a: friction across one normal has a component along another at the angle a to it.
        tilt = contact.tangential_impulse * contact.normal_turn
        return worst(
            check=self.name,
            quantity="normal",
            t=contact.run.t[1:],
            values=np.maximum(below, above) / unit,
            allowed=(curvature + passing + extrapolated + mixed_states + jump + tilt) / unit
            + rounding,
            unit="1",
            basis=(
                "the impulse must lie between those of the smallest and largest forces"
                " that the law gives near the interval, plus their curvature, and the change"
                " of the dashpot's force in a step"
            ),
            what=(
                "The normal impulse between two samples in excess of the range of the"
                " surrounding forces, in units of mass times speed,"
            ),
        )


def _dense_variant(subject: Subject) -> Variant:
    """The coarsest level with 2^k samples in place of one, as many as leave STEPS_A_SAMPLE steps
    between them.
    """
    level = subject.levels[0]
    stride = round(subject.instance.problem.interval / level)
    dense = 1
    while (
        2 * dense <= MOST_DENSE
        and stride % (2 * dense) == 0
        and stride // (2 * dense) >= STEPS_A_SAMPLE
    ):
        dense *= 2
    if dense > 1:
        return Variant(level, "denser_output", dense)
    return Variant(level)


@dataclass(frozen=True)
class _Contact:
    """One contact in a run with T samples: its geometry, and the forces of its law.

    overlap, rate, normal: (T,) [m], (T,) [m/s], (T, 3) as returned by `_contact_geometry`. `step`
    is the step of the run [s], `overlap_rounding` the rounding error of an overlap [m].
    `looks_back`: the method uses forces of earlier steps.
    """

    scene: Scene
    run: Trajectory
    tau: float
    step: float
    overlap: Array
    rate: Array
    normal: Array
    overlap_rounding: float
    looks_back: bool

    @classmethod
    def of(cls, subject: Subject, run: Trajectory, step: float) -> "_Contact":
        """The contact of two spheres, or of a sphere and a wall."""
        scene = subject.instance.scene
        overlap, rate, normal = _contact_geometry(scene, run)
        farthest = max(float(np.max(np.abs(run.position))), float(np.max(scene.bodies.radius)))
        return cls(
            scene=scene,
            run=run,
            tau=subject.instance.scales.tau,
            step=step,
            overlap=overlap,
            rate=rate,
            normal=normal,
            overlap_rounding=TERMS * subject.method.round_off * farthest,
            looks_back=not subject.method.complete_state,
        )

    @property
    def law(self) -> Contact:
        """The contact law of the scene."""
        return self.scene.all(Contact)[0]

    @property
    def lightness(self) -> float:
        """The inverse of the effective mass [1/kg], 1/m_eff = sum of 1/m_i over the bodies."""
        return float(np.sum(1.0 / self.scene.bodies.mass))

    @property
    def surely_touches(self) -> Mask:
        """Samples (T,) whose overlap is positive by more than its rounding error."""
        return np.asarray(self.overlap > self.overlap_rounding)

    @property
    def may_touch(self) -> Mask:
        """Samples (T,) with an overlap, or one that is 0 to rounding."""
        return np.asarray(self.overlap > -self.overlap_rounding)

    @property
    def begins_or_ends(self) -> Mask:
        """Intervals (T - 1,) near which the contact may begin or end: by its overlap, or where the
        law ends it at zero force.
        """
        acts_near = _extreme_nearby(self.may_touch, np.logical_or)
        acts_throughout = _extreme_nearby(self.acts, np.logical_and)
        return np.asarray(acts_near & ~acts_throughout)

    @property
    def acts(self) -> Mask:
        """Samples (T,) at which the contact surely acts: it touches, and its law has not ended it
        at zero force.
        """
        if self.law.cutoff == "zero_force":
            return np.asarray(self.surely_touches & (self.force > 0))
        return self.surely_touches

    @cached_property
    def force(self) -> Array:
        """The normal force (T,) [N] at the samples."""
        return _normal_force(self.law, self.overlap, self.rate)

    @property
    def largest_force(self) -> float:
        """The largest size [N] of the normal force at any sample."""
        return float(np.max(np.abs(self.force)))

    @cached_property
    def dashpot(self) -> Array:
        """The force (T,) [N] of the law at overlap 0: c d', or max(0, c d') if it never pulls."""
        pushes = self.law.damping * self.rate
        if self.law.cutoff == "zero_force":
            pushes = np.maximum(pushes, 0.0)
        return pushes

    @property
    def dashpot_nearby(self) -> Array:
        """The largest size (T - 1,) [N] of the dashpot's force around each interval."""
        return np.asarray(_extreme_nearby(np.abs(self.dashpot), np.maximum))

    @cached_property
    def normal_force_nearby(self) -> tuple[Array, Array]:
        """The smallest and the largest normal force (T - 1,) [N] around each interval.

        Next to the start or end of a contact the force may be that of the dashpot alone; where the
        samples touch to rounding only, it may be 0.
        """
        # Smallest and largest, around the interval, of the force at a touch, of F where the spheres
        # may touch (else 0), and of F where they surely touch (else 0).
        at_touch = _force_at_touch(self.begins_or_ends, self.dashpot, self.force)
        may_act = np.where(self.may_touch, self.force, 0.0)
        surely_acts = np.where(self.surely_touches, self.force, 0.0)
        candidates = np.array([at_touch, may_act, surely_acts])
        low = _extreme_nearby(candidates.min(axis=0), np.minimum)
        high = _extreme_nearby(candidates.max(axis=0), np.maximum)
        return low, high

    @cached_property
    def force_of_passing(self) -> Array:
        """The force (T - 1,) [N] due to the curvature of the overlap around each interval, where
        spheres pass each other.

        Along a straight path the overlap d = R1 + R2 - |r| has d'' = -v_t^2/|r|, with v_t the part
        of the relative velocity across the normal, and deviates from its chord by |d''| dt^2/8.
        Overlaps of the steps before and after deviate from it by up to 4 times as much.
        """
        if len(self.scene.bodies) != 2:
            return np.zeros(len(self.run.t) - 1)
        branch = self.run.position[:, 1] - self.run.position[:, 0]
        relative = self.run.velocity[:, 1] - self.run.velocity[:, 0]
        distance = np.linalg.norm(branch, axis=-1)
        # v_t^2 = |v|^2 - d'^2,  |d''| = v_t^2/|r|,  sagitta = |d''| dt^2/2
        across = np.linalg.norm(relative, axis=-1) ** 2 - self.rate**2
        bend = np.maximum(across, 0.0) / distance
        sagitta = _extreme_nearby(bend, np.maximum) * np.diff(self.run.t) ** 2 / 2.0
        # F(d + sagitta) - F(d), at d' = 0
        deepest = np.maximum(_extreme_nearby(self.overlap, np.maximum), 0.0)
        still = np.zeros_like(deepest)
        deeper = _normal_force(self.law, deepest + sagitta, still)
        return np.asarray(np.abs(deeper - _normal_force(self.law, deepest, still)))

    @property
    def kept_by_multistep_weights(self) -> Array:
        """Half of the change of the force around the interval times one step (T - 1,) [kg m/s], for
        methods that use forces of earlier steps; 0 for others.

        Over steps i to j the rule of Adams and Bashforth gives

            sum (3/2 F_n - 1/2 F_(n-1)) h = sum F_n h + (F_j - F_(i-1)) h/2.
        """
        low, high = self.normal_force_nearby
        if not self.looks_back:
            return np.zeros_like(low)
        return (high - low) * self.step / 2.0

    @cached_property
    def change_of_dashpot(self) -> Array:
        """The largest change c |d''| h (T - 1,) [N] of the dashpot's force in one step around each
        interval.

        |d''| is the larger of |delta d'|/dt between samples and F/m_eff by the law.
        """
        shown = np.abs(np.diff(self.rate)) / np.diff(self.run.t)
        padded = np.concatenate([shown[:1], shown, shown[-1:]])
        shown_nearby = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
        low, high = self.normal_force_nearby
        by_law = self.lightness * np.maximum(np.abs(low), np.abs(high))
        return np.asarray(self.law.damping * np.maximum(shown_nearby, by_law) * self.step)

    @cached_property
    def pushes_throughout(self) -> Mask:
        """Intervals (T - 1,) with a contact in which every force pushes.

        Codes agree on the friction limit mu Fn there; not at the end of a contact, where a dashpot
        may pull and the force of a step is no longer positive.
        """
        never_pulls = self.law.damping == 0 or self.law.cutoff == "zero_force"
        if never_pulls:
            return np.asarray(self.surely_touches[1:] | self.surely_touches[:-1])
        return np.asarray(self.surely_touches[1:] & (self.force[1:] > self.change_of_dashpot))

    @cached_property
    def impulse(self) -> tuple[Array, Array, Array]:
        """Normal and tangential impulse (T - 1,) [kg m/s], and the turn of the normal [rad]."""
        return _impulses(self.scene, self.run, self.normal)

    @property
    def normal_impulse(self) -> Array:
        """The push (T - 1,) [kg m/s] on the first sphere along the mean normal."""
        return self.impulse[0]

    @property
    def tangential_impulse(self) -> Array:
        """The size (T - 1,) [kg m/s] of the impulse across the mean normal."""
        return self.impulse[1]

    @property
    def normal_turn(self) -> Array:
        """The angle (T - 1,) [rad] by which the normal turns."""
        return self.impulse[2]

    @cached_property
    def slip(self) -> Array:
        """The slip (T, 3) [m/s] of the first surface relative to the second: the tangential part of
        v_12 + (l_1 omega_1 + l_2 omega_2) x n, with the lever arms l_i = R_i - shortening d.
        """
        bodies = self.scene.bodies
        shorter = self.law.slip_shortening * np.maximum(self.overlap, 0.0)
        arms = bodies.radius[None, :] - shorter[:, None]
        velocity = self.run.velocity[:, 0]
        if len(bodies) == 2:
            velocity = velocity - self.run.velocity[:, 1]
        swept = np.sum(arms[:, :, None] * self.run.omega, axis=1)
        surface = velocity + np.cross(swept, self.normal)
        along = np.sum(surface * self.normal, axis=-1)
        return np.asarray(surface - along[:, None] * self.normal)

    @property
    def slip_turn(self) -> Array:
        """The angle (T - 1,) [rad] by which the direction of the slip turns."""
        speed = np.linalg.norm(self.slip, axis=-1)
        direction = self.slip / np.maximum(speed, np.finfo(float).tiny)[:, None]
        return _angle_between(direction[1:], direction[:-1])

    @cached_property
    def slip_change_of_step(self) -> Array:
        """The change of the slip by one step of friction (T - 1,) [m/s]: mu F_n h times the sum of
        1/m_i + R_i^2/J_i over the bodies.
        """
        bodies = self.scene.bodies
        # A sphere without inertia is not turned by friction.
        turned = bodies.inertia[:, 0] > 0
        inertia = np.where(turned, bodies.inertia[:, 0], 1.0)
        turning = np.where(turned, bodies.radius**2 / inertia, 0.0)
        ease = self.lightness + float(np.sum(turning))
        _, high = self.normal_force_nearby
        return np.asarray(self.law.friction * np.maximum(high, 0.0) * self.step * ease)

    @cached_property
    def slides_throughout(self) -> Mask:
        """Intervals (T - 1,) in which the surfaces slip throughout.

        The slip at both ends is larger than its change between them, and larger than the change by
        STEPS_OF_SLIP steps of friction. The second condition excludes spheres that roll: their slip
        may be equal at all samples while friction alternates.
        """
        speed = np.linalg.norm(self.slip, axis=-1)
        smallest = np.minimum(speed[1:], speed[:-1])
        change = np.linalg.norm(np.diff(self.slip, axis=0), axis=-1)
        is_lasting = smallest > change
        is_above_a_step = smallest > STEPS_OF_SLIP * self.slip_change_of_step
        return np.asarray(is_lasting & is_above_a_step)

    @property
    def impulse_of_unlike_step(self) -> Array:
        """The impulse of one step (T - 1,) [kg m/s] where forces of neighbouring steps may differ
        in direction, else 0: a negative weight may then take the sum out of the cone.

        Friction differs where the slip may reverse: mu F h. All of the force differs where the
        contact does not act at both ends of the interval: F h.
        """
        acts_at_both_ends = self.acts[1:] & self.acts[:-1]
        low, high = self.normal_force_nearby
        push = np.maximum(np.abs(low), np.abs(high)) * self.step
        friction = np.where(self.slides_throughout, 0.0, self.law.friction * push)
        return np.asarray(np.where(acts_at_both_ends, friction, push))


def _normal_force(law: Contact, overlap: Array, rate: Array) -> Array:
    """The normal force F = k d^e + c d' (T,) [N], positive where it pushes; 0 where d <= 0.

    With the cutoff at zero force it is max(0, F).
    """
    pushes = law.stiffness * np.maximum(overlap, 0.0) ** law.exponent + law.damping * rate
    if law.cutoff == "zero_force":
        pushes = np.maximum(pushes, 0.0)
    force: Array = np.where(overlap > 0, pushes, 0.0)
    return force


def _force_at_touch(begins_or_ends: Mask, dashpot: Array, force: Array) -> Array:
    """The limit of the force (T,) [N] for overlap 0, c d', at samples next to the start or end of a
    contact; elsewhere the force itself.
    """
    is_near = np.concatenate([begins_or_ends, [False]]) | np.concatenate([[False], begins_or_ends])
    return np.where(is_near, dashpot, force)


def _extreme_nearby(values: Any, extreme: Any) -> Any:
    """The extreme (T - 1,) of the values at the four samples around each interval: its ends, and
    one further on either side.
    """
    padded = np.concatenate([values[:1], values, values[-1:]])
    inner = extreme(padded[1:-2], padded[2:-1])
    outer = extreme(padded[:-3], padded[3:])
    return extreme(inner, outer)


def _impulses(scene: Scene, run: Trajectory, normal: Array) -> tuple[Array, Array, Array]:
    """Impulses (T - 1,) [kg m/s] on the first sphere: the push along the mean normal, and the size
    of the part across; and the turn of the normal [rad].
    """
    # J = m_1 dv_1,  J_n = -J.n,  J_t = |J + J_n n|
    impulse = scene.bodies.mass[0] * np.diff(run.velocity[:, 0], axis=0)
    mean_normal = normal[1:] + normal[:-1]
    mean_normal /= np.linalg.norm(mean_normal, axis=-1, keepdims=True)
    normal_impulse: Array = -np.sum(impulse * mean_normal, axis=-1)
    tangential_impulse: Array = np.linalg.norm(
        impulse + normal_impulse[:, None] * mean_normal, axis=-1
    )
    return normal_impulse, tangential_impulse, _angle_between(normal[1:], normal[:-1])


def _angle_between(a: Array, b: Array) -> Array:
    """The angle (T,) [rad] between unit vectors a and b (T, 3), 2 arcsin(|a - b|/2).

    It is computed from the chord, since the arc cosine of a.b would lose half of the digits.
    """
    chord = np.linalg.norm(a - b, axis=-1)
    angle: Array = 2.0 * np.arcsin(np.minimum(1.0, chord / 2.0))
    return angle


def _outside_cone(contact: _Contact) -> Array:
    """Distance (T - 1,) [kg m/s] of the impulse on the first sphere from the cone about the mean
    normal; 0 inside.
    """
    half_angle = np.minimum(np.arctan(contact.law.friction) + contact.normal_turn, np.pi / 2)
    # Distance from the cone J_t <= tan(a) J_n, measured at right angles to its side:
    # J_t cos(a) - J_n sin(a).
    across = contact.tangential_impulse * np.cos(half_angle)
    beyond: Array = across - contact.normal_impulse * np.sin(half_angle)
    return np.maximum(0.0, beyond)


def _contact_geometry(scene: Scene, run: Trajectory) -> tuple[Array, Array, Array]:
    """Overlap (T,) [m], its rate (T,) [m/s], and the unit normal (T, 3) from the first sphere to
    the second, or into the wall.
    """
    for wall in scene.all(Plane):
        outward = np.array(wall.normal)
        # d = R - (r - p).n,  d' = -v.n
        height = (run.position[:, 0] - np.array(wall.point)) @ outward
        normals: Array = np.broadcast_to(-outward, run.position[:, 0].shape)
        return scene.bodies.radius[0] - height, -run.velocity[:, 0] @ outward, normals
    # Two spheres, r from the first centre to the second: d = R1 + R2 - |r|,  d' = v_12.r/|r|.
    branch = run.position[:, 1] - run.position[:, 0]
    distance = np.linalg.norm(branch, axis=-1)
    normal: Array = branch / distance[:, None]
    closing = np.sum((run.velocity[:, 0] - run.velocity[:, 1]) * normal, axis=-1)
    overlap = scene.bodies.radius.sum() - distance
    return overlap, closing, normal


CHECK = ContactImpulse()
