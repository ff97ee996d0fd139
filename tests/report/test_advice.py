"""Advice on method and step, against numbers counted by hand."""

import math

import pytest

from refdem.core.finding import CaseSheet, EngineSheet, Finding, Level, Record
from refdem.report import advice
from refdem.report.contents import contents_of

TAU = 0.5
DURATION = 10.0


def level(step, error):
    return Level(level=step, error=error, bound=2 * error, seconds=0.01 / (step or 1), counts=True)


def case(label="a"):
    return CaseSheet(
        case="a",
        label=label,
        title="",
        statement="",
        latex="",
        source="",
        parameters={},
        units={},
        scene="",
        scales={"L": 1.0, "tau": TAU, "T": DURATION, "mass": 1.0},
        quantities={},
        truth_method="",
        truth_witness="",
        truth_scalars={},
    )


def engine(default_step=None, name="e"):
    return EngineSheet(
        engine=name,
        title="",
        version="1",
        licence="",
        is_reference=False,
        methods={},
        audit=(),
        default_step=default_step,
    )


def record(*levels, order=2.0, seen=2.0, method="m", label="a", name="e", quantity="x"):
    errors = Finding(
        check="error",
        quantity=quantity,
        outcome="pass",
        sentence="",
        levels=levels,
        order_claimed=order,
        order_seen=seen,
    )
    measured = Finding(
        check="order", quantity="state", outcome="pass", sentence="", order_seen=seen
    )
    return Record(
        case="a",
        label=label,
        parameters={},
        engine=name,
        version="1",
        method=method,
        is_reference=False,
        runs=(),
        findings=(errors, measured),
    )


SECOND_ORDER = (level(0.1, 1e-2), level(0.05, 2.5e-3), level(0.025, 6.25e-4))


def only_choice(digits, *levels, **claims):
    contents = contents_of([case(), engine(), record(*levels, **claims)])
    (choice,) = advice.choices(contents, digits)
    return choice


def test_the_largest_step_is_chosen_from_which_on_every_error_is_small_enough():
    choice = only_choice(2.5, *SECOND_ORDER)
    assert choice.level == 0.05
    assert choice.error == 2.5e-3
    assert not choice.is_coarsest
    assert not choice.is_extrapolated
    # tau/h steps, and the seconds of the run over the duration of the motion.
    assert choice.steps_per_tau == TAU / 0.05
    assert choice.cost == pytest.approx(0.01 / 0.05 / DURATION)


def test_a_small_error_at_one_coarse_step_by_chance_is_no_advice():
    choice = only_choice(2.5, level(0.1, 1e-5), level(0.05, 1e-2), level(0.025, 1e-3))
    assert choice.level == 0.025


def test_where_the_coarsest_step_holds_a_larger_one_may():
    choice = only_choice(2, *SECOND_ORDER)
    assert choice.level == 0.1
    assert choice.is_coarsest


def test_a_step_that_did_not_run_follows_from_the_measured_order():
    choice = only_choice(math.log10(1 / 6.25e-6), *SECOND_ORDER)
    assert choice.is_extrapolated
    # A hundredth of the error takes a tenth of the step and ten times the cost.
    assert choice.level == pytest.approx(0.0025)
    assert choice.error == pytest.approx(6.25e-6)
    assert choice.cost == pytest.approx(10 * 0.01 / 0.025 / DURATION)


def test_an_order_above_the_claimed_one_is_not_trusted():
    slow = only_choice(5, *SECOND_ORDER, order=2.0, seen=2.0)
    fast = only_choice(5, *SECOND_ORDER, order=2.0, seen=8.0)
    assert fast.level == slow.level


@pytest.mark.parametrize("seen", [None, 0.4, 0.0, -1.0])
def test_an_error_that_hardly_falls_is_not_extrapolated(seen):
    choice = only_choice(6, *SECOND_ORDER, seen=seen)
    assert choice.level is None
    assert choice.error == 6.25e-4
    assert choice.cost == math.inf


def test_no_step_is_extrapolated_farther_than_a_hundred_times():
    within = only_choice(-math.log10(6.25e-4 / 99.0**2), *SECOND_ORDER)
    beyond = only_choice(-math.log10(6.25e-4 / 101.0**2), *SECOND_ORDER)
    assert within.is_extrapolated
    assert beyond.level is None


def test_a_tolerance_is_chosen_and_never_extrapolated():
    levels = (level(1e-4, 1e-3), level(1e-6, 1e-6), level(1e-8, 1e-8))
    assert only_choice(5, *levels, order=None).level == 1e-6
    assert only_choice(5, *levels, order=None).steps_per_tau is None
    assert only_choice(12, *levels, order=None).level is None


