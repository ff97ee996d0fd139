"""A block that a spring pulls over a floor is Coulomb's oscillator: engines that know contacts hold
it, a wrong coefficient shows, and one that would tip is refused.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.errors import UsageError
from refdem.planning.in_process import record_of, task_of, truth_of

CASE = discovery.case("coulomb-oscillator")
HELD = {"duration": "12", "samples": "24"}
ROUGH = {
    "mass": "1.074",
    "stiffness": "1.102",
    "x0": "1.586",
    "v0": "0.486",
    "gravity": "7.43",
    "friction_force": "0.4975",
}
LANDING = {
    "mass": "7.875",
    "stiffness": "1.402",
    "x0": "-0.64",
    "gravity": "4.642",
    "friction_force": "0.5287",
}
"""Shifted, its corners touch a step later in pymunk, as a rounding decides."""
STUCK = {
    "mass": "26.2",
    "stiffness": "3.34",
    "x0": "0.108",
    "gravity": "66.1",
    "friction_force": "2790",
}
"""The spring is weaker than friction; units decide which corners touch in pymunk."""
FAST = {"x0": "10", "gravity": "5", "friction_force": "1", "samples": "32"}
"""Contacts that are as hard as MuJoCo allows throw this block up."""


def findings(engine, method, **given):
    """The findings of an engine's method on the block, by check and quantity."""
    instance = CASE.at(member="block", **given)
    task = task_of(discovery.engine(engine), method, instance, truth_of(instance), 4)
    return {(f.check, f.quantity): f for f in record_of(task).findings}


def blamed(found):
    """The sentences of what fails."""
    return [f.sentence for f in found.values() if f.outcome in ("fail", "error")]


def test_its_truth_is_that_of_the_slider():
    slider = CASE.at().truth()
    block = CASE.at(member="block").truth()
    assert block.scalars() == slider.scalars()
    assert block.at(7) == slider.at(7)


@pytest.mark.parametrize("given", [HELD, ROUGH, {"x0": "0", "v0": "-1"}, {"x0": "0.1"}], ids=str)
def test_the_reference_holds_it_to_round_off(given):
    found = findings("reference", "exact-block", **given)
    assert blamed(found) == []
    assert found["error", "x"].outcome == found["stop", "creep"].outcome == "pass"


@pytest.mark.parametrize("given", [HELD, ROUGH, LANDING], ids=["default", "rough", "landing"])
def test_pymunk_holds_it(given):
    found = findings("pymunk", "semi-implicit-euler", **given)
    assert blamed(found) == []
    assert found["stop", "stop_time"].outcome == found["order", "state"].outcome == "pass"


def test_pymunk_holds_a_block_that_never_moves():
    assert blamed(findings("pymunk", "semi-implicit-euler", **STUCK)) == []


@pytest.mark.parametrize("given", [HELD, FAST], ids=["default", "fast"])
@pytest.mark.parametrize("method", ["euler", "rk4"])
def test_mujoco_holds_it(method, given):
    found = findings("mujoco", method, **given)
    assert blamed(found) == []
    assert found["stop", "stop_time"].outcome == found["order", "state"].outcome == "pass"


@pytest.mark.parametrize("engine", ["pymunk", "mujoco"])
def test_two_per_cent_more_friction_shows(engine):
    """The engine runs another coefficient than the one that truth knows."""
    methods = {"pymunk": "semi-implicit-euler", "mujoco": "euler"}
    right = CASE.at(member="block", **HELD)
    misread = CASE.at(member="block", friction_force="0.153", **HELD)
    task = task_of(discovery.engine(engine), methods[engine], misread, truth_of(right), 4)
    found = {(f.check, f.quantity): f for f in record_of(task).findings}
    assert found["error", "x"].outcome == "fail"


def test_it_lies_flat_and_rests_from_the_stop_on():
    problem = CASE.at(member="block", **HELD).problem
    request = Request(problem=problem, method="exact-block")
    seen, _ = discovery.engine("reference").run(request)
    assert [(event.kind, event.time) for event in seen.events] == [("stop", 3 * np.pi)]
    after = seen.t >= 3 * np.pi
    assert np.all(seen.velocity[after] == 0.0)
    assert np.ptp(seen.position[:, 0, 1]) == 0.0
    assert not np.any(seen.omega)


def test_a_block_that_would_tip_is_refused():
    """With f h = m g w, friction at the foot has the torque of the weight at the base's edge."""
    edge = 8 * 9.8125
    CASE.at(member="block", friction_force=f"{edge * 0.999}")
    with pytest.raises(UsageError, match="beyond which the block tips"):
        CASE.at(member="block", friction_force=f"{edge}")
    CASE.at(friction_force=f"{edge}")


def test_the_reference_says_which_blocks_it_cannot_pull():
    engine = discovery.engine("reference")
    method = engine.method("exact-block")
    problem = CASE.at(member="block").problem
    assert engine.unsupported_motion(problem, method) is None
    slider = CASE.at().problem
    assert "kind slider" in engine.unsupported_motion(slider, method)
    smooth = CASE.at(member="block", friction_force="0").problem
    assert "does not rub" in engine.unsupported_motion(smooth, method)
    backwards = Motion(problem.scene, -problem.times)
    assert "may have come from anywhere" in engine.unsupported_motion(backwards, method)
