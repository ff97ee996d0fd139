"""Free flight: a body whose velocity has not changed from one sample to the next has gone the way v
dt, whatever the step.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.refinement import steps_at
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane

BETWEEN_CONTACTS = frozenset({"contact", "plane", "periodic_box"})
"""Elements that leave a body alone except where it touches."""


class Flight(Check):
    """Positions follow from velocities to round-off, at the finest level.

    It needs no truth, and sees a gas of which nobody can predict the motion stand still.
    """

    name = "flight"
    title = "Free flight"
    kills = (
        "positions that do not follow from velocities: a gas that stands still,"
        " bodies moved twice or with the previous step"
    )

    def applies(self, subject: Subject) -> str | None:
        """Bodies that meet each other or walls under a law with an overlap, and on which nothing
        else acts.
        """
        scene = subject.instance.scene
        if (
            "contact" not in scene.features
            or {element.kind for element in scene.elements} - BETWEEN_CONTACTS
        ):
            return "a force acts on the bodies between contacts, or they never touch"
        if "contact:rigid" in scene.features:
            return "overlapping rigid bodies are pushed apart regardless of their velocities"
        if np.any(scene.bodies.velocity):
            return None
        return "every body starts at rest"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The largest distance of any such body from where v dt takes it; none where every body was
        hit in every interval.
        """
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        scales = subject.instance.scales
        rounding = subject.round_off(subject.levels[-1])
        way = run.velocity[:-1] * np.diff(run.t)[:, None, None]
        alone = _is_alone(scene, run, way, rounding)
        if not alone.any():
            return []
        off = _off(scene, run.position[1:] - run.position[:-1] - way)
        far = np.max(np.abs(run.position)) / scales.length
        fast = np.max(np.abs(run.velocity)) * scales.duration / scales.length
        # r + v h is rounded the same way at every step while r keeps its exponent, so that these
        # roundings do add up.
        steps = steps_at(subject.instance, subject.method, subject.levels[-1]) / (len(run.t) - 1)
        adding = 2.0 * subject.method.round_off * steps * far
        # |r(t + dt) - r(t) - v dt| and |v dt| of the bodies in free flight, the largest of each.
        distances = np.max(np.linalg.norm(off, axis=-1) * alone, axis=1)
        ways = np.max(np.linalg.norm(way, axis=-1) * alone, axis=1)
        return [
            worst(
                check=self.name,
                quantity="way",
                t=run.t[1:],
                values=distances / scales.length,
                allowed=rounding * (1.0 + far + fast) + adding,
                signal=ways / scales.length,
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


def _is_alone(scene: Scene, run: Trajectory, way: Array, rounding: float) -> Array:
    """Whether a body was hit by nothing in an interval (T - 1, N): it has kept its velocity, and
    its straight way stays inside walls.

    A body that comes back to its velocity by two walls, one after the other, has left by the first
    of them on its straight way.
    """
    fastest = np.max(np.abs(run.velocity))
    change = np.linalg.norm(np.diff(run.velocity, axis=0), axis=-1)
    # A graze changes v by so little that v dt is off by no more than half of what is allowed.
    alone = change <= rounding * fastest / 2
    end = run.position[:-1] + way
    for plane in scene.all(Plane):
        alone &= (end - np.array(plane.point)) @ np.array(plane.normal) > scene.bodies.radius
    found: Array = alone
    return found


def _off(scene: Scene, difference: Array) -> Array:
    """Differences of places (T - 1, N, 3) [m], in a periodic box those to the nearest image."""
    for box in scene.all(PeriodicBox):
        difference = box.nearest(difference)
    return difference


CHECK = Flight()
