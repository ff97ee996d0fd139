"""Times of events: the reference's are certified ones, wrong ones are seen, and the bound is what
errors of the state can do.
"""

from dataclasses import replace
from fractions import Fraction
from math import exp, inf
from types import SimpleNamespace

import numpy as np
import pytest

from refdem.checks._crossings import Crossing, crossings, shift
from refdem.checks._shown_events import shown_events
from refdem.checks.event_times import CHECK, interpolated
from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Request
from refdem.core.refinement import levels
from refdem.core.trajectory import Cost, Event
from refdem.planning.in_process import truth_of

REFERENCE = discovery.engine("reference")
TRUTHS = {}
BELT = {"x0": "2"}
WALL = {"member": "dem-05-hertz"}
DAMPED = {"damping": "1"}
OBLIQUE = DAMPED | {
    "angle": "1/2",
    "friction": "1/4",
    "tangential_stiffness": "96",
    "masses": "1,3",
    "radii": "1/2,3/4",
}


def trial_of(case, method, **given):
    """The subject of a case in a method of the reference."""
    key = case + str(sorted(given.items()))
    if key not in TRUTHS:
        instance = discovery.case(case).at(**given)
        TRUTHS[key] = instance, truth_of(instance)
    instance, truth = TRUTHS[key]
    claims = REFERENCE.method(method)
    return Subject(instance, claims, levels(instance, claims, 4, 1e5), truth)


def run_of(subject):
    """The run of the finest level."""
    if subject.method.control == "step":
        step = subject.levels[-1]
    else:
        step = None
    return REFERENCE.run(
        Request(problem=subject.instance.problem, method=subject.method.name, step=step)
    )[0]


def found(subject, change=lambda events: events):
    """Findings by kind, with the events of the run changed."""
    assert CHECK.applies(subject) is None
    run = run_of(subject)
    spoiled = replace(run, events=tuple(change(run.events)))
    return {
        finding.quantity: finding
        for finding in CHECK.judge(
            subject, {subject.finest: CompletedRun(spoiled, Cost(seconds=0.0))}
        )
    }


@pytest.mark.parametrize(
    ("case", "method", "given", "kinds"),
    [
        ("stick-slip", "stick-slip", BELT, {"stick", "slip"}),
        ("stick-slip", "stick-slip", {"belt": "-1", "gamma": "0.7"}, {"stick", "slip"}),
        ("coulomb-oscillator", "exact-coulomb", {}, {"stop"}),
        ("coulomb-oscillator", "stick-slip", {"x0": "-1", "v0": "1/3"}, {"stick"}),
        ("two-spheres", "exact-head-on", DAMPED, {"release"}),
        ("two-spheres", "exact-head-on", {"cutoff": "zero_force", "damping": "6"}, {"release"}),
        ("two-spheres", "oblique-contact", OBLIQUE, {"release"}),
        ("two-spheres", "contact-events", OBLIQUE | {"cutoff": "zero_force"}, {"release"}),
        ("two-spheres", "velocity-verlet", DAMPED, {"release"}),
        ("two-spheres", "rk4", OBLIQUE, {"release"}),
        ("hertz-spheres", "exact-hertz", {}, {"release"}),
        ("wedge-collision", "exact-wedge", {}, {"release"}),
        ("impact-benchmarks", "exact-hertz-wall", WALL, {"release"}),
        ("impact-benchmarks", "contact-events", {"member": "three-spheres"}, {"release"}),
    ],
)
def test_the_reference_tells_certified_times(case, method, given, kinds):
    seen = found(trial_of(case, method, **given))
    assert set(seen) == kinds
    assert {
        kind: finding.sentence for kind, finding in seen.items() if finding.outcome != "pass"
    } == {}


def moved(kind, by):
    """All events of a kind a time [s] late."""
    return lambda events: [Event(e.time + by * (e.kind == kind), e.kind, e.body) for e in events]


