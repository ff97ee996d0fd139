"""Chaotic motions: a start moved by one unit in the last place changes no verdict, and without a
horizon it would.
"""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from refdem.checks.lyapunov import Lyapunov
from refdem.core import discovery
from refdem.core.judgement import errors
from refdem.core.refinement import bound, scored
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.execution.worker import no_truth
from refdem.planning import judging, plan
from refdem.planning.in_process import run_of, task_of, truth_of

SHORT = [
    ("stick-slip", {"duration": "40", "samples": "80"}),
    ("double-pendulum", {"duration": "5/4", "samples": "32"}),
]


def perturbed(name, more):
    """The task at what the case says is chaotic, and its runs from starts moved by one ulp."""
    case = discovery.case(name)
    instance = case.at(**{**case.chaotic_at, **more})
    truth = truth_of(instance)
    task = task_of(ENGINE, ENGINE.best(instance.problem).name, instance, truth, 3, ("error",))
    return (
        instance,
        truth,
        task,
        {v: run_of(ENGINE, plan.request(task, v, ulps=1)) for v in task.variants},
    )


@pytest.mark.parametrize(("name", "more"), SHORT)
def test_one_ulp_changes_no_verdict(name, more):
    _, truth, task, runs = perturbed(name, more)
    findings = judging.record(task, "1", runs, []).findings
    assert {f.outcome for f in findings} == {"pass"}
    assert truth.growth().max() > 10


def test_up_to_the_horizon_one_ulp_is_within_bounds_and_after_it_nothing_is():
    instance, truth, task, runs = perturbed("driven-duffing", {"duration": "200", "samples": "200"})
    assert {f.outcome for f in judging.record(task, "1", runs, []).findings} == {"pass"}
    allowed = bound(instance, task.method, 0.0, truth)
    worst = np.maximum.reduce(
        list(errors(instance, runs[task.variants[-1]].trajectory, truth).values())
    )
    count = scored(allowed)
    assert 50 < count < len(worst)
    assert np.all(worst[:count] <= allowed[:count])
    assert np.max(worst[count:]) > 0.01


def test_without_truth_the_exponent_is_undecided_and_not_left_out():
    case = discovery.case("driven-duffing")
    instance = case.at(**case.chaotic_at)
    truth = no_truth("the proof ended")
    task = task_of(ENGINE, ENGINE.best(instance.problem).name, instance, truth, 3, ("lyapunov",))
    runs = {v: run_of(ENGINE, plan.request(task, v)) for v in task.variants}
    found = {
        f.quantity: (f.outcome, f.sentence) for f in judging.record(task, "1", runs, []).findings
    }
    assert found["class"][0] == "pass"
    assert found["exponent"][0] == "undecided"
    assert "the proof ended" in found["exponent"][1]


@pytest.mark.parametrize("eccentricity", ["0.8", "0.9", "0.95"])
def test_a_comet_that_passes_close_by_is_regular_all_the_same(eccentricity):
    instance = discovery.case("two-body-orbit").at(eccentricity=eccentricity)
    task = task_of(ENGINE, "exact-kepler", instance, truth_of(instance), 3, ("lyapunov",))
    (found,) = judging.record(
        task, "1", {v: run_of(ENGINE, plan.request(task, v)) for v in task.variants}, []
    ).findings
    assert (found.quantity, found.outcome) == ("power", "pass")
    assert found.value > 2  # what samples near the last passage show


@pytest.fixture(scope="module")
def turning_over():
    """A body that turns over twice, its truth, and the runs of its closed form."""
    instance = discovery.case("intermediate-axis").at(
        offset="1e-06", direction="3", duration="100", samples="160"
    )
    truth = truth_of(instance)
    task = task_of(ENGINE, "exact-free-body", instance, truth, 3, ("lyapunov",))
    return instance, truth, {v: run_of(ENGINE, plan.request(task, v)) for v in task.variants}


def test_a_body_that_turns_over_has_s_at_all_its_samples(turning_over):
    _, truth, _ = turning_over
    assert truth.until == len(truth.t) == len(truth.sensitivity)
    assert 1e12 < max(truth.sensitivity) < 1e13


