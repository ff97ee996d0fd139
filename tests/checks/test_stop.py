"""A stop is late or early by no more than what the error allowed hides: a last half cycle that is
slower is unseen.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.planning import plan
from refdem.planning.in_process import record_of, truth_of
from refdem.planning.specification import Specification

SLOW_END = {"mass": "1.42", "stiffness": "3.829", "friction_force": "0.378", "x0": "1.099"}


def test_a_last_half_cycle_slower_than_the_error_allowed_is_no_early_stop(judge):
    """Truth itself, judged as a run of first order: the last half cycle has an amplitude of about a
    hundredth of the first.
    """
    found = judge("stop", "coulomb-oscillator", "first", **SLOW_END)
    assert {quantity: f.sentence for quantity, f in found.items() if f.outcome == "fail"} == {}


EDGE = {
    "README": {"friction_force": "0.2"},
    "one half cycle": {"friction_force": "1/2", "x0": "3/2"},
    "stiffer": {"stiffness": "2", "friction_force": "0.4"},
    "decimals": {"mass": "2", "stiffness": "3", "friction_force": "0.3", "x0": "1.1"},
    "just held": {"friction_force": "0.2000001"},
    "just not held": {"friction_force": "0.1999999"},
    "never released": {"friction_force": "1"},
}
"""Settings whose stop lies at the edge k|x| = f, or within the error of a method beside it."""


@pytest.mark.parametrize("name", EDGE)
@pytest.mark.parametrize("engine", ["reference", "pymunk", "mujoco"])
def test_a_stop_at_the_edge_is_decided_by_the_error_of_the_method(engine, name):
    instance = discovery.case("coulomb-oscillator").at(**EDGE[name])
    truth = truth_of(instance)
    specification = Specification(name="edge", case=[], levels=4, most_steps=1e4)
    tasks = plan.tasks(specification, instance, (), discovery.engine(engine), truth, truth.reason)
    records = [record_of(task) for task in tasks if task.unsupported is None]
    assert records
    wrong = [
        f"{record.id(finding)}: {finding.sentence}"
        for record in records
        for finding in record.findings
        if finding.outcome in ("fail", "error")
    ]
    assert wrong == []


def moved_after_the_stop(distance):
    """The true run, which from t = 15 s on creeps inwards by this distance [m] in all."""

    def moved(run, level):
        late = np.clip((run.t - 15.0) / (run.t[-1] - 15.0), 0.0, 1.0)
        position = run.position.copy()
        position[:, 0, 0] -= distance * late
        return replace(run, position=position)

    return moved


@pytest.mark.parametrize("friction", ["0.2", "0.15", "0.1999999"])
def test_creep_is_seen_at_the_edge_too(judge, friction):
    given = {"friction_force": friction}
    assert judge("stop", "coulomb-oscillator", "first", **given)["creep"].outcome == "pass"
    fault = moved_after_the_stop(1e-9)
    creep = judge("stop", "coulomb-oscillator", "first", fault, **given)["creep"]
    assert creep.outcome == "fail", creep.sentence


def test_a_body_slides_as_far_as_its_state_lets_it(judge):
    """At k = m = 1 and f = 0.2 a body that is 1e-6 beyond the edge slides by 2e-6; allowed is twice
    that, and no more.
    """

    def slid(by):
        def slides(run, level):
            position = run.position.copy()
            stopped = np.flatnonzero(run.t > 6.3)
            position[stopped, 0, 0] += 1e-6
            position[stopped[8:], 0, 0] -= by
            return replace(run, position=position)

        return slides

    for by, outcome in ((2e-6, "pass"), (3.99e-6, "pass"), (4.01e-6, "fail")):
        found = judge("stop", "coulomb-oscillator", "first", slid(by), friction_force="0.2")
        assert found["creep"].outcome == outcome, found["creep"].sentence
