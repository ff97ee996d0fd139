"""The examples of CONTRIBUTING.md work as they stand: case, engine and check together make findings
that hold.
"""

import re
import textwrap
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from refdem.core.check import CompletedRun, Subject
from refdem.core.judgement import errors
from refdem.core.problem import Request
from refdem.core.refinement import bound
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.variant import Variant
from refdem.faults.catalogue import faults
from refdem.faults.settings import SETTINGS
from refdem.scene import Body, Scene
from refdem.truth.sampled import sampled

TEXT = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text()
COLUMNS = 100
"""Of a line of code, as pyproject.toml sets them for ruff."""


@pytest.fixture(scope="module")
def shown() -> dict[str, Any]:
    """CASE, CHECK and ENGINE of the three code blocks."""
    names: dict[str, Any] = {"__name__": "shown"}
    for block in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        exec(compile(block, "CONTRIBUTING.md", "exec"), names)
    return names


def test_the_engine_shown_has_the_order_that_it_claims_on_the_case_shown(
    shown: dict[str, Any],
) -> None:
    instance = shown["CASE"].at()
    engine = shown["ENGINE"]
    (method,) = engine.methods
    assert engine.unsupported_motion(instance.problem, method) is None
    truth = sampled(instance.truth(), instance.times.tolist())
    seen = []
    for level in (float(instance.times[1]) / 2, float(instance.times[1]) / 4):
        run, _ = engine.run(Request(problem=instance.problem, method=method.name, step=level))
        found = errors(instance, run, truth)
        assert np.all(found["y"] <= bound(instance, method, level, truth))
        seen.append(found["y"].max())
    assert 1.9 < seen[0] / seen[1] < 2.1


def test_the_check_shown_kills_the_fault_that_it_names(shown: dict[str, Any]) -> None:
    case = shown["CASE"]
    check = shown["CHECK"]
    (method,) = shown["ENGINE"].methods
    instance = case.at()
    subject = Subject(instance, method, (float(instance.times[1]),), None)
    assert check.applies(subject) is not None
    object.__setattr__(instance, "scene", Scene.of([Body(mass=1.0, velocity=(0.0, 4.0, 0.0))]))
    assert check.applies(subject) is None
    t = instance.times
    place = np.zeros((len(t), 1, 3))
    place[:, 0, 1] = 4.0 * t
    velocity = np.broadcast_to(np.array([0.0, 4.0, 0.0]), place.shape).copy()
    for shift, outcome in ((0.0, "pass"), (1e-9, "fail")):
        moved = place + shift * (t > 0.5)[:, None, None]
        runs = {
            Variant(subject.levels[0]): CompletedRun(
                Trajectory.of_points(t, moved, velocity), Cost(seconds=0.0)
            )
        }
        (finding,) = check.judge(subject, runs)
        assert finding.outcome == outcome, finding.sentence


def test_the_engine_shown_refuses_by_naming_what_it_lacks(shown: dict[str, Any]) -> None:
    from refdem.core.discovery import case

    engine = shown["ENGINE"]
    assert "spring" in engine.unsupported_motion(
        case("harmonic-oscillator").at().problem, engine.methods[0]
    )


def test_no_line_is_longer_than_one_of_code() -> None:
    assert not [line for line in TEXT.splitlines() if len(line) > COLUMNS]


def test_the_recipe_of_a_fault_is_a_fault_of_the_file_that_it_names() -> None:
    """Its entry is read as that file would read it, and has its name and its settings."""
    (entry,) = re.findall(r"```text\n(   drag\(.*?)   ```", TEXT, re.DOTALL)
    names = dict(vars(import_module("refdem.faults.catalogue.drag")))
    exec(f"entries = ({textwrap.dedent(entry)})", names)
    (fault,) = names["entries"]
    assert fault.sees == ("error", "v")
    assert set(fault.on) <= set(SETTINGS)
    assert fault.name not in {known.name for known in faults()}
