"""The way back where errors grow: steps so fine that it is predictable, and nothing where no step
is.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_columns, scaled
from refdem.faults.fault import Fault
from refdem.planning.in_process import record_of, task_of, truth_of


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


@pytest.mark.parametrize(("part", "levels", "outcome"), [(0.0, 2, "pass"), (0.1, 3, "fail")])
def test_a_finer_step_is_taken_only_where_the_finest_of_the_plan_does_not_decide(
    part, levels, outcome
):
    """Of a turning pendulum in pymunk, which comes back within 2e-4 of the scale; or which has lost
    a part of its velocity then.
    """
    engine = discovery.engine("pymunk")
    instance = discovery.case("pendulum").at(theta0="0", thetadot0="3")
    start = instance.scene.bodies.position

    def after(request, run):
        if np.array_equal(request.problem.scene.bodies.position, start):
            return run
        return of_columns(velocity=scaled(1 - part))(request, run)

    lossy = Fault(
        name="loss", kind="", sentence="", on=(), sees=("reversal", "reversed"), after=after
    )
    task = task_of(
        lossy.carrier(engine), "semi-implicit-euler", instance, truth_of(instance), 4, ("reversal",)
    )
    runs = {}
    findings = {finding.quantity: finding for finding in record_of(task, runs).findings}
    assert findings["reversed"].outcome == outcome
    assert len({variant.level for variant in runs if variant.goes_on}) == levels
