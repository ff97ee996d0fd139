"""Events that are told wrongly of a motion that is right: late, of another kind, where nothing
happens.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import acos, sqrt

import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Event, Trajectory
from refdem.faults.fault import Fault
from refdem.scene.elements.contact import Contact

event = partial(Fault, kind="event-times", levels=7)


def _changed(
    change: Callable[[tuple[Event, ...], Request, Trajectory], tuple[Event, ...]],
) -> Callable[[Request, Trajectory], Trajectory]:
    """A trajectory with other events."""
    return lambda request, run: replace(run, events=change(run.events, request, run))


def _moved(event: Event, by: float) -> Event:
    return Event(event.time + by, event.kind, event.body)


def _where_force_turns(
    events: tuple[Event, ...], request: Request, run: Trajectory
) -> tuple[Event, ...]:
    """The contact is told to end when k d + c d' = 0, as if it never pulled: after 2 acos(b/w0)/w,
    b = c/(2 m), w^2 = w0^2 - b^2.
    """
    scene = request.problem.scene
    law = scene.all(Contact)[0]
    mass = scene.bodies.mass
    effective = float(mass.prod() / mass.sum())
    b = law.damping / (2 * effective)
    w0 = sqrt(law.stiffness / effective)
    turned = 2 * acos(b / w0) / sqrt(w0 * w0 - b * b)
    return tuple(Event(turned, event.kind, event.body) for event in events)


FAULTS = (
    event(
        name="release-a-step-late",
        sentence="The end of a contact is told a step late.",
        on=("bounce", "knock", "hertz"),
        sees=("event-times", "release"),
        after=_changed(
            lambda events, request, run: tuple(
                _moved(event, request.signed_step) for event in events
            )
        ),
    ),
    event(
        name="stick-a-step-late",
        sentence="What sticks is told a step late.",
        on=("sticking", "rubbing"),
        sees=("event-times", "stick"),
        after=_changed(
            lambda events, request, run: tuple(
                _moved(event, request.signed_step) for event in events
            )
        ),
    ),
    event(
        name="slip-at-samples",
        sentence="Events are told at the next row that is written.",
        on=("sticking",),
        sees=("event-times", "slip"),
        after=_changed(
            lambda events, request, run: tuple(
                Event(
                    float(run.t[min(int(np.searchsorted(run.t, e.time)), len(run.t) - 1)]),
                    e.kind,
                    e.body,
                )
                for e in events
            )
        ),
    ),
    event(
        name="stick-for-slip",
        sentence="Sticks are told as slips and slips as sticks.",
        on=("sticking",),
        sees=("event-times", "stick"),
        after=_changed(
            lambda events, request, run: tuple(
                Event(e.time, {"stick": "slip", "slip": "stick"}[e.kind], e.body) for e in events
            )
        ),
    ),
    event(
        name="contact-that-chatters",
        sentence="A contact is told to end in the middle, and once more where it ends.",
        on=("bounce", "knock", "hertz"),
        sees=("event-times", "release"),
        after=_changed(
            lambda events, request, run: (
                *(Event(e.time / 2, e.kind, e.body) for e in events),
                *events,
            )
        ),
    ),
    event(
        name="impact-told-of-another-body",
        sentence="Impacts of three balls are told of the one that does not meet.",
        on=("cradle",),
        sees=("event-times", "contact"),
        after=_changed(
            lambda events, request, run: tuple(
                Event(e.time, e.kind, (e.body + 2) % 3) for e in events
            )
        ),
    ),
    event(
        name="impact-told-twice",
        sentence="The first impact is told once more in the next step.",
        on=("cradle", "drop"),
        sees=("event-times", "contact"),
        after=_changed(
            lambda events, request, run: (
                *events,
                *(_moved(e, request.signed_step) for e in events[:1]),
            )
        ),
    ),
    event(
        name="release-where-the-force-turns",
        sentence=(
            "A contact that ends with the overlap is told to end where the dashpot begins to pull."
        ),
        on=("knock",),
        sees=("event-times", "release"),
        after=_changed(_where_force_turns),
    ),
)
