"""A break of billiards: names, scene, clock, what is refused, and which methods answer."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.truth.closed_forms.billiard_break import course_of

CASE = discovery.case("billiard-break")
SMALL = {"rows": "2"}


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = (
        "rows masses radii inertia_factor gap distance offset velocity spin restitution"
        " tangential_restitution friction impacts"
    )
    assert [p.name for p in CASE.parameters] == names.split()
    told = ["r{}.x", "r{}.y", "v{}.x", "v{}.y"]
    expected = [name.format(k) for k in range(4) for name in told]
    assert list(CASE.at(**SMALL).quantities) == expected
    told.append("omega{}.z")
    expected = [name.format(k) for k in range(4) for name in told]
    assert list(CASE.at(**SMALL, friction="1/8").quantities) == expected


@pytest.mark.parametrize("rows", range(2, 6))
def test_the_rack_is_a_triangle_of_balls_that_do_not_touch(rows: int) -> None:
    bodies = CASE.at(rows=str(rows), gap="1/4", radii="3/4,1/2").scene.bodies
    count = rows * (rows + 1) // 2
    assert len(bodies) == 1 + count
    assert bodies.radius.tolist() == [0.75] + [0.5] * count
    rack = bodies.position[1:]
    apart = [float(np.linalg.norm(a - b)) - 1.0 for a, b in combinations(rack, 2)]
    assert min(apart) == pytest.approx(0.25)
    # Neighbours in a row, and those of the rows before and behind, which are 0.8 % farther apart.
    near = [gap for gap in apart if gap < 0.27]
    assert len(near) == 3 * rows * (rows - 1) // 2
    assert rack.mean(axis=0)[1] == pytest.approx(0.0)


def test_places_are_the_same_numbers_for_engines_and_truth() -> None:
    """With dyadic parameters nothing is rounded: an error of the start would grow."""
    instance = CASE.at()
    started = instance.truth().at(Fraction(0))
    for k, place in enumerate(instance.scene.bodies.position):
        assert [float(started[f"r{k}.{axis}"].mid) for axis in "xy"] == place[:2].tolist()
        assert float(started[f"r{k}.x"].mid) == started[f"r{k}.x"].mid


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"offset": "0"}, "along the rack's axis of symmetry"),
        ({"offset": "3", "rows": "2"}, "passes the rack"),
        ({"velocity": "-1,0"}, "passes the rack"),
        ({"velocity": "0,0"}, "passes the rack"),
        ({"distance": "1/2"}, "touches or overlaps the rack"),
        ({"distance": "-3", "offset": "1/2"}, "touches or overlaps the rack"),
        ({"velocity": "1,1/2", "offset": "-1/2"}, "no ball tells which is the first"),
        ({"restitution": "0"}, "restitution"),
        ({"restitution": "1/20"}, "restitution: .*take others"),
        ({"gap": "0"}, "gap"),
        ({"rows": "6"}, "rows"),
        ({"rows": "1"}, "rows"),
    ],
)
def test_what_has_no_order_or_no_end_is_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        CASE.at(**given)


@pytest.mark.parametrize("impacts", ["1", "3", "10", "16", "1000"])
def test_the_run_ends_after_so_many_impacts(impacts: str) -> None:
    instance = CASE.at(impacts=impacts)
    times = np.array(course_of(instance.p).times)
    assert np.count_nonzero(times < instance.times[-1]) == min(int(impacts), len(times))


@pytest.mark.parametrize("samples", [16, 64, 100])
@pytest.mark.parametrize("given", [{}, {"rows": "3", "restitution": "3/4"}])
def test_no_impact_of_the_run_is_at_a_sample(samples: int, given: dict[str, str]) -> None:
    instance = CASE.at(samples=str(samples), **given)
    times = np.array(course_of(instance.p).times)
    times = times[times < instance.times[-1]]
    for stride in (1, 2, 4):
        past = np.modf(times * stride / instance.times[1])[0]
        assert np.all(past > 1e-4)
        assert np.all(past < 1 - 1e-4)


def test_the_reference_answers_it() -> None:
    problem = CASE.at(**SMALL).problem
    assert [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None] == ["impacts"]
