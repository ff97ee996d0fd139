"""Contacts and releases that the samples of a run show by themselves, without truth: a pair that is
apart at one sample and pressed together at another.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from refdem.checks._crossings import DOUBLE_ROUNDING, MOST, rounding
from refdem.core.check import Array, Subject
from refdem.core.trajectory import Event, Trajectory
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane


@dataclass(frozen=True)
class ShownEvent:
    """A `kind` of event, contact or release, of `bodies` (a pair, or one beside a wall), between
    two samples of which the later one is at `by` [s]. It is the `number`th of its kind and bodies
    that the samples show, from 1.
    """

    kind: str
    by: float
    bodies: tuple[int, ...]
    number: int


@dataclass(frozen=True)
class PairInTime:
    """Overlap [m] and closing speed [m/s] of a pair, or of one body and a wall, at every sample:
    (T,) each.
    """

    bodies: tuple[int, ...]
    overlap: Array
    closing: Array


def can_show(subject: Subject) -> bool:
    """True for a few spheres under one soft contact law without a periodic box, and velocities that
    hold at their samples.
    """
    scene = subject.instance.scene
    laws = scene.all(Contact)
    is_soft = len(laws) == 1 and laws[0].law != "rigid"
    is_synchronous = subject.method.velocity_time == "synchronous"
    is_small = len(scene.bodies) <= MOST
    return is_soft and is_synchronous and is_small and not scene.all(PeriodicBox)


def shown_events(subject: Subject, run: Trajectory, kind: str) -> list[ShownEvent]:
    """The contacts or releases that the samples of a run show.

    A pair is pressed together at a sample where it overlaps and closes: its force is repulsive
    there, whether the law ends it at zero overlap or at zero force. It is apart where its overlap
    is negative. Both are beyond the rounding of the overlap.
    """
    scene = subject.instance.scene
    margin = rounding(scene) * subject.method.round_off / DOUBLE_ROUNDING
    found = []
    for pair in pairs_in_time(scene, run):
        is_pressed = (pair.overlap > margin) & (pair.closing > 0)
        is_apart = pair.overlap < -margin
        if kind == "contact":
            times = changes(run.t, is_apart, is_pressed)
        else:
            times = changes(run.t, is_pressed, is_apart)
        found += [
            ShownEvent(kind, time, pair.bodies, number)
            for number, time in enumerate(times, start=1)
        ]
    return found


def pairs_in_time(scene: Scene, run: Trajectory) -> Iterator[PairInTime]:
    """Every pair of spheres, then every sphere and plane, through the samples of a run."""
    radius = scene.bodies.radius
    spheres = [int(i) for i in np.flatnonzero(radius > 0)]
    for i, j in combinations(spheres, 2):
        branch = run.position[:, j] - run.position[:, i]
        distance = np.linalg.norm(branch, axis=-1)
        relative = run.velocity[:, i] - run.velocity[:, j]
        # The sign of the closing speed is that of its product with the distance.
        closing = np.sum(relative * branch, axis=-1)
        yield PairInTime((i, j), radius[i] + radius[j] - distance, closing)
    for i in spheres:
        for plane in scene.all(Plane):
            normal = np.array(plane.normal)
            height = (run.position[:, i] - np.array(plane.point)) @ normal
            yield PairInTime((i,), radius[i] - height, -run.velocity[:, i] @ normal)


def changes(t: Array, before: Iterable[bool], after: Iterable[bool]) -> list[float]:
    """Times [s] of samples (T,) at which `after` holds for the first time since `before` did."""
    found = []
    is_due = False
    for time, holds_before, holds_after in zip(t, before, after, strict=True):
        if holds_before:
            is_due = True
        elif holds_after and is_due:
            found.append(float(time))
            is_due = False
    return found


def first_unreported(
    shown: list[ShownEvent], reported: list[Event], late: float
) -> ShownEvent | None:
    """The first shown event that is not among those reported for one of its bodies by `late` [s]
    after its sample; None if all are.
    """
    for event in sorted(shown, key=lambda event: event.by):
        of_bodies = [
            one for one in reported if one.body in event.bodies and one.time <= event.by + late
        ]
        if len(of_bodies) < event.number:
            return event
    return None
