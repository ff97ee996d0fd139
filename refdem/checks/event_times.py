"""Times of events that a run reports, sticks, slips, stops, touches and partings, against the
certified ones.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp, inf, sqrt

import numpy as np

from refdem.checks._crossings import Crossing, Crossings, crossings, has_crossings
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    Sight,
    certified,
    judged,
    largest_so_far,
    no_truth,
    room_of,
    undecided,
)
from refdem.core.refinement import COUNTING_FLOOR, HORIZON, ROUND_OFF_FACTOR, scored, steps_at
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant

KINDS = ("contact", "release", "stick", "slip", "stop")
"""Words for events that truth may tell; others are not judged."""
MOST_GROWTH = 100.0
"""Powers of e beyond which nothing is predictable."""
Judged = list[tuple[Crossing, float]]
"""Crossings with the time [s] by which an event may be told off them."""


class EventTimes(Check):
    """At the finest level: every certified event is told, and every event told is certified, each
    within its bound.

    An error E of the state, in units of its scales, moves a zero of g by E/|g'|, and a little more
    where g'' bends g back: the time t is bounded by |g'| t - |g''| t^2/2 = E, and an event with
    g'^2 <= 2 |g''| E, which grazes, need not happen at all. E is what the claims allow, or what the
    run is seen to be off by where that is less; then a code may still tell where a chord between
    two steps crosses zero. Runs that report no events are not judged.
    """

    name = "event-times"
    title = "Times of events"
    kills = (
        "an event reported one step late, never or twice, stick reported as slip,"
        " a contact end where only the force changes sign"
    )

    def applies(self, subject: Subject) -> str | None:
        """Points that rub on a belt, shapes in touch that part, where truth has the times."""
        if not has_crossings(subject.instance.scene):
            return "no event times are certified for such scenes"
        if (
            subject.truth is not None
            and certified(subject)
            and not crossings(subject, subject.truth)
        ):
            return "the certified truth has no event times"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for each kind of event that the run reports."""
        told: dict[str, list[float]] = {}
        run = runs[subject.finest].trajectory
        for event in run.events:
            told.setdefault(event.kind, []).append(event.time)
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, kind, no_truth(subject)) for kind in KINDS if kind in told]
        scored = predicted(subject, truth, crossings(subject, truth), run)
        return [
            self._finding(subject, kind, np.array(told[kind]), scored)
            for kind in KINDS
            if kind in told and kind in scored.events
        ]

    def _finding(self, subject: Subject, kind: str, told: Array, scored: "Predicted") -> Finding:
        """The pair that comes nearest to its bound."""
        start = float(subject.instance.times[0])
        tau = subject.instance.scales.tau
        known = scored.events[kind]
        due = [
            (one, allowed)
            for one, allowed in known
            if one.time - allowed > start and one.time + allowed <= scored.due
        ]
        seen = told[told <= scored.told]
        if not due and not len(seen):
            return undecided(
                self.name, kind, scored.why or "no event is due before the predictability horizon"
            )
        pairs = [
            (float(np.min(np.abs(told - one.time))), allowed, one.time) for one, allowed in due
        ]
        pairs += [nearest(float(time), known, scored.told - start) for time in seen]
        off, allowed, time = max(pairs, key=_share_of_bound)
        if located(subject):
            stepped = ""
        else:
            stepped = ", plus one step, since the method detects events at the end of a step"
        return judged(
            check=self.name,
            quantity=kind,
            value=off / tau,
            bound=allowed / tau,
            sight=Sight(allowed / tau, (time - start) / tau),
            unit="1",
            basis=(
                "the error bound of the state divided by the certified rate of the event"
                f" function{stepped}"
            ),
            what=(
                f"The error of a reported {kind} time ({len(seen)} reported, {len(due)}"
                f" expected; at t = {time:.6g} s), in units of tau,"
            ),
        )


def _share_of_bound(pair: tuple[float, float, float]) -> float:
    """The distance of a pair over its bound; infinite where the bound is zero."""
    distance, allowed, _ = pair
    if allowed == 0:
        return inf
    return distance / allowed


@dataclass(frozen=True)
class Predicted:
    """Events of each kind with the time [s] by which each may be told off, as far as the motion is
    predictable.

    Those that end before `due` [s] must be told, and those told before `told` [s] must be one of
    them; `why` says what ends both.
    """

    events: Mapping[str, Judged]
    due: float
    told: float
    why: str


