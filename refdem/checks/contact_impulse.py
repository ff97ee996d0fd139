"""What two spheres, or a sphere and a wall, do to each other between samples: an impulse in the
friction cone, of the size that the contact law says.
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
"""Steps from sample to sample: so few that the normal hardly turns between them, and more than any
method has stages.
"""
MOST_DENSE = 64
"""Samples in place of one, at most."""
TERMS = 8.0
"""Roundings of a difference of two velocities: of both, in three coordinates, and of the normals.
"""


SHORT_OF_RADIUS = {"R": 0.0, "R-d/2": 0.5, "R-d": 1.0}
"""The part of the overlap that the lever arm of friction is short of the radius, by `branch`."""


class ContactImpulse(Check):
    """Two spheres alone, or one and a wall: between samples each gains an impulse that is a sum of
    forces which obey the law.

    cone: each force obeys |Ft| <= mu Fn, so it lies in the cone of half angle arctan(mu) about its
    own normal. A cone is convex: whatever the weights of the method, their sum lies in the cone of
    half angle arctan(mu) + a about the mean normal, where a is the angle by which normals turn
    between the samples. That is twice what samples within the interval need; stages that look a
    step ahead need no more. So the law has no truncation error. A tangential spring at its limit
    may be carried on through a step as one that slides along, and pass the limit within the order
    of the method: sliding friction alone has no memory.

    normal: the mean normal force lies between the smallest and the largest that the law gives at
    the four samples around the interval. They are several steps apart, so that forces of the step
    before or after are among them, and only what the force bends between samples is allowed for. An
    error that no step removes is seen at the coarsest one.

    sliding: where a sphere slides along a wall without a tangential spring, each force obeys
    |Ft| = mu Fn, and neither the normal nor, in a plane, the direction of slip turns: the sum obeys
    it too, to round-off.
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
        """Two free spheres, or one and a wall, under a law with an overlap, on which nothing else
        acts, in steps.
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
        """The coarsest level, at which what is late is furthest off, with a sample every few
        steps.
        """
        return (_dense(subject),)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """How far the impulses of intervals are outside, in units of mass times speed."""
        run = runs[_dense(subject)].trajectory
        scene = subject.instance.scene
        law = scene.all(Contact)[0]
        unit = scene.bodies.mass[0] * subject.instance.scales.speed
        fastest = float(np.max(np.abs(run.velocity))) / subject.instance.scales.speed
        rounding = TERMS * subject.round_off(subject.levels[0]) * max(1.0, fastest)
        found = [self._normal(subject, run, unit, rounding)]
        presses = _presses(scene, run)
        if law.friction > 0 and law.tangential_stiffness == 0 and presses.any():
            found.append(
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
            found += self._sliding(scene, run, unit, rounding)
        return found

    def _sliding(
        self, scene: Scene, run: Trajectory, unit: float, rounding: float
    ) -> list[Finding]:
        """Friction over normal impulse of a sphere that slides along a wall; nothing if it does
        not.
        """
        law = scene.all(Contact)[0]
        _, _, normal = _meeting(scene, run)
        pressing, across, _ = _impulses(scene, run, normal)
        slides, turned = _slides(scene, run)
        counts = np.logical_and(_presses(scene, run), slides)
        if not counts.any():
            return []
        # Forces whose directions differ by up to `turned` add up to less, by no more than that.
        allowed = rounding * (1 + law.friction) + law.friction * np.abs(pressing) * turned / unit
        return [
            worst(
                check=self.name,
                quantity="sliding",
                t=run.t[1:][counts],
                values=(np.abs(across - law.friction * pressing) / unit)[counts],
                allowed=allowed[counts],
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
        scene = subject.instance.scene
        law = scene.all(Contact)[0]
        overlap, rate, normal = _meeting(scene, run)
        interval = np.diff(run.t)
        force = _forces(law, overlap, rate)
        at_touch = _at_touch(law, overlap, rate)
        low = _around(np.minimum(force, at_touch), np.minimum)
        high = _around(np.maximum(force, at_touch), np.maximum)
        pressing, across, turned = _impulses(scene, run, normal)
        below = np.maximum(0.0, low * interval - pressing)
        above = np.maximum(0.0, pressing - high * interval)
        # Between samples a force bends by F'' dt^2 / 8, with F'' of a few F / tau^2. What it is at
        # a touch between two samples is told by their velocities to F' dt, with F' about F / tau.
        # Friction tilts by the turn of the normal.
        largest = float(np.max(np.abs(force)))
        part = interval / subject.instance.scales.tau
        touches = _around(overlap > 0, np.logical_or) & ~_around(overlap > 0, np.logical_and)
        bends = largest * interval * np.where(touches, part, part**2 / 2.0)
        tilts = across * turned
        return worst(
            check=self.name,
            quantity="normal",
            t=run.t[1:],
            values=np.maximum(below, above) / unit,
            allowed=(bends + tilts) / unit + rounding,
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


def _dense(subject: Subject) -> Variant:
    """The coarsest level, with samples at every few steps."""
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


def _presses(scene: Scene, run: Trajectory) -> Array:
    """Intervals (T - 1,) with a contact in which no force can pull: friction has no limit there
    that all codes share.

    A dashpot pulls at the end of a contact, from where the force at a sample is no longer positive.
    """
    law = scene.all(Contact)[0]
    overlap, rate, _ = _meeting(scene, run)
    touches = overlap > 0
    force = _forces(law, overlap, rate)
    never_pulls = law.damping == 0 or law.cutoff == "zero_force"
    if never_pulls:
        return np.asarray(touches[1:] | touches[:-1])
    return np.asarray(touches[1:] & (force[1:] > 0))


def _slides(scene: Scene, run: Trajectory) -> tuple[Array, Array]:
    """Intervals (T - 1,) at whose ends a sphere slips along its wall so fast that friction does not
    end it between them, and by how much the direction of slip turns [rad].
    """
    law = scene.all(Contact)[0]
    overlap, _, normal = _meeting(scene, run)
    lever = scene.bodies.radius[0] - SHORT_OF_RADIUS[law.branch] * np.maximum(overlap, 0.0)
    velocity = run.velocity[:, 0] + np.cross(run.omega[:, 0], lever[:, None] * normal)
    slip = velocity - np.sum(velocity * normal, axis=-1)[:, None] * normal
    speed = np.linalg.norm(slip, axis=-1)
    change = np.linalg.norm(np.diff(slip, axis=0), axis=-1)
    lasts: Array = np.minimum(speed[1:], speed[:-1]) > change
    unit = slip / np.maximum(speed, np.finfo(float).tiny)[:, None]
    chord = np.linalg.norm(np.diff(unit, axis=0), axis=-1)
    turned: Array = 2.0 * np.arcsin(np.minimum(1.0, chord / 2.0))
    return lasts, turned


def _forces(law: Contact, overlap: Array, rate: Array) -> Array:
    """The normal force (T,) [N] of the law, positive where it presses."""
    pushes = law.stiffness * np.maximum(overlap, 0.0) ** law.exponent + law.damping * rate
    if law.cutoff == "zero_force":
        pushes = np.maximum(pushes, 0.0)
    force: Array = np.where(overlap > 0, pushes, 0.0)
    return force


def _at_touch(law: Contact, overlap: Array, rate: Array) -> Array:
    """The force (T,) [N] at a touch next to each sample, where only a dashpot acts; that of the
    sample far from any touch.
    """
    touches = overlap > 0
    pushes = law.damping * rate
    if law.cutoff == "zero_force":
        pushes = np.maximum(pushes, 0.0)
    changes = _around(touches, np.logical_or) & ~_around(touches, np.logical_and)
    is_near = np.concatenate([changes, [False]]) | np.concatenate([[False], changes])
    force: Array = np.where(is_near, pushes, _forces(law, overlap, rate))
    return force


def _around(values: Any, extreme: Any) -> Any:
    """The extreme (T - 1,) of the values at the ends of each interval and one sample further to
    either side.
    """
    padded = np.concatenate([values[:1], values, values[-1:]])
    inner = extreme(padded[1:-2], padded[2:-1])
    outer = extreme(padded[:-3], padded[3:])
    return extreme(inner, outer)


def _impulses(scene: Scene, run: Trajectory, normal: Array) -> tuple[Array, Array, Array]:
    """Impulses (T - 1,) [kg m/s] on the first sphere along the mean normal, away from the other,
    and across it; the turn [rad].
    """
    impulse = scene.bodies.mass[0] * np.diff(run.velocity[:, 0], axis=0)
    middle = normal[1:] + normal[:-1]
    middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
    pressing: Array = -np.sum(impulse * middle, axis=-1)
    across: Array = np.linalg.norm(impulse + pressing[:, None] * middle, axis=-1)
    # The angle between two unit vectors, from the length of their difference: its cosine would lose
    # half of the digits.
    chord = np.linalg.norm(np.diff(normal, axis=0), axis=-1)
    turned: Array = 2.0 * np.arcsin(np.minimum(1.0, chord / 2.0))
    return pressing, across, turned


def _outside_cone(scene: Scene, run: Trajectory) -> Array:
    """The impulse (T - 1,) [kg m/s] on the first sphere in excess of the cone about the mean
    normal; 0 within.
    """
    law = scene.all(Contact)[0]
    _, _, normal = _meeting(scene, run)
    pressing, across, turned = _impulses(scene, run, normal)
    half_angle = np.minimum(np.arctan(law.friction) + turned, np.pi / 2)
    # Distance from the cone |across| <= tan(a) pressing, measured at right angles to its side.
    beyond: Array = across * np.cos(half_angle) - pressing * np.sin(half_angle)
    return np.maximum(0.0, beyond)


def _meeting(scene: Scene, run: Trajectory) -> tuple[Array, Array, Array]:
    """Overlap (T,) [m], its rate (T,) [m/s], and the unit normal (T, 3) from the first sphere to
    the second, or to the wall.
    """
    for wall in scene.all(Plane):
        away = np.array(wall.normal)
        height = (run.position[:, 0] - np.array(wall.point)) @ away
        towards: Array = np.broadcast_to(-away, run.position[:, 0].shape)
        return scene.bodies.radius[0] - height, -run.velocity[:, 0] @ away, towards
    apart = run.position[:, 1] - run.position[:, 0]
    distance = np.linalg.norm(apart, axis=-1)
    normal: Array = apart / distance[:, None]
    closing = np.sum((run.velocity[:, 0] - run.velocity[:, 1]) * normal, axis=-1)
    overlap = scene.bodies.radius.sum() - distance
    return overlap, closing, normal


CHECK = ContactImpulse()