@pytest.mark.parametrize(("early", "outcome"), [(1e7, "pass"), (1e5, "fail"), (1.0, "fail")])
def test_neighbours_that_part_faster_than_any_power_are_held_to_s_while_the_motion_is_unstable(
    turning_over, early, outcome
):
    instance, truth, plain_runs = turning_over
    grows_early = msgspec.structs.replace(
        truth, sensitivity=[1.0] * 20 + [early] * (len(truth.sensitivity) - 20)
    )
    task = task_of(ENGINE, "exact-free-body", instance, grows_early, 3, ("lyapunov",))
    runs = dict(plain_runs)
    beside = next(v for v in runs if v.change == "perturbed")
    plain, run = (runs[v].trajectory for v in (task.subject.finest, beside))
    grown = 1 + 5e5 * (np.arange(len(run.t)) / len(run.t)) ** 4  # the fourth power of the time
    moved = plain.omega + (run.omega - plain.omega)[:1] * grown[:, None, None]
    runs[beside] = replace(
        runs[beside], trajectory=replace(run, omega=moved, attitude=plain.attitude)
    )
    assert {f.quantity: f.outcome for f in judging.record(task, "1", runs, []).findings}[
        "power"
    ] == outcome


def lyapunov(name, given, truth=None):
    """What the check finds of the reference's best method, by quantity."""
    instance = discovery.case(name).at(**given)
    task = task_of(
        ENGINE,
        ENGINE.best(instance.problem).name,
        instance,
        truth or truth_of(instance),
        3,
        ("lyapunov",),
    )
    runs = {v: run_of(ENGINE, plan.request(task, v)) for v in task.variants}
    return {f.quantity: f for f in judging.record(task, "1", runs, []).findings}


def test_a_chaotic_motion_has_a_positive_exponent_that_of_truth_within_its_error_bar():
    found = lyapunov("driven-duffing", discovery.case("driven-duffing").chaotic_at)
    assert {name: f.outcome for name, f in found.items()} == {"class": "pass", "exponent": "pass"}
    value, error = map(
        float, re.search(r"exponent \((\S+) \+- (\S+), true", found["exponent"].sentence).groups()
    )
    assert value > 3 * error > 0


@pytest.mark.parametrize(
    "name",
    [
        "free-rigid-body",
        "intermediate-axis",
        "pendulum",
        "duffing",
        "driven-oscillator",
        "coulomb-oscillator",
    ],
)
def test_a_regular_motion_has_none(name):
    tau = discovery.case(name).at().scales.tau
    found = lyapunov(
        name, {"duration": f"{400 * tau:.6g}", "samples": "256"}, no_truth("not asked for")
    )
    assert {quantity: f.outcome for quantity, f in found.items()} == {"power": "pass"}


def parted(times_of_exponent):
    """The finding on the exponent of the logistic map if the neighbour parts that many times as
    fast.
    """
    instance = discovery.case("logistic").at(eta="4", x0="1/3")
    task = task_of(
        ENGINE, ENGINE.best(instance.problem).name, instance, truth_of(instance), 3, ("lyapunov",)
    )
    runs = {v: run_of(ENGINE, plan.request(task, v)) for v in task.variants}
    plain, beside = Lyapunov().needs(task.subject)
    (name,) = runs[plain].trajectory.values
    x, y = (runs[v].trajectory.values[name] for v in (plain, beside))
    grown = np.abs(y - x) / np.abs(y[0] - x[0])
    moved = x + (y - x) * grown ** (times_of_exponent - 1)
    runs[beside] = replace(
        runs[beside], trajectory=Trajectory.of_values(runs[beside].trajectory.t, {name: moved})
    )
    (finding,) = [
        f for f in judging.record(task, "1", runs, []).findings if f.quantity == "exponent"
    ]
    return finding


@pytest.mark.parametrize(("factor", "outcome"), [(1.0, "pass"), (1.15, "fail"), (0.4, "fail")])
def test_an_exponent_is_held_from_above_and_from_below(factor, outcome):
    """Error bars have no place where the run is on the trajectory of truth: three of both would let
    half and twice the exponent pass.
    """
    finding = parted(factor)
    assert finding.outcome == outcome
    assert finding.bound < 0.7 * np.log(2), "narrower than the exponent, ln 2"
