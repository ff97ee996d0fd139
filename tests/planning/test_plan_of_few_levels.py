"""Any case with any number of refinement levels can be asked: what each check needs fits the
samples, however few levels there are.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.engine import Engine, Method
from refdem.core.selection import Selection
from refdem.core.trajectory import Trajectory
from refdem.execution.worker import no_truth
from refdem.planning import plan
from refdem.planning.kept_truth import kept_truth
from refdem.planning.specification import Entry, Specification

CASES = [
    name
    for name in discovery.names("cases")
    if not isinstance(discovery.case(name), Selection)
    and discovery.case(name).at().problem.kind == "motion"
]
CLAIMS = {"reversible": True, "backward": True, "threads": True}
METHODS = (
    *(Method(name=f"order-{p}", summary="", control="step", order=p, **CLAIMS) for p in (1, 2, 4)),
    Method(name="tolerance", summary="", control="tolerance", **CLAIMS),
    Method(name="exact", summary="", control="exact", **CLAIMS),
)


class Anything(Engine):
    """An engine that supports every motion and is never run."""

    name = "anything"
    title = "Anything"
    methods = METHODS

    def missing(self) -> str | None:
        return None

    def version(self) -> str:
        return "1"

    def fingerprint(self, method: Method) -> str:
        return "anything"

    def unsupported_motion(self, problem, method) -> str | None:
        return None

    def run(self, request):
        raise AssertionError("no run is made here")


def ending(task: plan.Task) -> Trajectory:
    """A trajectory of the shape of the run that a variant goes on from: the start, repeated."""
    problem = task.subject.instance.problem
    bodies = problem.scene.bodies
    state = {
        name: np.stack([getattr(bodies, name)] * len(problem.times))
        for name in ("position", "velocity", "attitude", "omega")
    }
    return Trajectory(t=problem.times, **state)


@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("case", CASES)
def test_every_run_that_checks_need_has_whole_steps(case, levels):
    specification = Specification(name="test", case=[Entry(case)], levels=levels)
    ((instance, only),) = plan.instances(specification)
    truth = kept_truth(instance) or no_truth("not kept")
    for task in plan.tasks(specification, instance, only, Anything(), truth):
        base = ending(task)
        for variant in task.variants:
            request = plan.request(task, variant, base if variant.goes_on else None)
            if request.step is not None:
                assert request.stride >= 1
            request.to_json()
