"""Events that are reported wrongly, of a motion that is right: late, of another kind, or where
nothing happens.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import acos, sqrt

import msgspec
import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Event, Trajectory
from refdem.faults.fault import Fault
from refdem.scene.elements.contact import Contact

event = partial(Fault, kind="event-times", levels=7)


Change = Callable[[Event, Request, Trajectory], Event]


def _each(change: Change) -> Callable[[Request, Trajectory], Trajectory]:
    """A trajectory with each of its events changed."""

    def after(request: Request, run: Trajectory) -> Trajectory:
        events = tuple(change(event, request, run) for event in run.events)
        return replace(run, events=events)

    return after


def _step_late(event: Event, request: Request, run: Trajectory) -> Event:
    """The event, reported a step later."""
    return msgspec.structs.replace(event, time=event.time + request.signed_step)


def _at_next_sample(event: Event, request: Request, run: Trajectory) -> Event:
    """The event at the first sample that is not before it."""
    number = int(np.searchsorted(run.t, event.time))
    last = len(run.t) - 1
    return msgspec.structs.replace(event, time=float(run.t[min(number, last)]))


def _stick_for_slip(event: Event, request: Request, run: Trajectory) -> Event:
    """The event with its kind exchanged: a stick for a slip, a slip for a stick."""
    other = {"stick": "slip", "slip": "stick"}
    return msgspec.structs.replace(event, kind=other[event.kind])


def _of_third_body(event: Event, request: Request, run: Trajectory) -> Event:
    """An impact of two neighbours of three balls, reported of the third ball."""
    return msgspec.structs.replace(event, body=(event.body + 2) % 3)


def _chattering(request: Request, run: Trajectory) -> Trajectory:
    """Every event is reported twice: at half of its time, and at its time."""
    early = tuple(msgspec.structs.replace(event, time=event.time / 2) for event in run.events)
    return replace(run, events=(*early, *run.events))


def _first_twice(request: Request, run: Trajectory) -> Trajectory:
    """The first event is reported a second time, one step later."""
    again = tuple(_step_late(event, request, run) for event in run.events[:1])
    return replace(run, events=(*run.events, *again))


def _where_force_turns(event: Event, request: Request, run: Trajectory) -> Event:
    """The contact ends where its force k d + c d' is 0, as if it never pulled.

    For a contact that begins at t = 0 the overlap is proportional to exp(-b t) sin(w t), with
    b = c/(2 m), w0^2 = k/m and w^2 = w0^2 - b^2, m being the effective mass. The force is 0 where
    tan(w t) = -2 b w/(w0^2 - 2 b^2), that is at t = 2 acos(b/w0)/w.
    """
    scene = request.problem.scene
    law = scene.all(Contact)[0]
    mass = scene.bodies.mass
    effective = float(mass.prod() / mass.sum())
    b = law.damping / (2 * effective)
    w0 = sqrt(law.stiffness / effective)
    w = sqrt(w0 * w0 - b * b)
    return msgspec.structs.replace(event, time=2 * acos(b / w0) / w)


FAULTS = (
    event(
        name="release-a-step-late",
        sentence="The end of a contact is reported one step late.",
        on=("bounce", "knock", "hertz"),
        sees=("event-times", "release"),
        after=_each(_step_late),
    ),
    event(
        name="stick-a-step-late",
        sentence="Sticking is reported one step late.",
        on=("sticking", "rubbing"),
        sees=("event-times", "stick"),
        after=_each(_step_late),
    ),
    event(
        name="slip-at-samples",
        sentence="Events are reported at the time of the next row.",
        on=("sticking",),
        sees=("event-times", "slip"),
        after=_each(_at_next_sample),
    ),
    event(
        name="stick-for-slip",
        sentence="Sticking is reported as slipping, and slipping as sticking.",
        on=("sticking",),
        sees=("event-times", "stick"),
        after=_each(_stick_for_slip),
    ),
    event(
        name="contact-that-chatters",
        sentence="The end of a contact is reported twice: in its middle and at its end.",
        on=("bounce", "knock", "hertz"),
        sees=("event-times", "release"),
        after=_chattering,
    ),
    event(
        name="impact-told-of-another-body",
        sentence="An impact between two of three balls is reported for the third one.",
        on=("cradle",),
        sees=("event-times", "contact"),
        after=_each(_of_third_body),
    ),
    event(
        name="impact-told-twice",
        sentence="The first impact is reported again in the next step.",
        on=("cradle", "drop"),
        sees=("event-times", "contact"),
        after=_first_twice,
    ),
    event(
        name="release-where-the-force-turns",
        sentence=(
            "The end of a contact is reported where the force becomes attractive, not where the"
            " overlap ends."
        ),
        on=("knock",),
        sees=("event-times", "release"),
        after=_each(_where_force_turns),
    ),
)