def nearest(time: float, known: Judged, whole: float) -> tuple[float, float, float]:
    """Distance from the nearest certified event, its bound, and the time told; all of the stretch
    judged where there is none.
    """
    found = min(
        ((abs(time - one.time), allowed, time) for one, allowed in known),
        default=(whole, 0.0, time),
    )
    return found


def predicted(
    subject: Subject, truth: SampledTruth, known: Crossings, run: Trajectory
) -> Predicted:
    """Events up to the horizon of the motion, or up to the first that comes too slowly.

    Of a belt nothing is known of what comes after the last event, which may be told too early; all
    else parts or stops once.
    """
    bound = subject.bound(subject.levels[-1])
    times = subject.instance.times[: truth.until]
    tau = subject.instance.scales.tau
    end = float(times[max(0, scored(bound) - 1)])
    last = float(times[0])
    seen = seen_bound(subject, truth, run)
    events: dict[str, Judged] = {kind: [] for kind in known}
    for one, kind in sorted(
        ((one, name) for name, ones in known.items() for one in ones), key=lambda pair: pair[0].time
    ):
        error = error_at(one, bound, times)
        moved = shift(error, one)
        if moved > HORIZON * tau:
            slow = (
                f"event time is ill-conditioned: at t = {one.time:.6g} s a state error of"
                f" {error:.2g} shifts it by more than tau/10"
            )
            return Predicted(events, last, last, slow)
        moved_as_seen = shift(error_at(one, seen, times), one) + interpolated(subject, one)
        allowed = min(moved, moved_as_seen) + one.radius + ticks(subject, one.time)
        if one.time > end:
            return Predicted(events, end, min(end, one.time - allowed), truth.reason)
        events[kind].append((one, allowed))
        last = max(last, one.time + allowed)
    if "slip" in known:
        return Predicted(events, end, last, truth.reason)
    return Predicted(events, end, end, truth.reason)


def error_at(one: Crossing, bound: Array, times: Array) -> float:
    """The bound on the state at an event: that of the next sample, and what an error may grow by
    since the last one.
    """
    following = min(int(np.searchsorted(times, one.time)), len(bound) - 1)
    return float(bound[following]) * exp(
        min(one.growth * max(0.0, one.time - float(times[max(0, following - 1)])), MOST_GROWTH)
    )


def seen_bound(subject: Subject, truth: SampledTruth, run: Trajectory) -> Array:
    """What the run may be off by at each sample (until,) and since the last: what it is seen to be
    off by so far, with room.
    """
    level = subject.levels[-1]
    rounding: Array = COUNTING_FLOOR * subject.noise(level) * truth.growth()
    return room_of(subject) * largest_so_far(subject, level, run, truth) + rounding


def interpolated(subject: Subject, one: Crossing) -> float:
    """How far [s] the zero of g between two steps may be from its own: of a chord |g''| h^2/8 over
    |g'|, less for higher orders.

    A method of order p that claims to tell events at their own times finds them between its steps
    to that order too.
    """
    if subject.method.control != "step":
        return 0.0
    if one.rate == 0:
        return inf
    level = subject.levels[-1]
    of_chord = one.bend * level**2 / (8 * one.rate)
    further = max(0.0, subject.order - 2.0)
    return of_chord * float((level / subject.instance.scales.tau) ** further)


def shift(error: float, one: Crossing) -> float:
    """The least t > 0 [s] with rate t - bend t^2/2 = error; infinity where there is none."""
    left = one.rate * one.rate - 2 * one.bend * error
    if left > 0:
        return 2 * error / (one.rate + sqrt(left))
    return inf


def located(subject: Subject) -> bool:
    """Events are told at their own times, not at the end of a step."""
    return subject.method.control != "step" or subject.method.locates_events


def ticks(subject: Subject, time: float) -> float:
    """Rounding [s] of a clock that is written, or summed step by step, and the step of a method
    that sees events at its end.
    """
    level = subject.levels[-1]
    if subject.method.control == "step":
        summed = steps_at(subject.instance, subject.method, level)
    else:
        summed = 0.0
    rounding = subject.method.round_off * max(ROUND_OFF_FACTOR, summed) * abs(time)
    if located(subject):
        return rounding
    return rounding + level


CHECK = EventTimes()
