"""REBOUND's hard spheres by steps that samples leave alone, and as REBOUND is shipped, where they
do not.
"""

import re

import numpy as np
import pytest
import rebound

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.rebound.fields import fields_of
from refdem.engines.rebound.run import UNCUT
from refdem.engines.rebound.simulation import simulation_of

ENGINE = discovery.engine("rebound")
CRADLE = discovery.case("newtons-cradle").at(samples="16")


def run_at(method: str, times, step: float | None):
    """The trajectory of the cradle at these times."""
    problem = Motion(CRADLE.scene, np.asarray(times))
    trajectory, _ = ENGINE.run(Request(problem=problem, method=method, step=step))
    return trajectory


def times_of(samples: int, duration: float = 1.25):
    return np.arange(samples + 1) * (duration / samples)


@pytest.mark.parametrize("backward", [False, True])
def test_samples_leave_uncut_steps_as_they_are(backward):
    times = times_of(20)
    if backward:
        times = -times
    step = 2.0**-6 * 1.25
    few = run_at("leapfrog-uncut", times[::5], step)
    many = run_at("leapfrog-uncut", times, step)
    for name, values in few.columns().items():
        assert np.array_equal(values, many.columns()[name][::5])


def test_uncut_steps_end_at_no_sample():
    """The golden section: multiples of it stay apart from whole numbers by more than 1/(3 n)."""
    for n in range(1, 10_000):
        past = UNCUT * n
        assert abs(past - round(past)) > 1 / (3 * n)


@pytest.mark.parametrize("method", ["leapfrog-uncut", "leapfrog"])
def test_an_impact_is_seen_at_the_end_of_the_step_in_which_it_comes(method):
    """The first impact comes at 1/4 s: ball 2 has moved by v times what is left after that step."""
    interval = 0.3
    step = interval / 8
    own_step = step
    if method == "leapfrog-uncut":
        own_step = UNCUT * step
    run = run_at(method, [0.0, interval], step)
    seen_at = own_step * np.ceil(0.25 / own_step)
    start = CRADLE.scene.bodies.position[1, 0]
    assert run.position[-1, 1, 0] - start == pytest.approx(interval - seen_at, abs=1e-14)


def test_as_shipped_nothing_but_the_scene_is_set():
    comes_with = rebound.Simulation()
    request = Request(problem=CRADLE.problem, method="ias15-as-shipped", step=None)
    sim, _ = simulation_of(request, fields_of(CRADLE.scene))
    settings = [re.sub("at 0x[0-9a-f]+", "", repr(s.integrator)) for s in (sim, comes_with)]
    assert settings[0] == settings[1]
    assert sim.dt == comes_with.dt
    assert sim.exact_finish_time == comes_with.exact_finish_time
    assert (sim.gravity, sim.collision) == ("none", "direct")


def test_as_shipped_samples_decide_where_an_impact_is_seen():
    """Before it nothing acts: the step grows fourfold until a sample cuts it."""
    times = times_of(20)
    few = run_at("ias15-as-shipped", times[::5], None)
    many = run_at("ias15-as-shipped", times, None)
    assert np.abs(few.position - many.position[::5]).max() > 1e-3


@pytest.mark.parametrize("element", ["harmonic-oscillator", "pendulum"])
def test_as_shipped_springs_and_rods_are_refused_with_the_reason(element):
    instance = discovery.case(element).at()
    reason = ENGINE.unsupported(instance.problem, ENGINE.method("ias15-as-shipped"))
    assert reason is not None
    assert "prs23" in reason


def test_uncut_steps_are_for_hard_spheres():
    instance = discovery.case("harmonic-oscillator").at()
    assert ENGINE.unsupported(instance.problem, ENGINE.method("leapfrog-uncut")) is not None
