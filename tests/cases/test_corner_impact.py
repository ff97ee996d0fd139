"""A corner of a box on a plane: names, what it refuses, the impact by rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.cases.corner_impact import Meeting
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.planning.in_process import record_of, task_of, truth_of

CASE = discovery.case("corner-impact")


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = "mass sides angle height velocity restitution"
    assert [p.name for p in CASE.parameters] == names.split()
    assert list(CASE.at().quantities) == ["x", "y", "vx", "vy", "theta", "omega"]


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"velocity": "1,0"}, "comes down"),
        ({"height": "1/2"}, "above the plane"),
        ({"restitution": "0"}, "restitution"),
        ({"angle": "1.6"}, "angle"),
        ({"angle": "1/64"}, "see one corner"),
        ({"sides": "8,1/64", "angle": "3/2", "height": "18"}, "see one corner"),
        ({"angle": "1/16", "duration": "3"}, "second corner"),
        ({"duration": "40", "samples": "8"}, "turns by at most"),
    ],
)
def test_what_is_no_single_impact_of_a_corner_is_refused(given: dict[str, str], word: str) -> None:
    with pytest.raises(UsageError, match=word):
        CASE.at(**given)


def test_pymunk_is_right_about_a_corner_that_leaves_slowly_in_other_units() -> None:
    """Chipmunk parts what overlaps by a tenth in 1/60 s, in whatever unit of time."""
    instance = CASE.at(
        mass="76.3",
        sides="2.2,0.975",
        angle="0.95",
        height="4.25",
        velocity="-2.79,-6.88",
        restitution="0.01",
        samples="33",
    )
    truth = truth_of(instance)
    task = task_of(discovery.engine("pymunk"), "semi-implicit-euler", instance, truth, 4)
    found = {(one.check, one.quantity): one for one in record_of(task).findings}
    assert [one.sentence for one in found.values() if one.outcome == "fail"] == []
    assert found["symmetry", "rescaled"].outcome == "pass"


def test_the_reference_answers_it() -> None:
    problem = CASE.at().problem
    methods = [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None]
    assert methods == ["exact-corner-impact"]


@pytest.mark.parametrize("sides", ["1,1/2", "1,1", "1/2,2"])
@pytest.mark.parametrize("angle", ["1/8", "1/2", "1.4"])
@pytest.mark.parametrize("restitution", ["1/8", "1"])
def test_no_corner_is_in_the_plane_while_a_run_lasts(sides, angle, restitution) -> None:
    instance = CASE.at(sides=sides, angle=angle, restitution=restitution)
    method = ENGINE.best(instance.problem).name
    run, _ = ENGINE.run(Request(problem=instance.problem, method=method))
    seen = instance.observe(run)
    x, y = np.array([[i, j] for i in (-1, 1) for j in (-1, 1)]).T * instance.p.sides[:, None] / 2
    sine = np.sin(seen["theta"])[:, None]
    cosine = np.cos(seen["theta"])[:, None]
    heights = seen["y"][:, None] + x * sine + y * cosine
    assert heights.min() > -1e-12
    assert instance.times[-1] > Meeting(instance.p).time


def test_energy_is_lost_as_the_closed_form_says_and_not_at_all_by_an_elastic_corner() -> None:
    for restitution in ("1/2", "1"):
        instance = CASE.at(restitution=restitution)
        run, _ = ENGINE.run(Request(problem=instance.problem, method="exact-corner-impact"))
        seen = instance.observe(run)
        p = instance.p
        moment = p.mass * (p.sides @ p.sides) / 12
        kinetic = p.mass * (seen["vx"] ** 2 + seen["vy"] ** 2) + moment * seen["omega"] ** 2
        lost = (kinetic[0] - kinetic[-1]) / 2
        expected = float(instance.truth().scalars()["energy_lost"].mid)
        assert lost == pytest.approx(expected, abs=1e-14)
        assert (expected > 0) == (Fraction(restitution) < 1)
