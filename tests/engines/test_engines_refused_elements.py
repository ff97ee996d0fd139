"""Elements that no adapter carries are refused with a reason, never run as something else."""

import tomllib
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.refusal import ADAPTER_LACKS, ENGINE_CANNOT

CAMPAIGNS = Path(__file__).parents[2] / "validation" / "campaigns"


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


def refusals(engine: str) -> dict[str, str]:
    """By case and method: why the adapter refuses a motion of campaign main."""
    adapter = discovery.engine(engine)
    moving = [method for method in adapter.methods if method.answers == "motion"]
    rows = tomllib.loads((CAMPAIGNS / "main.toml").read_text())["case"]
    found = {}
    for row in rows:
        instance = discovery.case(row["id"]).at(**row.get("set", {}))
        if instance.problem.kind != "motion":
            continue
        for method in moving:
            reason = adapter.unsupported(instance.problem, method)
            if reason is not None:
                found[f"{instance.label}/{method.name}"] = reason
    return found


@pytest.mark.parametrize("engine", ["mujoco", "pymunk", "rebound"])
def test_a_refusal_says_whether_the_engine_or_its_adapter_lacks_the_feature(engine: str) -> None:
    reasons = refusals(engine)
    assert len(reasons) >= 10
    for where, reason in reasons.items():
        feature = reason.removeprefix(ENGINE_CANNOT).removeprefix(ADAPTER_LACKS)
        assert feature, where
        assert reason.startswith((ENGINE_CANNOT, ADAPTER_LACKS)), f"{where}: {reason}"