@pytest.mark.parametrize(
    ("case", "method", "given", "kind", "change"),
    [
        ("stick-slip", "stick-slip", BELT, "stick", moved("stick", 1e-10)),
        ("stick-slip", "stick-slip", BELT, "slip", moved("slip", -1e-10)),
        (
            "stick-slip",
            "stick-slip",
            BELT,
            "slip",
            lambda events: [e for e in events if e.time < 10],
        ),
        (
            "stick-slip",
            "stick-slip",
            BELT,
            "slip",
            lambda events: [*events, Event(events[0].time, "slip", 0)],
        ),
        ("coulomb-oscillator", "exact-coulomb", {}, "stop", moved("stop", 1e-10)),
        ("two-spheres", "exact-head-on", DAMPED, "release", moved("release", 1e-10)),
        (
            "two-spheres",
            "exact-head-on",
            DAMPED,
            "contact",
            lambda events: [*events, Event(0.1, "contact", 0)],
        ),
        ("two-spheres", "velocity-verlet", DAMPED, "release", moved("release", 2e-4)),
        ("two-spheres", "rk4", DAMPED, "release", moved("release", 1e-8)),
        ("hertz-spheres", "rk4", {}, "release", moved("release", 1e-5)),
        (
            "two-spheres",
            "exact-head-on",
            {"damping": "40"},
            "release",
            lambda events: [Event(0.05, "release", 0)],
        ),
        ("hertz-spheres", "exact-hertz", {}, "release", moved("release", 1e-10)),
        ("wedge-collision", "exact-wedge", {}, "release", moved("release", 1e-10)),
        ("impact-benchmarks", "exact-hertz-wall", WALL, "release", moved("release", 1e-14)),
    ],
)
def test_events_that_are_wrong_are_seen(case, method, given, kind, change):
    spoiled = found(trial_of(case, method, **given), change)[kind]
    assert spoiled.outcome == "fail"
    assert spoiled.margin < 0


def test_an_event_may_be_told_for_both_bodies_and_others_are_not_judged():
    subject = trial_of("two-spheres", "exact-head-on", **DAMPED)
    seen = found(
        subject,
        lambda events: [
            *events,
            *(Event(e.time, e.kind, 1) for e in events),
            Event(0.1, "sparks", 0),
        ],
    )
    assert {kind: finding.outcome for kind, finding in seen.items()} == {"release": "pass"}
    assert found(subject, lambda events: ()) == {}


AT_WALL = {"member": "co-6"}
TELLS = frozenset({"contact", "release"})


def telling(subject):
    """The subject with a method that claims to tell every contact and release."""
    return replace(subject, method=replace(subject.method, tells=TELLS))


@pytest.mark.parametrize(
    ("case", "method", "given"),
    [("two-spheres", "velocity-verlet", DAMPED), ("impact-benchmarks", "rk4", AT_WALL)],
)
def test_an_event_that_is_claimed_to_be_told_is_missed_in_a_run_without_any(case, method, given):
    subject = trial_of(case, method, **given)
    whole = found(telling(subject))
    assert {kind: finding.outcome for kind, finding in whole.items()} == {
        "contact": "undecided",
        "release": "pass",
        "release-shown": "pass",
    }
    silent = found(telling(subject), lambda events: ())
    assert silent["release"].outcome == "fail"
    assert "(0 reported, 1 expected" in silent["release"].sentence
    # A contact at the first sample may be left out.
    assert silent["contact"].outcome == "undecided"
    assert found(subject, lambda events: ()) == {}


@pytest.mark.parametrize("kind", sorted(TELLS))
def test_an_event_that_the_samples_show_must_be_told_where_truth_has_no_event_times(kind):
    subject = trial_of("impact-benchmarks", "velocity-verlet", member="dem-01")
    assert CHECK.applies(subject) == "no event times are certified for such scenes"
    run = run_of(subject)
    shown = [
        Event(shown.by, shown.kind, shown.bodies[0])
        for of_kind in sorted(TELLS)
        for shown in shown_events(subject, run, of_kind)
    ]
    assert {event.kind for event in shown} == TELLS
    claiming = telling(subject)
    told = found(claiming, lambda events: shown)
    assert {name: finding.outcome for name, finding in told.items()} == {
        "contact-shown": "pass",
        "release-shown": "pass",
    }
    last = [event for event in shown if event.kind == kind][-1]
    spoiled = found(claiming, lambda events: [event for event in shown if event != last])
    (other,) = TELLS - {kind}
    assert spoiled[f"{kind}-shown"].outcome == "fail"
    assert "of body 0 before t = " in spoiled[f"{kind}-shown"].sentence
    assert spoiled[f"{other}-shown"].outcome == "pass"


