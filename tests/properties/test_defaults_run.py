"""`refdem run CASE` is what a newcomer types first: no case is refused for its defaults alone."""

import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.core.selection import Selection
from refdem.engines.reference import ENGINE

MOTIONS = [
    name
    for name in discovery.names("cases")
    if not isinstance(discovery.case(name), Selection)
    and isinstance(discovery.case(name).at().problem, Motion)
]
BY_STEPS = 4
"""Steps from one sample to the next, of a method that takes steps."""


@pytest.mark.parametrize("case", MOTIONS)
def test_every_motion_runs_at_its_defaults_in_the_reference(case: str) -> None:
    problem = discovery.case(case).at().problem
    method = ENGINE.best(problem)
    assert ENGINE.unsupported(problem, method) is None
    if method.control == "step":
        request = Request(
            problem=problem, method=method.name, step=float(problem.interval) / BY_STEPS
        )
    else:
        request = Request(problem=problem, method=method.name)
    run, _ = ENGINE.run(request)
    assert len(run.t) == len(problem.times)


@pytest.mark.parametrize("name", ["mujoco", "pymunk", "rebound", "reference"])
def test_every_engine_runs_two_spheres_at_their_defaults(name: str) -> None:
    engine = discovery.engine(name)
    problem = discovery.case("two-spheres").at().problem
    refused = {method.name: engine.unsupported(problem, method) for method in engine.methods}
    assert None in refused.values(), refused
