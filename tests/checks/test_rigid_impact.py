"""rigid-impact: it passes true impacts, fails its faults, says where it is
undecided.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.engine import Engine
from refdem.core.finding import Finding
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of

NAME = "rigid-impact"
SKEW = {"friction": "1/16", "spins": "1,2,3,-1,1/2,4", "offset": "1/2,1/3"}
GRIPPING = {**SKEW, "friction": "100", "tangential_restitution": "1/2"}


def found(engine: Engine, method: str, **given: str) -> dict[str, Finding]:
    """The findings of this check alone, by quantity; it does not ask for truth."""
    instance = discovery.case("hard-spheres").at(**given)
    task = task_of(engine, method, instance, truth_of(instance), 4, (NAME,))
    return {f.quantity: f for f in record_of(task).findings if f.check == NAME}


@pytest.mark.parametrize("given", [{}, SKEW, GRIPPING, {"restitution": "0"}])
def test_the_reference_and_the_transparent_engine_pass(given: dict[str, str]) -> None:
    for engine, method in ((ENGINE, "impacts"), (Transparent(), "verlet")):
        outcomes = {name: f.outcome for name, f in found(engine, method, **given).items()}
        assert outcomes == {"restitution": "pass", "cone": "pass"}


@pytest.mark.parametrize(
    ("fault", "quantity", "given"),
    [
        ("restitution-twice", "restitution", SKEW),
        ("restitution-one-in-a-million", "restitution", SKEW),
        ("impact-below-a-threshold", "restitution", SKEW),
        ("impact-met-twice", "restitution", SKEW),
        ("impact-never-met", "restitution", SKEW),
        ("impact-friction-unlimited", "cone", SKEW),
    ],
)
def test_a_fault_is_seen(fault: str, quantity: str, given: dict[str, str]) -> None:
    (wrong,) = chosen([fault])
    assert found(wrong.carrier(), "verlet", **given)[quantity].outcome == "fail"


def test_the_restitution_that_is_seen_is_told_beside_that_of_the_law() -> None:
    (twice,) = chosen(["restitution-twice"])
    sentence = found(twice.carrier(), "verlet", restitution="3/4")["restitution"].sentence
    assert "0.5625 observed, 0.75 by the law" in sentence


def test_a_method_that_sees_impacts_late_is_undecided_at_steps_that_hide_them() -> None:
    """The same engine, which now claims no more than to see an impact at the end of a step."""
    engine = Transparent()
    engine.methods = tuple(replace(m, locates_events=False) for m in engine.methods)
    instance = discovery.case("hard-spheres").at(samples="2", **SKEW)
    task = task_of(engine, "verlet", instance, truth_of(instance), 1, (NAME,))
    findings = [f for f in record_of(task).findings if f.check == NAME]
    assert [f.outcome for f in findings] == ["undecided"]


@pytest.mark.parametrize(
    ("case", "first"),
    [
        ("hard-spheres", "at rest"),
        ("hard-spheres", "apart"),
        ("hard-spheres", "past"),
        ("hard-wall", "at rest"),
        ("hard-wall", "apart"),
    ],
)
def test_a_run_that_begins_without_an_approach_has_no_impact_and_no_division(
    case: str, first: str
) -> None:
    """The scene closes; what a program wrote as its first sample does not."""
    check = discovery.check(NAME)
    instance = discovery.case(case).at()
    run, cost = ENGINE.run(Request(problem=instance.problem, method="impacts"))
    velocity = run.velocity.copy()
    if first == "at rest":
        velocity[0] = 0.0
    elif first == "apart":
        velocity[0] *= -1.0
    else:
        velocity[0] = np.cross(velocity[0], (0.0, 0.0, 1.0))
    subject = Subject(instance, ENGINE.method("impacts"), (0.0,), truth_of(instance))
    completed = CompletedRun(replace(run, velocity=velocity), cost)
    (finding,) = check.judge(subject, {subject.finest: completed})
    assert finding.outcome == "undecided"


def test_other_scenes_are_left_out() -> None:
    instance = discovery.case("two-spheres").at(damping="1")
    task = task_of(Transparent(), "verlet", instance, truth_of(instance), 3, (NAME,))
    assert [f for f in record_of(task).findings if f.check == NAME] == []
