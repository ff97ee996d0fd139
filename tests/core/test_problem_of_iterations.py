"""Questions without a scene: JSON both ways, samples, keys, answers by name, and engines that run
motions only.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.maps import Logistic, LogisticFlow, RectangleBilliard, StadiumBilliard
from refdem.core.problem import DENSE, PER_OCTAVE, Iteration, Motion, Request
from refdem.core.request_text import request_text
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError, UsageError
from refdem.scene import Body, Scene

TABLE = np.array([0.125, 0.25, 0.6, 0.8])
ITERATIONS = [
    Iteration(Logistic(eta=3.75), np.array([0.25]), 64),
    Iteration(LogisticFlow(eta=1.0), np.array([0.1]), 1),
    Iteration(RectangleBilliard(width=2.0, height=1.0), TABLE, 10**6),
    Iteration(StadiumBilliard(width=2.0, height=1.0), TABLE, 129),
]


@pytest.mark.parametrize("problem", ITERATIONS, ids=lambda p: p.map.kind)
def test_an_iteration_survives_json_to_the_last_bit(problem):
    request = Request(problem=problem, method="m")
    again = Request.from_json(request.to_json())
    assert again.key("e") == request.key("e")
    assert again.problem.map == problem.map
    assert np.array_equal(again.problem.start, problem.start)


def test_the_key_changes_with_map_parameter_start_and_n():
    x = np.array([0.25])
    problems = [
        Iteration(Logistic(eta=3.75), x, 64),
        Iteration(Logistic(eta=np.nextafter(3.75, 4)), x, 64),
        Iteration(LogisticFlow(eta=3.75), x, 64),
        Iteration(Logistic(eta=3.75), np.nextafter(x, 1), 64),
        Iteration(Logistic(eta=3.75), x, 65),
    ]
    assert len({Request(problem=p, method="m").key("e") for p in problems}) == len(problems)


def test_request_text_names_the_map():
    text = request_text(Request(problem=ITERATIONS[0], method="m"))
    assert {
        "problem.kind iteration",
        "problem.map.map logistic",
        "problem.map.eta 3.75",
        "problem.n 64",
    } <= set(text.splitlines())


@pytest.mark.parametrize("n", [1, 64, DENSE, DENSE + 1, 1000, 10**6])
def test_samples_are_whole_rise_and_end_at_n(n):
    times = Iteration(Logistic(eta=3.0), np.array([0.5]), n).times
    assert times[0] == 0
    assert times[-1] == n
    assert np.all(np.diff(times) > 0)
    assert np.array_equal(times, np.round(times))
    assert np.array_equal(times[: min(n, DENSE) + 1], np.arange(min(n, DENSE) + 1))
    assert len(times) <= DENSE + 2 + PER_OCTAVE * max(0.0, np.log2(n / DENSE))


@pytest.mark.parametrize("problem", ITERATIONS, ids=lambda p: p.map.kind)
def test_a_moved_start_is_another_start_that_the_map_takes(problem):
    moved = problem.perturbed(1)
    # sharp: a neighbour is at most 2^-52 of the number away, and the quotient is rounded once
    assert np.max(np.abs(moved.start / problem.start - 1)) <= 2.0**-51
    assert np.any(moved.start != problem.start)
    if len(moved.start) == 4:
        assert abs(np.hypot(*moved.start[2:]) - 1) <= 2.0**-52
    assert Iteration(Logistic(eta=4.0), np.array([1.0]), 3).perturbed(8).start == 1.0


def test_what_makes_no_iteration_is_refused():
    for given in [(np.array([0.5]), 0), (np.array([0.5, 0.5]), 3), (np.array([np.nan]), 3)]:
        with pytest.raises(UsageError, match="n >= 1"):
            Iteration(Logistic(eta=3.0), *given)
    with pytest.raises(UsageError, match="width"):
        StadiumBilliard(width=1.0, height=2.0)
    with pytest.raises(UsageError, match="sizes"):
        RectangleBilliard(width=0.0, height=2.0)
    with pytest.raises(UsageError, match="request"):
        Request.from_json(
            b'{"method": "m", "problem": {"kind": "iteration", "map": {"map": "henon"}, "start":'
            b' [0.5], "n": 3}}'
        )


def test_an_iteration_has_no_scene():
    with pytest.raises(UsageError, match="an iteration has no scene"):
        _ = ITERATIONS[0].scene


@pytest.mark.parametrize("name", [n for n in discovery.names("engines") if n != "reference"])
def test_engines_cannot_run_an_iteration_and_say_so(name):
    engine = discovery.engine(name)
    assert {engine.unsupported(ITERATIONS[0], method) for method in engine.methods} == {
        "cannot run an iteration"
    }


def test_methods_of_the_reference_for_motions_cannot_run_an_iteration():
    engine = discovery.engine("reference")
    stepped = [method for method in engine.methods if method.control == "step"]
    assert {engine.unsupported(ITERATIONS[0], method) for method in stepped} == {
        "cannot run an iteration"
    }
    still = Motion(Scene.of([Body(mass=1.0)]), np.arange(3.0))
    assert engine.unsupported(still, engine.best(still)) is None


def test_an_answer_has_values_by_name_and_survives_bytes():
    answer = Trajectory.of_values(
        np.arange(3.0), {"x": np.array([0.5, 1 / 3, 0.1]), "r": np.arange(6.0).reshape(3, 2)}
    )
    again = Trajectory.from_bytes(answer.to_bytes())
    assert {name: values.tolist() for name, values in again.values.items()} == {
        "x": [0.5, 1 / 3, 0.1],
        "r": [[0, 1], [2, 3], [4, 5]],
    }
    assert again.position.shape == (3, 0, 3)


@pytest.mark.parametrize("bad", [np.array([0.5, np.nan, 0.1]), np.array([0.5, 0.1])])
def test_values_that_are_short_or_not_finite_are_the_engines_fault(bad):
    with pytest.raises(EngineError, match=r"values\[x\]"):
        Trajectory.of_values(np.arange(3.0), {"x": bad})
