"""Checks of iterations: bounces lie on the wall, exponents tell chaos from order, and nothing is
scored past the horizon.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.bounces import wall
from refdem.core import discovery
from refdem.core.judgement import distances, errors
from refdem.core.maps import RectangleBilliard, StadiumBilliard
from refdem.core.refinement import bound, scored
from refdem.core.selection import Selection
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.faults.catalogue import chosen
from refdem.kills.trials import FaultTrial
from refdem.mechanics.stability import growth
from refdem.planning import judging, plan
from refdem.planning.in_process import record_of, run_of, task_of, truth_of
from refdem.planning.specification import Entry, Specification
from refdem.scene.elements.rod import Rod

CHAOTIC = [("logistic", {"eta": "4", "x0": "1/3"}), ("billiards", {"n": "48"})]
REGULAR = [
    ("logistic", {"eta": "5/2"}),
    ("logistic", {"form": "ode"}),
    ("billiards", {"geometry": "rectangle", "n": "300"}),
]


@pytest.mark.parametrize(
    "name",
    [
        "iterates-six-digits",
        "pushed-along",
        "half-circle-displaced",
        "direction-shrinks",
        "not-reflected",
        "reflection-lossy",
        "reflection-tilted",
        "stadium-tilted",
        "walls-bent",
        "stadium-walls-bent",
    ],
)
def test_lyapunov_bounces_and_beam_are_failed_by_their_faults(name):
    (fault,) = chosen([name])
    assert fault.sees[0] in ("lyapunov", "bounces", "beam")
    kill = FaultTrial(seeds=1, whole=False).kill(fault, 2)
    assert kill.killed
    assert kill.beyond is None or kill.beyond > 0


@pytest.mark.parametrize(("name", "given"), [*CHAOTIC, *REGULAR])
def test_the_reference_is_exact_to_what_the_motion_permits(name, given):
    instance = discovery.case(name).at(**given)
    record = record_of(task_of(ENGINE, "iterated-map", instance, truth_of(instance), 3))
    assert {
        f"{f.check}/{f.quantity}": f.sentence
        for f in record.findings
        if f.outcome not in ("pass", "undecided")
    } == {}
    assert any(f.check == "error" and f.outcome == "pass" for f in record.findings)


@pytest.mark.parametrize(("name", "given"), CHAOTIC)
def test_a_rerun_perturbed_by_one_ulp_holds_its_bounds_up_to_the_horizon_and_breaks_any_after_it(
    name, given
):
    instance = discovery.case(name).at(**given)
    truth = truth_of(instance)
    task = task_of(ENGINE, "iterated-map", instance, truth, 3, ("error",))
    moved = run_of(ENGINE, plan.request(task, Variant(0.0), ulps=1)).trajectory
    allowed = bound(instance, task.method, 0.0, truth)
    count = scored(allowed)
    worst = np.maximum.reduce(list(errors(instance, moved, truth).values()))
    assert 9 < count < truth.until  # the horizon lies inside what truth certifies
    assert np.all(worst[:count] <= allowed[:count])
    assert np.max(worst[count:]) > 0.1  # without a horizon a correct run would fail


def test_a_campaign_with_every_start_moved_by_one_ulp_still_passes():
    for name, given in CHAOTIC:
        instance = discovery.case(name).at(**given)
        task = task_of(ENGINE, "iterated-map", instance, truth_of(instance), 3)
        runs = {v: run_of(ENGINE, plan.request(task, v, ulps=1)) for v in task.variants}
        assert {f.outcome for f in judging.record(task, "1", runs, []).findings} == {"pass"}


def test_what_is_certified_at_the_horizon_decides_where_the_score_ends():
    instance = discovery.case("logistic").at(eta="4", x0="1/3", n="100")
    truth = truth_of(instance)
    method = ENGINE.method("iterated-map")
    allowed = bound(instance, method, 0.0, truth)
    doublings = np.log2(truth.growth())
    assert abs(doublings[60] - 60) < 8  # S is about 2^n
    assert scored(allowed) == int(np.argmax(allowed > 0.1))
    assert 35 < scored(allowed) < 50


@pytest.mark.parametrize(
    "table", [RectangleBilliard(width=3.0, height=2.0), StadiumBilliard(width=4.0, height=2.0)]
)
def test_the_wall_is_where_the_table_ends(table):
    place = np.array([[0.25, 1.0], [-0.5, -1.0], [table.width / 2, 0.0], [0.0, 0.0]])
    off, normal = wall(table, place)
    assert np.allclose(off[:3], 0.0, atol=1e-15)
    assert off[3] < -0.9
    assert np.allclose(normal[:3], [[0, 1], [0, -1], [1, 0]])
    if isinstance(table, RectangleBilliard):
        _, normal = wall(table, np.array([[1.5, 1.0], [1.5, 0.9]]))
        assert normal.tolist() == [[0, 0], [1, 0]]
    else:
        off, normal = wall(table, np.array([[1 + 0.6, 0.8], [-1 - 0.8, -0.6], [1 + 0.7, 0.8]]))
        assert np.allclose(off[:2], 0.0, atol=1e-15)
        assert np.allclose(normal[:2], [[0.6, 0.8], [-0.8, -0.6]])
        assert off[2] > 0.05


def test_growth_tells_powers_of_the_time_from_exponentials():
    t = np.linspace(0.0, 100.0, 201)
    for power in (0, 1, 2):
        seen = growth(t, 1e-8 * (1 + t) ** power * (1 + 0.1 * np.sin(t)))
        assert not seen.is_exponential()
        assert abs(seen.power - power) < 0.2
    for exponent in (0.2, 0.05):
        seen = growth(t, 1e-8 * np.exp(exponent * t) * (1.5 + np.cos(3 * t)))
        assert seen.is_exponential()
        assert abs(seen.exponent - exponent) < max(3 * seen.error, 0.02)


def test_a_turned_start_fits_its_rods_and_is_another_motion():
    for name in ("pendulum", "double-pendulum"):
        instance = discovery.case(name).at()
        moved = instance.problem.perturbed(2**26)
        method = ENGINE.best(instance.problem)
        assert ENGINE.unsupported(moved, method) is None
        rods = [
            rod.distance(moved.scene.bodies.position[None], moved.scene.bodies.attitude[None])[0]
            - rod.length
            for rod in moved.scene.all(Rod)
        ]
        assert np.max(np.abs(rods)) < 1e-15
        assert np.max(np.abs(moved.scene.bodies.position - instance.scene.bodies.position)) > 1e-9


def test_the_selection_has_the_chaotic_cases_and_the_regular_ones():
    selection = discovery.case("lyapunov")
    assert isinstance(selection, Selection)
    entries = plan.instances(Specification(name="t", case=[Entry("lyapunov")]))
    chaotic = {i.case.id for i, only in entries if i.case.is_chaotic(i.p)}
    regular = {i.case.id for i, only in entries if i.case.is_chaotic(i.p) is False}
    assert {only for _, only in entries} == {("lyapunov",)}
    assert chaotic >= {
        "logistic",
        "lorenz",
        "billiards",
        "double-pendulum",
        "driven-duffing",
        "stick-slip",
    }
    assert regular >= {
        "free-rigid-body",
        "intermediate-axis",
        "pendulum",
        "harmonic-oscillator",
        "two-body-orbit",
    }
    assert all(
        i.scales.duration >= 100 * i.scales.tau
        for i, _ in entries
        if "duration" in i.p and not i.case.is_chaotic(i.p)
    )


def test_distances_of_iterations_are_those_of_their_quantities():
    instance = discovery.case("billiards").at(n="3")
    task = task_of(ENGINE, "iterated-map", instance, truth_of(instance), 3)
    run = run_of(ENGINE, plan.request(task, Variant(0.0))).trajectory
    other = replace(run, values=run.values | {"position": run.values["position"] + 0.5})
    assert np.allclose(distances(instance, run, other), 0.5 / instance.scales.length)


def test_a_selection_leaves_out_methods_to_which_its_check_does_not_apply():
    engine = discovery.engine("rebound")
    instance = discovery.case("harmonic-oscillator").at(duration="200")
    specification = Specification(name="t", case=[])
    selected = {
        task.method.name
        for task in plan.tasks(specification, instance, ("lyapunov",), engine, None)
        if task.unsupported is None
    }
    every = {
        task.method.name
        for task in plan.tasks(specification, instance, (), engine, None)
        if task.unsupported is None
    }
    assert "bs" in every
    assert "bs" not in selected
    assert selected