def test_a_touch_that_is_there_from_the_start_may_be_told_but_need_not():
    seen = found(
        trial_of("two-spheres", "exact-head-on", **DAMPED),
        lambda events: [Event(0.0, "contact", 0), *events],
    )
    assert seen["contact"].outcome == "pass"


@pytest.mark.parametrize(("located", "outcome"), [(False, "pass"), (True, "fail")])
def test_a_method_that_sees_events_at_steps_may_be_a_step_late(located, outcome):
    subject = trial_of("two-spheres", "rk4", **DAMPED)
    subject = replace(subject, method=replace(subject.method, locates_events=located))
    assert found(subject, moved("release", subject.levels[-1]))["release"].outcome == outcome
    if not located:
        assert found(subject, moved("release", 2 * subject.levels[-1]))["release"].outcome == "fail"


def test_what_comes_too_slowly_is_not_decided():
    subject = trial_of("two-spheres", "velocity-verlet", damping="15", cutoff="zero_force")
    seen = found(subject)["release"]
    assert seen.outcome == "undecided"
    assert "shifts the time of an event by more than tau/10; use smaller" in seen.sentence
    assert (
        found(subject, moved("release", 1.0))["release"].outcome == "undecided"
    )  # no verdict, not a lenient one


def test_a_crowd_is_left_alone_without_a_look_at_every_pair():
    instance = discovery.case("granular-gas").at(n="1000", boundary="walls")
    subject = Subject(instance, REFERENCE.method("velocity-verlet"), (1.0,), None)
    assert CHECK.applies(subject) == "no event times are certified for such scenes"


def test_without_truth_nothing_is_decided():
    subject = replace(
        trial_of("two-spheres", "exact-head-on", **DAMPED), truth=None, truth_reason="nobody knows"
    )
    assert [(f.quantity, f.outcome) for f in found(subject).values()] == [("release", "undecided")]


def test_a_zero_that_is_reached_in_time_is_the_root_and_one_that_grazes_is_none():
    one = Crossing(0.0, 0.0, 2.0, 3.0, 1.0)
    t = shift(0.1, one)
    assert 2.0 * t - 1.5 * t * t == pytest.approx(0.1, rel=1e-14)
    assert shift(0.1, replace(one, bend=0.0)) == pytest.approx(0.05)
    assert shift(2.0**2 / (2 * 3.0) * 1.001, one) == inf
    assert shift(0.0, replace(one, rate=0.0)) == inf


def test_rates_on_the_belt_are_those_of_the_certified_motion():
    subject = trial_of("stick-slip", "stick-slip", **BELT)
    truth = subject.instance.truth()
    p = subject.instance.p
    scales = subject.instance.scales
    known = crossings(subject, subject.truth)
    h = Fraction(1, 10**6)
    assert len(known["stick"]) > 1
    for one in known["stick"]:
        speed = float(truth.at(Fraction(one.time) - h)["v"].mid) - p.belt
        assert abs(speed) / float(h) / scales.speed == pytest.approx(one.rate, rel=1e-4)
    static = p.a * ((p.mu0 - p.mu1) / (1 + p.lambda0 * p.belt) + p.mu1 + p.lambda1 * p.belt**2)
    for one in known["slip"]:
        t = Fraction(one.time) - h
        pull = p.gamma * np.cos(p.eta * float(t)) - float(truth.at(t)["x"].mid) - static
        assert (p.a * p.mu0 - abs(pull)) / float(h) / scales.length == pytest.approx(
            one.rate, rel=1e-4
        )


