"""A bouncing ball: names, scene, clock, and which methods answer."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.uniform_gravity import UniformGravity

CASE = discovery.case("bouncing-ball")


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = "mass radius inertia_factor height velocity spin gravity restitution"
    more = "tangential_restitution friction bounces"
    assert [p.name for p in CASE.parameters] == [*names.split(), *more.split()]
    assert list(CASE.at().quantities) == ["x", "y", "vx", "vy", "omega"]


def test_the_ball_starts_at_its_height_over_the_plane() -> None:
    scene = CASE.at(radius="1/4", height="3", velocity="2,-1", spin="5").scene
    assert scene.bodies.position[0].tolist() == [0.0, 3.25, 0.0]
    assert scene.bodies.velocity[0].tolist() == [2.0, -1.0, 0.0]
    assert scene.bodies.omega[0].tolist() == [0.0, 0.0, 5.0]
    assert scene.all(UniformGravity)[0].g == (0.0, -9.8125, 0.0)


@pytest.mark.parametrize("bounces", [1, 2, 7, 20])
@pytest.mark.parametrize("velocity", ["0,0", "1,3", "-2,-5"])
def test_the_run_ends_in_the_flight_after_its_last_bounce(bounces: int, velocity: str) -> None:
    from refdem.truth.closed_forms.bouncing_ball import times_of_bounces

    instance = CASE.at(bounces=str(bounces), velocity=velocity)
    times = times_of_bounces(instance.p, bounces + 1)
    last = Fraction(float(instance.times[-1]))
    assert (times[bounces - 1] - last).sign() < 0
    assert (times[bounces] - last).sign() > 0
    assert instance.truth().scalars()["bounces"].mid == bounces
    exact = np.array([float(time.ball()) for time in times[:bounces]])
    for stride in (1, 2, 4, 8):
        past = np.modf(exact / (instance.times[1] / stride))[0]
        assert np.all(past > 1e-4)
        assert np.all(past < 1 - 1e-4)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"duration": "30"}, "come to an end"),
        ({"restitution": "1", "duration": "400"}, "more than 40"),
        ({"restitution": "0"}, "restitution"),
        ({"height": "0"}, "height"),
        ({"bounces": "41"}, "bounces"),
    ],
)
def test_runs_that_do_not_end_before_the_bounces_are_refused(
    given: dict[str, str], words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        CASE.at(**given)


def test_the_end_of_bounces_is_decided_exactly() -> None:
    """From 2 m at g = 1: v_1 = 2 m/s, t_1 = 2 s, T = 2 + 4 (1/2)/(1/2) = 6 s at e = 1/2."""
    from refdem.truth.closed_forms.bouncing_ball import is_before_accumulation

    p = CASE.at(gravity="1", restitution="1/2").p
    assert not is_before_accumulation(p, Fraction(6))
    assert is_before_accumulation(p, Fraction(6) - Fraction(1, 10**60))


def test_the_reference_answers_it() -> None:
    problem = CASE.at(friction="1/4", velocity="1,2").problem
    assert [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None] == ["impacts"]


@pytest.mark.parametrize("height", ["1e-2", "1e-4", "1e-6"])
def test_a_large_ball_that_bounces_by_a_little_alarms_no_right_program(height: str) -> None:
    """Its place is rounded as its radius is, which is far above round-off of the height."""
    instance = CASE.at(height=height, radius="1/2")
    record = record_of(task_of(ENGINE, "impacts", instance, truth_of(instance), 1))
    outcomes = {f.outcome for f in record.findings}
    assert outcomes <= {"pass", "undecided"}
    assert sum(f.outcome == "pass" for f in record.findings) > 5
