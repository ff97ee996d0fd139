"""Free flight: a body whose velocity is the same at two samples has moved by v dt between them,
whatever the step.
"""

from collections.abc import Mapping
from math import ceil

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.refinement import MEMORY, steps_at
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane

BETWEEN_CONTACTS = frozenset({"contact", "plane", "periodic_box"})
"""Elements that leave a body alone except where it touches."""


class Flight(Check):
    """Positions follow from velocities to round-off, at the finest level.

    It needs no truth, so it detects a gas that stands still although its motion is unpredictable.
    """

    name = "flight"
    title = "Free flight"
    kills = (
        "positions that do not follow from velocities: a gas that stands still,"
        " bodies moved twice or with the previous step"
    )

    def applies(self, subject: Subject) -> str | None:
        """Bodies that interact with each other and with walls by a contact law, and nothing else.

        Under a rigid law only methods that find every impact, so that nothing overlaps, and only
        motions that check `error` leaves out: in one that can be predicted two impacts between
        samples may give a body its velocity back, as in a cradle of equal balls.
        """
        scene = subject.instance.scene
        if (
            "contact" not in scene.features
            or {element.kind for element in scene.elements} - BETWEEN_CONTACTS
        ):
            return "a force acts on the bodies between contacts, or they never touch"
        if "contact:rigid" in scene.features and subject.method.control != "exact":
            return "overlapping rigid bodies are pushed apart regardless of their velocities"
        if "contact:rigid" in scene.features and "error" not in subject.instance.case.exclude:
            return "impacts between samples may give a body its velocity back"
        if np.any(scene.bodies.velocity):
            return None
        return "every body starts at rest"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the largest |r(t + dt) - r(t) - v dt| of bodies in free flight; none if
        every body was hit in every interval.
        """
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        scales = subject.instance.scales
        rounding = subject.round_off(subject.levels[-1])
        # v dt.
        displacement = run.velocity[:-1] * np.diff(run.t)[:, None, None]
        is_free = _is_in_free_flight(scene, run, displacement, rounding)
        if subject.method.control == "step" and not subject.method.complete_state:
            # r' - r is v h once the velocities of all previous steps that the method uses are v.
            interval = float(np.min(np.abs(np.diff(run.t))))
            is_free = _for_some_time(is_free, ceil(MEMORY * subject.levels[-1] / interval))
        if not is_free.any():
            return []
        # r(t + dt) - r(t) - v dt, of the nearest periodic image.
        deviation = _nearest_image(scene, run.position[1:] - run.position[:-1] - displacement)
        distance_scales = np.max(np.abs(run.position)) / scales.length
        path_scales = np.max(np.abs(run.velocity)) * scales.duration / scales.length
        # r + v h is rounded the same way at every step while r keeps its exponent, so that these
        # roundings do add up.
        steps = steps_at(subject.instance, subject.method, subject.levels[-1]) / (len(run.t) - 1)
        summation = 2.0 * subject.method.round_off * steps * distance_scales
        # |r(t + dt) - r(t) - v dt| and |v dt| of the bodies in free flight, the largest of each.
        distances = np.max(np.linalg.norm(deviation, axis=-1) * is_free, axis=1)
        lengths = np.max(np.linalg.norm(displacement, axis=-1) * is_free, axis=1)
        return [
            worst(
                check=self.name,
                quantity="way",
                t=run.t[1:],
                values=distances / scales.length,
                allowed=rounding * (1.0 + distance_scales + path_scales) + summation,
                signal=lengths / scales.length,
                unit="1",
                basis=(
                    "no force acts between contacts, so only round-off, at most n u |r|,"
                    " bends a straight line"
                ),
                what=(
                    "The distance of a body in free flight from r + v dt of the previous"
                    " sample, relative to L,"
                ),
            )
        ]


def _is_in_free_flight(
    scene: Scene, run: Trajectory, displacement: Array, rounding: float
) -> Array:
    """True (T - 1, N) where a body is in free flight: its velocity is unchanged, and its straight
    path ends inside every wall.

    A body that two walls hit in one interval may regain its velocity, but its straight path would
    leave through the first of them.
    """
    fastest = np.max(np.abs(run.velocity))
    change = np.linalg.norm(np.diff(run.velocity, axis=0), axis=-1)
    # A graze changes v by so little that v dt is off by no more than half of what is allowed.
    is_free = change <= rounding * fastest / 2
    end = run.position[:-1] + displacement
    for plane in scene.all(Plane):
        is_free &= (end - np.array(plane.point)) @ np.array(plane.normal) > scene.bodies.radius
    result: Array = is_free
    return result


def _for_some_time(is_free: Array, intervals: int) -> Array:
    """True (T - 1, N) where a body is in free flight, and was for so many intervals before."""
    result = is_free
    for back in range(1, intervals + 1):
        earlier = np.zeros_like(is_free)
        earlier[back:] = is_free[:-back]
        result = np.logical_and(result, earlier)
    return result


def _nearest_image(scene: Scene, difference: Array) -> Array:
    """Differences of positions (T - 1, N, 3) [m]; in a periodic box those to the nearest image."""
    for box in scene.all(PeriodicBox):
        difference = box.nearest(difference)
    return difference


CHECK = Flight()
