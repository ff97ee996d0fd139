"""The way back where errors grow: steps so fine that it is predictable, and nothing where no step
is.
"""

import pytest

from refdem.campaign.in_process import record_of, task_of, truth_of
from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_columns, scaled
from refdem.faults.fault import Fault


@pytest.mark.parametrize(
    ("case", "method"), [("intermediate-axis", "rk4-free-body"), ("two-body-orbit", "rk4")]
)
def test_a_way_back_is_judged_at_a_step_at_which_it_is_predictable(case, method):
    """At the finest of three levels the claims allow 4 and 115 times the scale: a finer step is
    taken.
    """
    instance = discovery.case(case).at()
    truth = truth_of(instance)
    lossy = Fault(
        name="drag",
        kind="",
        sentence="",
        on=(),
        sees=("reversal", "reversed"),
        after=of_columns(velocity=scaled(0.5), omega=scaled(0.5)),
    )
    sound, lost = (
        record_of(task_of(engine, method, instance, truth, 3, ("reversal",)))
        for engine in (ENGINE, lossy.carrier(ENGINE))
    )
    assert {f.quantity: f.outcome for f in sound.findings if f.quantity != "order"} == {
        "reversed": "pass",
        "backward": "pass",
    }
    assert "fail" in {f.outcome for f in lost.findings}


def test_what_no_step_can_decide_is_undecided_with_its_reason():
    instance = discovery.case("intermediate-axis").at(offset="1e-6", duration="90")
    found = record_of(
        task_of(ENGINE, "rk4-free-body", instance, truth_of(instance), 3, ("reversal",))
    ).findings
    assert found[0].outcome == "undecided"
    assert "predictability" in found[0].sentence
