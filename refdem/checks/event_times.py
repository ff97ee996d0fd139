"""Times of reported events (stick, slip, stop, contact, release) against the certified times."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

from refdem.checks._beside_impacts import may_detect_late
from refdem.checks._crossings import (
    Crossing,
    Crossings,
    crossings,
    error_at,
    has_crossings,
    shift,
)
from refdem.checks._impacts import listed
from refdem.checks._shown_events import ShownEvent, can_show, first_unreported, shown_events
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
from refdem.core.refinement import HORIZON, ROUND_OFF_FACTOR, scored, steps_at
from refdem.core.trajectory import Event, Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant

KINDS = ("contact", "release", "stick", "slip", "stop")
"""Kinds of events that truth may certify; others are not judged."""
Judged = list[tuple[Crossing, float]]
"""Crossings, each with the time [s] by which a reported event may differ from it."""


class EventTimes(Check):
    """At the finest level every certified event is reported, and every reported event is certified,
    each within its bound.

    An error E of the state, in units of its scales, moves a zero of g by E/|g'|, and a little more
    where g'' bends g back: the time t is bounded by |g'| t - |g''| t^2/2 = E. An event with g'^2 <=
    2 |g''| E grazes and need not happen at all. E is the smaller of the claimed bound and of the
    observed error of the run; with the latter, the error of locating a zero between two steps is
    added.

    A kind of event that a run does not report is judged only where the method claims to report
    every event of that kind (`Method.tells`): a method may report some kinds, or the events of some
    contacts, and no others. Contacts and releases that the samples of such a run show are then
    counted, which needs no truth.
    """

    name = "event-times"
    title = "Times of events"
    kills = (
        "an event reported one step late, never or twice, stick reported as slip,"
        " a contact end where only the force changes sign, impacts of the wrong bodies"
    )

    def applies(self, subject: Subject) -> str | None:
        """Points that slide on a belt and shapes in contact that separate, where truth has event
        times.
        """
        if subject.method.tells and can_show(subject):
            return None
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
        """One finding for each kind of event that the run reports, or that its method claims to."""
        reported: dict[str, list[Event]] = {kind: [] for kind in sorted(subject.method.tells)}
        run = runs[subject.finest].trajectory
        for event in run.events:
            reported.setdefault(event.kind, []).append(event)
        findings = self._against_truth(subject, run, reported)
        if can_show(subject):
            for kind in sorted(subject.method.tells):
                shown = shown_events(subject, run, kind)
                if shown:
                    findings.append(self._against_samples(subject, shown, reported[kind]))
        return findings

    def _against_truth(
        self, subject: Subject, run: Trajectory, reported: Mapping[str, list[Event]]
    ) -> list[Finding]:
        """One finding for each reported or claimed kind of event whose times truth may certify."""
        if not has_crossings(subject.instance.scene):
            return []
        truth = certified(subject)
        if truth is None:
            return [
                undecided(self.name, kind, no_truth(subject)) for kind in KINDS if kind in reported
            ]
        predictions = predicted(subject, truth, crossings(subject, truth), run)
        return [
            self._finding(subject, kind, reported[kind], predictions)
            for kind in KINDS
            if kind in reported and kind in predictions.events
        ]

    def _against_samples(
        self, subject: Subject, shown: list[ShownEvent], events: list[Event]
    ) -> Finding:
        """The finding on the events of one kind, one at least, that the samples of the run show."""
        kind = shown[0].kind
        if subject.method.control == "step":
            late = 2 * subject.levels[-1]
        else:
            late = subject.instance.problem.interval
        missing = first_unreported(shown, events, late)
        if missing is None:
            statement = f"Every {kind} that the samples show is reported ({len(shown)} of them)"
        else:
            bodies = " and ".join(str(body) for body in missing.bodies)
            statement = (
                f"The samples show a {kind} of body {bodies} before t = {missing.by:.6g} s, number"
                f" {missing.number} of these, which is not reported"
            )
        return judged(
            check=self.name,
            quantity=f"{kind}-shown",
            value=float(missing is not None),
            bound=0.0,
            unit="1",
            basis=f"the method claims to report every {kind}, between bodies and at walls",
            statement=statement,
        )

    def _finding(
        self, subject: Subject, kind: str, events: list[Event], predictions: "Predicted"
    ) -> Finding:
        """The finding on one kind of event: the pair of reported and certified time that is nearest
        to its bound.
        """
        start = float(subject.instance.times[0])
        tau = subject.instance.scales.tau
        known = predictions.events[kind]
        due = [
            (crossing, allowed)
            for crossing, allowed in known
            if crossing.time - allowed > start and crossing.time + allowed <= predictions.due
        ]
        covered_events = [event for event in events if event.time <= predictions.complete_until]
        if not due and not covered_events:
            return undecided(
                self.name,
                kind,
                predictions.why or "no event is due before the predictability horizon",
            )
        whole = predictions.complete_until - start
        assert subject.truth is not None
        if listed(subject.truth.scalars):
            pairs = one_to_one(covered_events, known, due, whole)
        else:
            # Each certified event with the nearest reported one, then the reverse.
            pairs = [reported(crossing, allowed, events, whole) for crossing, allowed in due]
            pairs += [nearest(event, known, whole) for event in covered_events]
        pairs = [pair for pair in pairs if pair[1] < inf]
        if not pairs:
            return undecided(self.name, kind, predictions.why)
        distance, allowed, time = max(pairs, key=_share_of_bound)
        if located(subject):
            detection = ""
        elif subject.method.control == "step":
            detection = ", plus one step, since the method detects events at the end of a step"
        else:
            detection = (
                ", plus the interval between samples, since the method detects events at the end of"
                " a step of its choice"
            )
        return judged(
            check=self.name,
            quantity=kind,
            value=distance / tau,
            bound=allowed / tau,
            # The signal is the time since the start.
            sight=Sight(allowed / tau, (time - start) / tau),
            unit="1",
            basis=(
                "the error bound of the state divided by the certified rate of the event"
                f" function{detection}"
            ),
            what=(
                f"The error of a reported {kind} time ({len(covered_events)} reported, {len(due)}"
                f" expected; at t = {time:.6g} s), in units of tau,"
            ),
        )


def _share_of_bound(pair: tuple[float, float, float]) -> float:
    """Distance over bound of a pair (distance, bound, time); infinite where the bound is zero."""
    distance, allowed, _ = pair
    if allowed == 0:
        return inf
    return distance / allowed


@dataclass(frozen=True)
class Predicted:
    """Crossings of each kind with the time [s] by which an event may differ from each, as far as
    the motion is predictable.

    Crossings that end before `due` [s] must be reported. An event that is reported before
    `complete_until` [s] must be one of these crossings. `why` is the reason why predictions end.
    """

    events: Mapping[str, Judged]
    due: float
    complete_until: float
    why: str


def reported(
    crossing: Crossing, allowed: float, events: list[Event], whole: float
) -> tuple[float, float, float]:
    """(distance, bound, time) of a certified event to the nearest one that is reported of one of
    its bodies; without any, the distance is `whole`.
    """
    distances = [abs(event.time - crossing.time) for event in events if crossing.is_of(event.body)]
    return min(distances, default=whole), allowed, crossing.time


def nearest(event: Event, known: Judged, whole: float) -> tuple[float, float, float]:
    """(distance, bound, time) of a reported event to the nearest certified one of its body; without
    any, the distance is `whole` and the bound 0.
    """
    pairs = [
        (abs(event.time - crossing.time), allowed, event.time)
        for crossing, allowed in known
        if crossing.is_of(event.body)
    ]
    return min(pairs, default=(whole, 0.0, event.time))


def one_to_one(
    events: list[Event], known: Judged, due: Judged, whole: float
) -> list[tuple[float, float, float]]:
    """(distance, bound, time) of every certified event, from the nearest event that is reported of
    one of its bodies. No reported event is taken twice; the distance is `whole` where none is left.

    An event may be reported once for each of its bodies: others at the same time, within the bound,
    are the same event. Reported events that remain did not happen: their distance is `whole`, their
    bound 0.
    """
    left = sorted(events, key=lambda event: event.time)
    partners: list[tuple[Crossing, float, Event]] = []
    pairs = []
    for crossing, allowed in known:
        of_bodies = [event for event in left if event.body in crossing.bodies]
        if of_bodies:
            partner = min(of_bodies, key=lambda event: abs(event.time - crossing.time))
            distance = abs(partner.time - crossing.time)
        else:
            distance = whole
        is_due = (crossing, allowed) in due
        is_reported = bool(of_bodies) and (is_due or distance <= allowed)
        if is_reported:
            left.remove(partner)
            partners.append((crossing, allowed, partner))
        # An event that may still come is compared only where it is reported.
        if is_due or is_reported:
            pairs.append((distance, allowed, crossing.time))
    for crossing, allowed, partner in partners:
        for event in left:
            is_other_body = event.body in crossing.bodies and event.body != partner.body
            if is_other_body and abs(event.time - crossing.time) <= allowed:
                left.remove(event)
                break
    pairs += [(whole, 0.0, event.time) for event in left]
    return pairs


def predicted(
    subject: Subject, truth: SampledTruth, known: Crossings, run: Trajectory
) -> Predicted:
    """Crossings with their bounds, up to the predictability horizon or the first ill-conditioned
    one.

    The bound on an event's time is `shift` of the state's error, plus the radius of the certified
    time and the rounding of the clock. On a belt nothing is known about events after the last
    certified one, and that one may be reported early; contacts end only once. Impacts in sequence
    that are due from the ill-conditioned one on, until tau/10 after the others, may come earlier or
    later.

    With E the error of the state at the crossing, r the radius of the certified time and c the
    rounding of the clock (`ticks`), the bound is

        min(shift(E_claimed), shift(E_observed) + interpolation) + r + c.
    """
    bound = subject.bound(subject.levels[-1])
    times = subject.instance.times[: truth.until]
    tau = subject.instance.scales.tau
    end = float(times[max(0, scored(bound) - 1)])
    last = float(times[0])
    observed_bound = observed_error_bound(subject, truth, run)
    events: dict[str, Judged] = {kind: [] for kind in known}
    by_time: list[tuple[Crossing, str]] = []
    for name, crossings_of_kind in known.items():
        by_time += [(crossing, name) for crossing in crossings_of_kind]
    by_time.sort(key=lambda pair: pair[0].time)
    for number, (crossing, kind) in enumerate(by_time):
        # E_claimed at the crossing, and the smallest t with |g'| t - |g''| t^2/2 = E_claimed.
        error = error_at(crossing, bound, times)
        shift_by_claims = shift(error, crossing)
        if shift_by_claims > HORIZON * tau:
            reason = (
                "the allowed error of the state shifts the time of an event by more than tau/10;"
                f" use smaller steps. At t = {crossing.time:.6g} s an error of {error:.2g} does"
            )
            if listed(truth.scalars):
                for later, of_kind in by_time[number:]:
                    if later.time <= last + HORIZON * tau:
                        events[of_kind].append((later, inf))
            return Predicted(events, last, last, reason)
        if error > crossing.margin:
            reason = (
                f"at t = {crossing.time:.6g} s a state error of {crossing.margin:.2g} decides which"
                f" event happens, and {error:.2g} is allowed"
            )
            return Predicted(events, last, last, reason)
        # The same with the observed error, plus the error |g''| h^2/(8 |g'|) of the interpolation.
        observed_error = error_at(crossing, observed_bound, times)
        shift_as_observed = shift(observed_error, crossing) + interpolated(subject, crossing)
        smaller_shift = min(shift_by_claims, shift_as_observed)
        # allowed = min(of both) + radius of the certified time + rounding of the clock.
        allowed = smaller_shift + crossing.radius + ticks(subject, crossing.time)
        if crossing.time > end:
            return Predicted(events, end, min(end, crossing.time - allowed), truth.reason)
        events[kind].append((crossing, allowed))
        last = max(last, crossing.time + allowed)
    if "slip" in known:
        return Predicted(events, end, last, truth.reason)
    return Predicted(events, end, end, truth.reason)


def late_by(
    subject: Subject, truth: SampledTruth, known: list[Crossing], run: Trajectory
) -> list[float]:
    """The time [s] by which each of these crossings may come earlier or later in a run, up to the
    first one that cannot be predicted.

    It follows from the error of the state: the smaller one of what the method claims and of what
    the run itself shows.
    """
    times = subject.instance.times[: truth.until]
    bound = subject.bound(subject.levels[-1])
    observed_bound = observed_error_bound(subject, truth, run)
    found = []
    for crossing in known:
        # allowed = min(shift(E_claimed), shift(E_observed) + interpolation) + radius + clock.
        by_claims = shift(error_at(crossing, bound, times), crossing)
        observed_error = error_at(crossing, observed_bound, times)
        as_observed = shift(observed_error, crossing) + interpolated(subject, crossing)
        allowed = min(by_claims, as_observed)
        if allowed == inf:
            break
        found.append(allowed + crossing.radius + ticks(subject, crossing.time))
    return found


def observed_error_bound(subject: Subject, truth: SampledTruth, run: Trajectory) -> Array:
    """Bound (until,) on the error of the run by what it shows itself, at every certified sample.

    bound(t) = room max(error up to t) + floor S(t): the largest error so far with a factor of
    safety (`room_of`), plus the `floor` of the run times the growth S(t) of errors made earlier
    (`SampledTruth.growth`).
    """
    level = subject.levels[-1]
    # bound(t) = room max over s <= t of |e(s)| + floor S(t).
    rounding: Array = subject.floor(level) * truth.growth()
    return room_of(subject) * largest_so_far(subject, level, run, truth) + rounding


def interpolated(subject: Subject, crossing: Crossing) -> float:
    """Error [s] of locating a zero of g between two steps: |g''| h^2/(8 |g'|) for a chord, smaller
    for higher orders.

    A method of order p that reports events at their own times interpolates its steps to order p,
    which adds the factor (h/tau)^(p - 2).
    """
    if subject.method.control != "step":
        return 0.0
    if crossing.rate == 0:
        return inf
    level = subject.levels[-1]
    # |g''| h^2/(8 |g'|), times (h/tau)^(p - 2) for p > 2.
    of_chord = crossing.bend * level**2 / (8 * crossing.rate)
    extra_order = max(0.0, subject.order - 2.0)
    return of_chord * float((level / subject.instance.scales.tau) ** extra_order)


def located(subject: Subject) -> bool:
    """True if events are reported at their own times, not at the end of a step."""
    return subject.method.control == "exact" or subject.method.locates_events


def ticks(subject: Subject, time: float) -> float:
    """Rounding [s] of a clock that is written, or summed step by step; plus one step for methods
    that detect events at its end, or two where they may act on an impact in the step after that. A
    step that a method chooses by a tolerance ends at the next sample at the latest.
    """
    level = subject.levels[-1]
    if subject.method.control == "step":
        roundings = steps_at(subject.instance, subject.method, level)
    else:
        roundings = 0.0
    # u max(ROUND_OFF_FACTOR, number of steps) |t|.
    rounding = subject.method.round_off * max(ROUND_OFF_FACTOR, roundings) * abs(time)
    if located(subject):
        return rounding
    if subject.method.control == "tolerance":
        return rounding + subject.instance.problem.interval
    if may_detect_late(subject):
        # An engine may report an impact when it acts, in the step after that of its detection.
        return rounding + 2 * level
    return rounding + level


CHECK = EventTimes()
