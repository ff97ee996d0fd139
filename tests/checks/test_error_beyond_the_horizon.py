"""What the last halvings of the step leave bounds the error also where the bound on the state has passed its horizon."""

from dataclasses import replace

import numpy as np
import pytest

from refdem.campaign import plan
from refdem.campaign.in_process import truth_of
from refdem.campaign.specification import Specification
from refdem.core import discovery
from refdem.core.check import Outcome
from refdem.core.refinement import scored

SPECIFICATION = Specification(name="test", case=[], levels=3, method="velocity-verlet")
STIFF = {
    **{"masses": "1,3", "radii": "1/2,3/4", "angle": "1/2", "spins": "0,0,1,0,0,-2"},
    **{"friction": "1/4", "tangential_stiffness": "96"},
}


def sound(run):
    return run


def spun_too_far(run):
    """Two per cent of the spin are lost in the second half, at every step alike."""
    late = (run.t > run.t[-1] / 2)[:, None, None]
    return replace(run, omega=np.where(late, 0.98, 1.0) * run.omega)


@pytest.mark.parametrize(("fault", "failed"), [(sound, set()), (spun_too_far, {"omega1.z", "omega2.z"})])
def test_an_error_that_no_step_removes_is_seen_beyond_the_horizon_of_a_method_of_first_order(fault, failed):
    instance = discovery.case("two-spheres").at(**STIFF)
    truth = truth_of(instance)
    (task,) = plan.tasks(SPECIFICATION, instance, ("error",), discovery.engine("reference"), truth)
    method = replace(task.trial.method, order_with={"contact": 1})
    trial = replace(task.trial, method=method, truth=truth)
    assert scored(trial.bound(trial.levels[-1])) < len(instance.times) / 2
    runs = {}
    for variant in trial.plain:
        run, cost = task.engine.run(plan.request(task, variant))
        runs[variant] = Outcome(fault(run), cost)
    found = discovery.check("error").judge(trial, runs)
    assert {finding.quantity for finding in found if finding.outcome == "fail"} == failed