@pytest.mark.parametrize("given", [{"damping": "3"}, OBLIQUE])
def test_the_rate_of_parting_is_that_of_the_certified_overlap(given):
    subject = trial_of("two-spheres", "contact-events", **given)
    (one,) = crossings(subject, subject.truth)["release"]
    h = 1e-6
    truth = subject.instance.truth()
    p = subject.instance.p
    at = truth.at(Fraction(one.time) - Fraction(h))
    apart = [float(at[f"r1.{axis}"].mid - at[f"r2.{axis}"].mid) for axis in "xyz"]
    if "angle" not in given:
        dimension = 1
    else:
        dimension = 2
    reach = 2 * dimension**0.5 * subject.instance.scales.length
    assert (p.radii.sum() - np.linalg.norm(apart)) / h / reach == pytest.approx(one.rate, rel=1e-3)


@pytest.mark.parametrize(
    ("case", "method", "given", "change"),
    [
        ("stick-slip", "stick-slip", BELT, {"x0": "2.000001"}),
        ("stick-slip", "stick-slip", BELT, {"v0": "-1e-5"}),
        ("stick-slip", "stick-slip", BELT, {"gamma": "0.500001"}),
        ("coulomb-oscillator", "exact-coulomb", {"v0": "1/2"}, {"v0": "0.50001"}),
        ("two-spheres", "contact-events", OBLIQUE, {"stiffness": "128.0001"}),
        ("two-spheres", "exact-head-on", {"damping": "6"}, {"damping": "6.00001"}),
        ("hertz-spheres", "exact-hertz", {}, {"closing_speed": "1.00001"}),
    ],
)
def test_an_error_of_the_state_moves_events_by_no_more_than_the_bound(case, method, given, change):
    subject = trial_of(case, method, **given)
    duration = {"duration": str(float(subject.instance.scales.duration))}
    run = run_of(subject)
    other = None
    near = discovery.case(case).at(**(given | duration | change))
    other = REFERENCE.run(
        Request(
            problem=subject.instance.problem.__class__(near.scene, subject.instance.times),
            method=method,
        )
    )[0]
    apart = {q.name: np.abs(a - b) / q.scale for q, a, b in observed(subject.instance, run, other)}
    known = crossings(subject, subject.truth)
    compared = 0
    for event, moved in zip(run.events, other.events, strict=True):
        (one,) = [one for one in known[event.kind] if abs(one.time - event.time) < 1e-9]
        last = int(np.searchsorted(run.t, event.time)) - 1
        error = max(float(np.max(values[: last + 1])) for values in apart.values()) * exp(
            one.growth * (event.time - run.t[last])
        )
        assert 0 < abs(moved.time - event.time) <= 1.01 * shift(error, one)
        compared += 1
    assert compared


def observed(instance, run, other):
    """Quantities with their values in two runs."""
    one = instance.observe(run)
    two = instance.observe(other)
    return [(instance.quantities[name], one[name], two[name]) for name in one]


@pytest.mark.parametrize(("order", "share"), [(1, 1.0), (2, 1.0), (3, 1 / 8), (4, 1 / 64)])
def test_an_event_between_steps_is_off_by_a_chord_and_by_less_for_higher_orders(order, share):
    """A chord of g misses its zero by |g''| h^2/(8 |g'|); each order beyond 2 counts h/tau more."""
    step = 0.25
    tau = 2.0
    one = Crossing(time=1.0, radius=0.0, rate=0.5, bend=3.0, growth=0.0)
    subject = SimpleNamespace(
        method=SimpleNamespace(control="step"),
        levels=(2 * step, step),
        order=order,
        instance=SimpleNamespace(scales=SimpleNamespace(tau=tau)),
    )
    chord = 3.0 * step**2 / (8 * 0.5)
    assert interpolated(subject, one) == pytest.approx(chord * share)
    assert interpolated(subject, replace(one, rate=0.0)) == inf
    subject.method.control = "tolerance"
    assert interpolated(subject, one) == 0.0
