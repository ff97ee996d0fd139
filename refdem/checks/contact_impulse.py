"""Impulses between samples of two spheres, or of a sphere and a wall: inside the friction cone, and
of the size that the contact law gives.

Each step adds forces that obey the law at some state near the step. So the impulse J = m dv of an
interval between two samples is a positive sum of such forces, whatever the method; J_n is its part
along the mean normal, J_t the part across.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

STEPS_A_SAMPLE = 4
"""Smallest number of steps between samples: the normal hardly turns in so few, and no method has
more stages.
"""
MOST_DENSE = 64
"""Largest number of samples in place of one."""
TERMS = 8.0
"""Roundings in a difference of two velocities: two vectors of three coordinates, and the
normals.
"""


SHORT_OF_RADIUS = {"R": 0.0, "R-d/2": 0.5, "R-d": 1.0}
"""Share of the overlap by which the lever arm of friction is shorter than the radius, by
`branch`.
"""


class ContactImpulse(Check):
    """Impulses between samples, for two spheres alone or for one and a wall: a sum of forces, each
    of which obeys the law.

    cone: each force obeys |Ft| <= mu Fn, so it lies in the cone of half angle arctan(mu) about its
    own normal. A cone is convex, so the sum, whatever the weights of the method, lies in the cone
    of half angle arctan(mu) + a about the mean normal, where a is the angle by which normals turn
    between the samples. That is twice what samples within the interval need, and covers stages that
    look a step ahead. The statement has no truncation error. It is not made for tangential springs:
    a spring at its limit may be extrapolated through a step and pass the limit within the order of
    the method.

    normal: the mean normal force lies between the smallest and the largest that the law gives at
    the four samples around the interval. They are several steps apart, so forces of the step before
    or after are covered, and only the curvature of the force between samples is allowed for. An
    error that does not depend on the step is visible at the coarsest one.

    sliding: where a sphere slides along a wall without a tangential spring, each force obeys |Ft| =
    mu Fn, and neither the normal nor, in a plane, the direction of slip turns: the sum obeys it
    too, to round-off.
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
        run = runs[_dense_variant(subject)].trajectory
        scene = subject.instance.scene
        law = scene.all(Contact)[0]
        unit = scene.bodies.mass[0] * subject.instance.scales.speed
        fastest = float(np.max(np.abs(run.velocity))) / subject.instance.scales.speed
        rounding = TERMS * subject.round_off(subject.levels[0]) * max(1.0, fastest)
        findings = [self._normal(subject, run, unit, rounding)]
        presses = _pushing_intervals(scene, run)
        if law.friction > 0 and law.tangential_stiffness == 0 and presses.any():
            findings.append(
                worst(
                    check=self.name,
                    quantity="cone",
                    t=run.t[1:][presses],
                    values=(_outside_cone(scene, run) / unit)[presses],
                    allowed=rounding,
                    unit="1",
                    basis=(
                        "every force satisfies |Ft| <= mu Fn, hence so does their sum, to"
                        " round-off, at any step"
                    ),
                    what=(
                        "The impulse between two samples in excess of the friction cone, in units"
                        " of mass times speed,"
                    ),
                )
            )
        if law.friction > 0 and law.tangential_stiffness == 0 and scene.all(Plane):
            findings += self._sliding(scene, run, unit, rounding)
        return findings

    def _sliding(
        self, scene: Scene, run: Trajectory, unit: float, rounding: float
    ) -> list[Finding]:
        """The finding | |J_t| - mu J_n | = 0 of the intervals in which a sphere slides along a
        wall; none if it never does.
        """
        law = scene.all(Contact)[0]
        _, _, normal = _contact_geometry(scene, run)
        normal_impulse, tangential_impulse, _ = _impulses(scene, run, normal)
        slides, slip_turn = _sliding_intervals(scene, run)
        is_judged = np.logical_and(_pushing_intervals(scene, run), slides)
        if not is_judged.any():
            return []
        # Forces whose directions differ by up to `slip_turn` add up to less, by no more than that.
        allowed = (
            rounding * (1 + law.friction) + law.friction * np.abs(normal_impulse) * slip_turn / unit
        )
        return [
            worst(
                check=self.name,
                quantity="sliding",
                t=run.t[1:][is_judged],
                values=(np.abs(tangential_impulse - law.friction * normal_impulse) / unit)[
                    is_judged
                ],
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

    def _normal(self, subject: Subject, run: Trajectory, unit: float, rounding: float) -> Finding:
        """The finding that J_n of every interval lies between those of the smallest and largest
        force of the law nearby.
        """
        scene = subject.instance.scene
        law = scene.all(Contact)[0]
        overlap, rate, normal = _contact_geometry(scene, run)
        interval = np.diff(run.t)
        force = _normal_force(law, overlap, rate)
        touch_force = _force_at_touch(law, overlap, rate)
        low = _extreme_nearby(np.minimum(force, touch_force), np.minimum)
        high = _extreme_nearby(np.maximum(force, touch_force), np.maximum)
        normal_impulse, tangential_impulse, normal_turn = _impulses(scene, run, normal)
        below = np.maximum(0.0, low * interval - normal_impulse)
        above = np.maximum(0.0, normal_impulse - high * interval)
        # Within a contact the force leaves its chord by F'' dt^2 / 8, with F'' of a few F / tau^2.
        # At a contact that begins or ends between two samples the force is known from their
        # velocities up to F' dt, with F' about F / tau. Friction across one normal has a component
        # along another, in proportion to the angle between them.
        largest = float(np.max(np.abs(force)))
        interval_share = interval / subject.instance.scales.tau
        touches_near = _extreme_nearby(overlap > 0, np.logical_or)
        touches_throughout = _extreme_nearby(overlap > 0, np.logical_and)
        begins_or_ends = touches_near & ~touches_throughout
        relative_change = np.where(begins_or_ends, interval_share, interval_share**2 / 2.0)
        curvature = largest * interval * relative_change
        tilt = tangential_impulse * normal_turn
        return worst(
            check=self.name,
            quantity="normal",
            t=run.t[1:],
            values=np.maximum(below, above) / unit,
            allowed=(curvature + tilt) / unit + rounding,
            unit="1",
            basis=(
                "the impulse must lie between those of the smallest and largest forces"
                " that the law gives near the interval, plus their curvature"
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


def _pushing_intervals(scene: Scene, run: Trajectory) -> Array:
    """Intervals (T - 1,) with a contact in which every force pushes.

    Codes agree on the friction limit mu Fn there; not at the end of a contact, where a dashpot may
    pull and the force at a sample is no longer positive.
    """
    law = scene.all(Contact)[0]
    overlap, rate, _ = _contact_geometry(scene, run)
    touches = overlap > 0
    force = _normal_force(law, overlap, rate)
    never_pulls = law.damping == 0 or law.cutoff == "zero_force"
    if never_pulls:
        return np.asarray(touches[1:] | touches[:-1])
    return np.asarray(touches[1:] & (force[1:] > 0))


def _sliding_intervals(scene: Scene, run: Trajectory) -> tuple[Array, Array]:
    """Intervals (T - 1,) in which a sphere slips along its wall throughout, and the turn of the
    slip direction [rad].

    The slip is the tangential part of v + omega x arm. It lasts if it is larger at both ends of the
    interval than its change between them.
    """
    law = scene.all(Contact)[0]
    overlap, _, normal = _contact_geometry(scene, run)
    arm_length = scene.bodies.radius[0] - SHORT_OF_RADIUS[law.branch] * np.maximum(overlap, 0.0)
    contact_velocity = run.velocity[:, 0] + np.cross(run.omega[:, 0], arm_length[:, None] * normal)
    slip = contact_velocity - np.sum(contact_velocity * normal, axis=-1)[:, None] * normal
    speed = np.linalg.norm(slip, axis=-1)
    change = np.linalg.norm(np.diff(slip, axis=0), axis=-1)
    is_sliding: Array = np.minimum(speed[1:], speed[:-1]) > change
    direction = slip / np.maximum(speed, np.finfo(float).tiny)[:, None]
    # The angle between unit vectors u, w is 2 arcsin(|u - w|/2).
    chord = np.linalg.norm(np.diff(direction, axis=0), axis=-1)
    turn: Array = 2.0 * np.arcsin(np.minimum(1.0, chord / 2.0))
    return is_sliding, turn


def _normal_force(law: Contact, overlap: Array, rate: Array) -> Array:
    """The normal force F = k d^e + c d' (T,) [N], positive where it pushes; 0 without overlap
    d.
    """
    pushes = law.stiffness * np.maximum(overlap, 0.0) ** law.exponent + law.damping * rate
    if law.cutoff == "zero_force":
        pushes = np.maximum(pushes, 0.0)
    force: Array = np.where(overlap > 0, pushes, 0.0)
    return force


def _force_at_touch(law: Contact, overlap: Array, rate: Array) -> Array:
    """The limit of the force (T,) [N] for overlap 0, c d', at samples next to the start or end of a
    contact; elsewhere the force itself.
    """
    touches = overlap > 0
    pushes = law.damping * rate
    if law.cutoff == "zero_force":
        pushes = np.maximum(pushes, 0.0)
    changes = _extreme_nearby(touches, np.logical_or) & ~_extreme_nearby(touches, np.logical_and)
    is_near = np.concatenate([changes, [False]]) | np.concatenate([[False], changes])
    force: Array = np.where(is_near, pushes, _normal_force(law, overlap, rate))
    return force


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
    impulse = scene.bodies.mass[0] * np.diff(run.velocity[:, 0], axis=0)
    mean_normal = normal[1:] + normal[:-1]
    mean_normal /= np.linalg.norm(mean_normal, axis=-1, keepdims=True)
    normal_impulse: Array = -np.sum(impulse * mean_normal, axis=-1)
    tangential_impulse: Array = np.linalg.norm(
        impulse + normal_impulse[:, None] * mean_normal, axis=-1
    )
    # The angle between two unit vectors, from the length of their difference: its cosine would lose
    # half of the digits.
    chord = np.linalg.norm(np.diff(normal, axis=0), axis=-1)
    turn: Array = 2.0 * np.arcsin(np.minimum(1.0, chord / 2.0))
    return normal_impulse, tangential_impulse, turn


def _outside_cone(scene: Scene, run: Trajectory) -> Array:
    """Distance (T - 1,) [kg m/s] of the impulse on the first sphere from the cone about the mean
    normal; 0 inside.
    """
    law = scene.all(Contact)[0]
    _, _, normal = _contact_geometry(scene, run)
    normal_impulse, tangential_impulse, normal_turn = _impulses(scene, run, normal)
    half_angle = np.minimum(np.arctan(law.friction) + normal_turn, np.pi / 2)
    # Distance from the cone J_t <= tan(a) J_n, measured at right angles to its side:
    # J_t cos(a) - J_n sin(a).
    beyond: Array = tangential_impulse * np.cos(half_angle) - normal_impulse * np.sin(half_angle)
    return np.maximum(0.0, beyond)


def _contact_geometry(scene: Scene, run: Trajectory) -> tuple[Array, Array, Array]:
    """Overlap (T,) [m], its rate (T,) [m/s], and the unit normal (T, 3) from the first sphere to
    the second, or into the wall.
    """
    for wall in scene.all(Plane):
        outward = np.array(wall.normal)
        height = (run.position[:, 0] - np.array(wall.point)) @ outward
        normals: Array = np.broadcast_to(-outward, run.position[:, 0].shape)
        return scene.bodies.radius[0] - height, -run.velocity[:, 0] @ outward, normals
    # Two spheres: the branch vector from the first centre to the second.
    branch = run.position[:, 1] - run.position[:, 0]
    distance = np.linalg.norm(branch, axis=-1)
    normal: Array = branch / distance[:, None]
    closing = np.sum((run.velocity[:, 0] - run.velocity[:, 1]) * normal, axis=-1)
    overlap = scene.bodies.radius.sum() - distance
    return overlap, closing, normal


CHECK = ContactImpulse()
