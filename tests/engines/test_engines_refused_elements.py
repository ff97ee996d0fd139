"""Elements that no adapter carries are refused with a reason, never run as something else."""

import pytest

from refdem.core import discovery


@pytest.mark.parametrize(
    ("engine", "case"),
    [
        ("mujoco", "hertz-spheres"),
        ("mujoco", "wedge-collision"),
        ("pymunk", "kapitza-pendulum"),
        ("pymunk", "wedge-collision"),
        ("rebound", "wedge-collision"),
        ("rebound", "stick-slip"),
    ],
)
def test_an_adapter_refuses_what_it_does_not_carry(engine: str, case: str) -> None:
    adapter = discovery.engine(engine)
    problem = discovery.case(case).at().problem
    reasons = [adapter.unsupported(problem, method) for method in adapter.methods]
    assert all(reasons)
