"""How REBOUND's own errors and warnings become those of a run, and what a run counts."""

import warnings
from collections.abc import Callable

import numpy as np
import pytest
import rebound

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost
from refdem.engines.rebound import run as run_module
from refdem.engines.rebound.run import UNCUT
from refdem.errors import EngineError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact

ENGINE = discovery.engine("rebound")
BALLS = Scene.of(
    [
        Body(mass=1.0, position=(9.0 * n, 0.0, 0.0), shape=Sphere(radius=0.5), velocity=(n, 0, 0))
        for n in range(2)
    ],
    [Contact(law="rigid", restitution=0.5)],
)
STEP = 2.0**-4
REQUEST = Request(problem=Motion(BALLS, STEP * np.arange(9)), method="leapfrog", step=STEP)


def cost_of(method: str, samples: int) -> Cost:
    """What a run of four steps a sample costs."""
    problem = Motion(BALLS, 4 * STEP * np.arange(samples + 1))
    _, cost = ENGINE.run(Request(problem=problem, method=method, step=STEP))
    return cost


class Telling:
    """A simulation that has something to tell."""

    def __init__(self, tells: Callable[[], None]) -> None:
        self.process_messages = tells


def test_an_error_that_rebound_tells_is_an_error_of_the_run() -> None:
    def told() -> None:
        raise RuntimeError("it does not converge")

    with pytest.raises(EngineError, match=r"^rebound, leapfrog: it does not converge$"):
        run_module._refuse_failure(Telling(told), REQUEST, failed=0)


def test_a_warning_that_rebound_tells_is_none_of_the_run() -> None:
    def told() -> None:
        warnings.warn("steps are small", RuntimeWarning, stacklevel=1)

    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        run_module._refuse_failure(Telling(told), REQUEST, failed=0)
    assert heard == []


@pytest.mark.parametrize("method", ["leapfrog", "leapfrog-uncut"])
def test_every_run_is_asked_how_it_went(monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    """Uncut, also every copy that goes on to a sample."""
    asked: list[int] = []
    monkeypatch.setattr(
        run_module, "_refuse_failure", lambda sim, request, failed: asked.append(failed)
    )
    cost_of(method, 4)
    assert asked == [0] * (5 if method == "leapfrog-uncut" else 1)


@pytest.mark.parametrize("sample", [0, 1, 7])
def test_a_run_that_rebound_stops_says_before_which_sample(sample: int) -> None:
    """The compiled loop returns the number of the sample from 1 on, and 0 at the end."""
    sim = rebound.Simulation()
    sim.t = 0.25
    run_module._refuse_failure(sim, REQUEST, failed=0)
    words = rf"^rebound, leapfrog: stopped with status -?\d+ before sample {sample}, at t = 0.25 s$"
    with pytest.raises(EngineError, match=words):
        run_module._refuse_failure(sim, REQUEST, failed=sample + 1)


@pytest.mark.parametrize("samples", [1, 2, 9])
def test_the_steps_of_a_run_are_counted(samples: int) -> None:
    """Uncut steps are shorter, and every sample but the first has one of its own."""
    assert cost_of("leapfrog", samples).steps == 4 * samples
    assert cost_of("leapfrog-uncut", samples).steps == int(4 * samples / UNCUT) + samples