def test_the_steps_that_a_tolerance_took_are_counted_in_the_shortest_time():
    taken = [
        Level(level=1e-4, error=1e-3, bound=1.0, seconds=1.0, counts=False, steps=40),
        Level(level=1e-6, error=1e-6, bound=1.0, seconds=2.0, counts=False, steps=80),
    ]
    contents = contents_of([case(), engine(), record(*taken, order=None)])
    (one,) = advice.recommendations(advice.choices(contents, 5))
    # 80 steps in 10 s of motion: 4 in tau = 0.5 s.
    assert one.most_steps_per_tau == 80 * TAU / DURATION
    assert one.steps_per_tau is None


def test_steps_of_a_tolerance_that_nobody_counted_are_more_than_any():
    levels = (level(1e-4, 1e-3), level(1e-6, 1e-6))
    contents = contents_of([case(), engine(), record(*levels, order=None)])
    (one,) = advice.recommendations(advice.choices(contents, 5))
    assert one.most_steps_per_tau == math.inf


def test_an_exact_method_needs_no_step():
    choice = only_choice(9, level(0.0, 1e-14), order=None)
    assert choice.control == "exact"
    assert choice.steps_per_tau is None


def test_methods_that_hold_more_settings_come_first_then_the_cheaper():
    cheap = (level(0.1, 1e-4), level(0.05, 1e-5))
    dear = (level(0.01, 1e-4), level(0.005, 1e-5))
    contents = contents_of(
        [
            case("a"),
            case("a[x=1]"),
            engine(),
            record(*dear, method="everywhere-dear"),
            record(*dear, method="everywhere-dear", label="a[x=1]"),
            record(*cheap, method="everywhere-cheap"),
            record(*cheap, method="everywhere-cheap", label="a[x=1]"),
            record(*cheap, method="once"),
            record(level(0.1, 1.0), level(0.05, 1.0), method="never", seen=0.0),
        ]
    )
    found = advice.recommendations(advice.choices(contents, 3))
    names = [one.method for one in found]
    assert names == ["everywhere-cheap", "everywhere-dear", "once", "never"]
    assert [one.holds for one in found] == [True, True, True, False]
    assert found[0].steps_per_tau == TAU / 0.1


def test_steps_are_enough_for_every_setting():
    contents = contents_of(
        [
            case("a"),
            case("a[x=1]"),
            engine(),
            record(*SECOND_ORDER),
            record(level(0.1, 1.0), level(0.05, 1e-1), level(0.0125, 1e-3), label="a[x=1]"),
        ]
    )
    (one,) = advice.recommendations(advice.choices(contents, 2))
    assert one.steps_per_tau == TAU / 0.0125


def loss_at(step, *levels, **claims):
    contents = contents_of([case(), engine(step), record(*levels, **claims)])
    (loss,) = advice.losses(contents)
    return loss


def test_the_error_at_the_default_step_lies_between_those_measured():
    loss = loss_at(0.1 / math.sqrt(2), *SECOND_ORDER)
    # Half way in the logarithm of the step is half way in that of the error.
    assert loss.error == pytest.approx(math.sqrt(1e-2 * 2.5e-3))
    assert not loss.is_least
    assert not loss.is_extrapolated
    assert loss.finding == "a/e/m/error/x"


def test_a_default_step_beyond_all_that_ran_has_at_least_the_error_of_the_coarsest():
    loss = loss_at(1.0, *SECOND_ORDER)
    assert loss.error == 1e-2
    assert loss.is_least


def test_a_default_step_below_all_that_ran_is_extrapolated():
    loss = loss_at(0.0025, *SECOND_ORDER)
    assert loss.error == pytest.approx(6.25e-6)
    assert loss.is_extrapolated


def test_the_loss_of_a_method_is_that_of_its_worst_setting():
    contents = contents_of(
        [
            case("a"),
            case("a[x=1]"),
            engine(0.1),
            record(*SECOND_ORDER),
            record(level(0.1, 0.3), level(0.05, 0.1), label="a[x=1]"),
        ]
    )
    (loss,) = advice.losses(contents)
    assert loss.record.label == "a[x=1]"
    assert loss.error == pytest.approx(0.3)


def test_an_engine_without_a_default_step_loses_nothing_by_it():
    assert advice.losses(contents_of([case(), engine(None), record(*SECOND_ORDER)])) == []


def test_settings_in_which_an_engine_measured_nothing_are_told():
    contents = contents_of([case("a"), case("a[x=1]"), engine(), record(*SECOND_ORDER)])
    assert advice.without(contents) == {"e": ["a[x=1]"]}
