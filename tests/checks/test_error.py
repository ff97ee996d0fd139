"""The error at the finest level is held to what the run still changed by, of steps and of tolerances."""

import pytest

from refdem.campaign.in_process import record_of, task_of, truth_of
from refdem.core import discovery
from refdem.faults.change import of_columns, scaled
from refdem.faults.fault import Fault


def off_by(part):
    """Velocities and spins are wrong by a part, whatever the tolerance."""
    wrong = of_columns(velocity=scaled(1 + part), omega=scaled(1 + part))
    return Fault(name="off", kind="", sentence="", on=(), sees=("error", "omega"), after=wrong)


@pytest.mark.parametrize(("case", "part"), [("free-rigid-body", 3e-10), ("two-body-orbit", 2e-8)])
def test_what_no_tolerance_removes_is_seen_below_a_thousand_times_the_tolerance(case, part):
    """The claim alone allows 2.5e-9 and 1.3e-7 at a tolerance of 1e-10."""
    engine = discovery.engine("rebound")
    instance = discovery.case(case).at()
    truth = truth_of(instance)
    carriers = (engine, off_by(part).carrier(engine))
    sound, wrong = (record_of(task_of(carrier, "bs", instance, truth, 4, ("error",))) for carrier in carriers)
    assert {f.quantity: f.sentence for f in sound.findings if f.check == "error" and f.outcome != "pass"} == {}
    failed = [f for f in wrong.findings if f.check == "error" and f.outcome == "fail"]
    assert failed
    assert "changed by so little with the last" in failed[0].sentence
