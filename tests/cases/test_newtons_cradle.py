"""Newton's cradle: names, scene, clock, and which methods answer."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError

CASE = discovery.case("newtons-cradle")


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = "balls masses radii gaps velocities restitution"
    assert [p.name for p in CASE.parameters] == names.split()
    expected = [f"{kind}{k}.x" for k in (1, 2, 3) for kind in "rv"]
    assert list(CASE.at(balls="3").quantities) == expected


def test_the_scene_has_gaps_between_surfaces() -> None:
    bodies = CASE.at(balls="3", radii="1/2,1/4,1,1,1,1,1", gaps="1/8,3/8,1,1,1,1").scene.bodies
    assert bodies.position[:, 0] == pytest.approx(np.array([0.0, 0.875, 2.5]))
    assert not bodies.position[:, 1:].any()
    surfaces = np.diff(bodies.position[:, 0]) - bodies.radius[1:] - bodies.radius[:-1]
    assert surfaces == pytest.approx(np.array([0.125, 0.375]))


def test_no_ball_passes_a_smaller_neighbour_within_tau() -> None:
    """The balls reach over 1/2 + 1/4 and 1/4 + 10; the fastest is the first, at 1 m/s."""
    case = CASE.at(balls="3", radii="1/2,1/4,10,1,1,1,1", gaps="8,8,1,1,1,1")
    assert case.scales.tau == 0.75


def test_numbers_of_balls_that_are_not_there_do_not_count() -> None:
    one = CASE.at(balls="3", masses="1,2,3,4,5,6,7", velocities="1,0,0,9,9,9,9")
    other = CASE.at(balls="3", masses="1,2,3,1,1,1,1", velocities="1,0,0,0,0,0,0")
    assert one.scene.to_json() == other.scene.to_json()
    assert one.truth().scalars() == other.truth().scalars()
    assert one.scales == other.scales


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"velocities": "0,0,0,0,0,0,0"}, "no two balls ever meet"),
        ({"velocities": "-1,0,0,0,0,0,0"}, "no two balls ever meet"),
        ({"gaps": "0,1,1,1,1,1"}, "gaps"),
        ({"velocities": "1,0,0,0,-1,0,0"}, "meets two others at one time"),
        ({"restitution": "0"}, "still touches another"),
        ({"restitution": "1/50", "balls": "3"}, "without end in finite time"),
        ({"restitution": "9/8"}, "restitution"),
        ({"balls": "8"}, "balls"),
        ({"balls": "1"}, "balls"),
    ],
)
def test_what_has_no_order_or_no_end_is_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        CASE.at(**given)


def test_a_ball_that_two_hit_at_almost_one_time_is_not_refused() -> None:
    gaps = f"1/4,1/4,1/4,{Fraction(1, 4) + Fraction(1, 10**9)},1,1"
    scalars = CASE.at(gaps=gaps, velocities="1,0,0,0,-1,0,0").truth().scalars()
    assert scalars["impacts"].mid >= 4


@pytest.mark.parametrize("samples", [8, 16, 64, 100, 513])
@pytest.mark.parametrize("given", [{}, {"restitution": "3/4", "balls": "3"}])
def test_no_impact_is_at_a_sample_or_at_the_end_of_a_step(
    samples: int, given: dict[str, str]
) -> None:
    from refdem.truth.closed_forms.newtons_cradle import course_of

    instance = CASE.at(samples=str(samples), **given)
    times = [float(time) for time in course_of(instance.p).times]
    assert instance.times[-1] > times[-1]
    for stride in (1, 2, 4, 8):
        step = instance.times[1] / stride
        past = np.modf(np.array(times) / step)[0]
        assert np.all(past > 1e-3)
        assert np.all(past < 1 - 1e-3)


def test_the_reference_answers_it() -> None:
    problem = CASE.at().problem
    assert [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None] == ["impacts"]
