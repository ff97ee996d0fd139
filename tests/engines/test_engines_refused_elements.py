"""Elements that no adapter carries are refused with a reason, never run as something else."""

import pytest

from refdem.core import discovery


@pytest.mark.parametrize("engine", ["mujoco", "pymunk", "rebound"])
@pytest.mark.parametrize("case", ["hertz-spheres", "asymmetric-field", "wedge-collision"])
def test_an_adapter_refuses_what_it_does_not_carry(engine: str, case: str) -> None:
    adapter = discovery.engine(engine)
    problem = discovery.case(case).at().problem
    reasons = [adapter.unsupported(problem, method) for method in adapter.methods]
    assert all(reasons)
