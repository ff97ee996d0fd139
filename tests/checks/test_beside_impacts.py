"""An impact that is seen at the start of the step after it is an error of first order, no defect;
what is seen later still, or gives other velocities, is one.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from refdem.checks._beside_impacts import _met_again
from refdem.checks._crossings import Crossing
from refdem.core import discovery
from refdem.planning.in_process import record_of, task_of, truth_of
from tests.checks.a_step_late import StepLate

RESTITUTIONS = ("0", "1/2", "1")
VELOCITIES = ("3/4,-1,0", "0,-5,0", "1/8,-1/16,1/3")
SAMPLES = ("16", "63", "64")
WALLS = [
    {"restitution": e, "velocity": v, "samples": count, "friction": "0"}
    for e, v, count in product(RESTITUTIONS, VELOCITIES, SAMPLES)
]


def failures(engine, case, **given):
    """The checks and quantities that fail, in all checks that apply."""
    instance = discovery.case(case).at(**given)
    task = task_of(engine, "semi-implicit-euler", instance, truth_of(instance), 4)
    assert task.unsupported is None
    found = record_of(task).findings
    assert any(f.outcome == "pass" for f in found)
    return {(f.check, f.quantity): f.sentence for f in found if f.outcome in ("fail", "error")}


@pytest.mark.parametrize("given", WALLS, ids=lambda given: " ".join(given.values()))
def test_a_wall_seen_one_step_late_passes_at_any_restitution_speed_and_step(given):
    assert failures(StepLate(), "hard-wall", **given) == {}


@pytest.mark.parametrize("case", ["hard-spheres", "bouncing-ball", "newtons-cradle"])
def test_spheres_that_meet_one_step_late_pass(case):
    given = {"friction": "0"} if case == "hard-spheres" else {}
    assert failures(StepLate(), case, **given) == {}


@pytest.mark.parametrize(
    ("others", "hidden"),
    [
        ([], ()),
        ([(1.25, (2, 5))], (2,)),
        ([(1.25, (3, 2)), (1.9, (5, 3))], (2, 3)),
        ([(1.25, (4, 5))], ()),
        ([(0.75, (2, 3)), (2.25, (2, 3))], ()),
    ],
)
def test_a_body_that_meets_again_between_two_samples_has_a_velocity_that_none_shows(others, hidden):
    """Bodies 2 and 3 meet at t = 1.5, between samples at 1 and 2."""
    told = [Crossing(time, 0.0, 1.0, 0.0, 1.0, bodies) for time, bodies in [(1.5, (2, 3)), *others]]
    assert _met_again(told[0], told, np.arange(4.0), 2) == hidden


def claiming(**claims):
    """The same engine with other claims."""
    engine = StepLate()
    engine.methods = tuple(replace(method, **claims) for method in engine.methods)
    return engine


def changed(**attributes):
    """A wrong version of the engine."""
    engine = StepLate()
    for name, value in attributes.items():
        setattr(engine, name, value)
    return engine


@pytest.mark.parametrize("restitution", RESTITUTIONS)
def test_a_wall_seen_one_step_late_fails_where_impacts_are_claimed_to_be_located(restitution):
    located = claiming(locates_events=True)
    second_order = claiming(order=2)
    for engine in (located, second_order):
        assert ("error", "v.y") in failures(
            engine, "hard-wall", restitution=restitution, friction="0"
        )


@pytest.mark.parametrize("restitution", RESTITUTIONS)
@pytest.mark.parametrize("velocity", VELOCITIES[:2])
def test_a_wall_seen_two_steps_late_fails(restitution, velocity):
    """Where samples are as close as steps, for the velocity of before is seen too late there."""
    engine = changed(steps_late=1)
    given = {"restitution": restitution, "velocity": velocity, "friction": "0", "samples": "1024"}
    assert ("error", "v.y") in failures(engine, "hard-wall", **given)


@pytest.mark.parametrize("restitution", ["1/2", "1"])
def test_a_wrong_restitution_fails_though_it_is_seen_late(restitution):
    engine = changed(restitution_factor=0.75)
    found = failures(engine, "hard-wall", restitution=restitution, friction="0")
    assert {("error", "v.y"), ("rigid-impact", "restitution")} <= set(found)


def test_a_velocity_that_is_neither_that_of_before_nor_that_of_after_fails():
    """At the first sample after the impact, at the coarsest step alone."""

    class Halfway(StepLate):
        def run(self, request):
            run, cost = super().run(request)
            velocity = run.velocity.copy()
            turned = int(np.argmax(velocity[:, 0, 1] > 0))
            velocity[turned - 1, 0, 1] *= 0.5
            return replace(run, velocity=velocity), cost

    assert ("error", "v.y") in failures(Halfway(), "hard-wall", restitution="1", friction="0")


@pytest.mark.parametrize("reported_after", [0, 1])
@pytest.mark.parametrize("case", ["hard-wall", "hard-spheres"])
def test_an_impact_may_be_told_when_it_is_seen_or_at_the_end_of_the_step_that_acts(
    case, reported_after
):
    engine = changed(reported_after=reported_after)
    assert failures(engine, case, friction="0") == {}


@pytest.mark.parametrize("reported_after", [-40, 40])
def test_an_impact_that_is_told_much_earlier_or_later_fails(reported_after):
    found = failures(changed(reported_after=reported_after), "hard-wall", friction="0")
    assert ("event-times", "contact") in found
