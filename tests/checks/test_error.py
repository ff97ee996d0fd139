"""The error at the finest level is held to what the run still changed by, of steps and of
tolerances.
"""

from dataclasses import replace

import pytest

from refdem.campaign.in_process import record_of, task_of, truth_of
from refdem.core import discovery
from refdem.faults.fault import Fault


def off_by(part):
    """Velocities and spins go wrong in the course of time, at the end by a part, whatever the
    tolerance.
    """

    def after(request, run):
        grown = (1 + part * run.t / run.t[-1])[:, None, None]
        return replace(run, velocity=run.velocity * grown, omega=run.omega * grown)

    return Fault(name="off", kind="", sentence="", on=(), sees=("error", "omega"), after=after)


@pytest.mark.parametrize(("case", "part"), [("free-rigid-body", 1e-9), ("two-body-orbit", 5e-8)])
def test_what_no_tolerance_removes_is_seen_below_a_thousand_times_the_tolerance(case, part):
    """The claim alone allows 2.5e-9 and 1.3e-7 at a tolerance of 1e-10."""
    engine = discovery.engine("rebound")
    instance = discovery.case(case).at()
    truth = truth_of(instance)
    carriers = (engine, off_by(part).carrier(engine))
    sound, wrong = (
        record_of(task_of(carrier, "bs", instance, truth, 4, ("error",))) for carrier in carriers
    )
    assert {
        f.quantity: f.sentence for f in sound.findings if f.check == "error" and f.outcome != "pass"
    } == {}
    failed = [f for f in wrong.findings if f.check == "error" and f.outcome == "fail"]
    assert failed
    assert "implied by the last change of tolerance" in failed[0].sentence
