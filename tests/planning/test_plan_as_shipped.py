"""Engines as shipped run where a campaign asks for them or by name, and nowhere else; what they
lose is seen.
"""

import pytest

from refdem.core import discovery
from refdem.planning import plan
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.planning.specification import Entry, Specification

SHIPPED = {
    "mujoco": "euler-as-shipped",
    "pymunk": "semi-implicit-euler-as-shipped",
    "rebound": "ias15-as-shipped",
}


def planned(engine: str, **given) -> set[str]:
    """The methods of an engine that a campaign of the pendulum runs."""
    specification = Specification(name="test", case=[Entry("pendulum")], **given)
    ((instance, _),) = plan.instances(specification)
    subjects = plan.subjects(specification, instance, discovery.engine(engine))
    return {subject.method.name for subject, _ in subjects}


@pytest.mark.parametrize("engine", SHIPPED)
def test_they_run_where_a_campaign_asks_for_them(engine):
    name = SHIPPED[engine]
    assert name not in planned(engine)
    assert planned(engine, as_shipped=True) == planned(engine) | {name}
    assert planned(engine, method=name) == {name}


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_defaults_that_move_what_rests_are_seen_beside_the_tuned_adapter(engine):
    """Ten iterations in pymunk, a time constant of 0.02 s in MuJoCo."""
    instance = discovery.case("block-on-slope").at(duration="1/2")
    moved = {}
    tuned = SHIPPED[engine].removesuffix("-as-shipped")
    for method in (tuned, SHIPPED[engine]):
        task = task_of(discovery.engine(engine), method, instance, truth_of(instance), 3, ("rest",))
        findings = {finding.quantity: finding for finding in record_of(task).findings}
        moved[method] = findings["displacement"].value
    assert moved[SHIPPED[engine]] > 5 * moved[tuned]
