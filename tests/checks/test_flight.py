"""Free flight under a rigid contact law: judged in methods that find every impact."""

import pytest

from refdem.core import discovery
from refdem.core.check import Subject
from refdem.engines.reference import ENGINE
from refdem.faults.catalogue import chosen
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.truth.sampled import sampled

CHECK = discovery.check("flight")
SCENES = [
    ("granular-gas", {"contact": "rigid", "n": "50", "duration": "4", "samples": "8"}),
    (
        "granular-gas",
        {"contact": "rigid", "n": "50", "friction": "1/5", "boundary": "walls", "duration": "4"},
    ),
]


def outcomes(engine, case, given):
    """What the check says of method `impacts` of an engine."""
    instance = discovery.case(case).at(**given)
    record = record_of(task_of(engine, "impacts", instance, truth_of(instance), 1))
    return [f.outcome for f in record.findings if f.check == "flight"]


@pytest.mark.parametrize(("case", "given"), SCENES)
def test_spheres_between_impacts_fly_straight(case, given):
    assert outcomes(ENGINE, case, given) == ["pass"]


@pytest.mark.parametrize(("case", "given"), SCENES)
def test_spheres_that_stand_still_with_a_velocity_are_seen(case, given):
    (frozen,) = chosen(["frozen"])
    assert outcomes(frozen.carrier(ENGINE), case, given) == ["fail"]


@pytest.mark.parametrize("gap", ["1/4", "1/1000"])
def test_a_ball_of_a_cradle_that_hands_on_what_it_got_is_not_judged(gap):
    """Between two samples it is hit and hits, and stands still again at another place."""
    gaps = f"1/4,{gap},1/4,1/4,1/4,1/4"
    assert outcomes(ENGINE, "newtons-cradle", {"balls": "3", "gaps": gaps, "samples": "32"}) == []


def test_engines_that_push_overlapping_bodies_apart_are_not_held_to_it():
    instance = discovery.case("hard-spheres").at()
    engine = discovery.engine("pymunk")
    truth = sampled(instance.truth(), instance.times.tolist())
    subject = Subject(instance, engine.method("semi-implicit-euler"), (0.01,), truth)
    assert "pushed apart" in CHECK.applies(subject)
