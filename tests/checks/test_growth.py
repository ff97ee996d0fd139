"""The growth rate of a whirl: held by the true motion at any start, failed by one that settles
where it should grow, and by one that grows where it should settle.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.growth import roots
from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.element import Element
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.truth.sampled import sampled
from tests.handmade import instance

CHECK = discovery.check("growth")
SPRING = Spring(a=0, stiffness=8.0)
FLUID = RotatingDashpot(a=0, damping=1.0, rate=(0.0, 0.0, 5.0))


def subject_of(**given: str) -> Subject:
    shaft = discovery.case("whirling-shaft").at(**given)
    truth = sampled(shaft.truth(), shaft.times.tolist())
    return Subject(shaft, ENGINE.method("exact-whirl"), (0.0,), truth)


def motion_of(subject: Subject) -> Trajectory:
    run, _ = ENGINE.run(Request(problem=subject.instance.problem, method="exact-whirl"))
    return run


def finding(subject: Subject, run: Trajectory) -> Finding:
    assert CHECK.applies(subject) is None
    (found,) = CHECK.judge(subject, {Variant(0.0): CompletedRun(run, Cost(seconds=0.0))})
    return found


@pytest.mark.parametrize("turning", ["5", "2", "3", "-5", "0", "1000"])
@pytest.mark.parametrize("start", [{}, {"x0": "0,0", "v0": "-2,1"}, {"x0": "-3,2", "v0": "0,0"}])
def test_the_true_motion_has_the_rate_of_the_roots(turning: str, start: dict[str, str]) -> None:
    subject = subject_of(turning=turning, **start)
    found = finding(subject, motion_of(subject))
    assert found.outcome == "pass"
    assert found.bound < 1e-13 * max(1.0, abs(float(turning)) / 50)


def test_the_rate_is_the_scalar_of_truth() -> None:
    for turning in ("5", "2", "3"):
        subject = subject_of(turning=turning)
        first, _ = roots(subject.instance.scene)
        rate = subject.instance.truth().scalars()["growth_rate"]
        assert first.real == pytest.approx(float(rate.mid), abs=1e-15)


@pytest.mark.parametrize(
    ("turning", "rate"), [("5", -1e-6), ("3", -1e-9), ("3", 1e-9), ("2", 1e-6)]
)
def test_a_method_that_damps_or_pumps_by_itself_fails(turning: str, rate: float) -> None:
    """As the numerical damping of a step does: all of the state times exp(rate t)."""
    subject = subject_of(turning=turning)
    run = motion_of(subject)
    factor = np.exp(rate * run.t)[:, None, None]
    spoiled = replace(run, position=run.position * factor, velocity=run.velocity * factor)
    found = finding(subject, spoiled)
    assert found.outcome == "fail"
    assert found.value == pytest.approx(abs(rate), rel=1e-5)


def test_a_mass_that_is_stuck_at_its_start_fails_at_the_border_too() -> None:
    """There nothing grows, and it must whirl at w0."""
    subject = subject_of(turning="3")
    run = motion_of(subject)
    stuck = replace(
        run,
        position=np.repeat(run.position[:1], len(run.t), axis=0),
        velocity=np.repeat(run.velocity[:1], len(run.t), axis=0),
    )
    assert finding(subject, stuck).outcome == "fail"


def test_a_motion_that_settles_at_once_and_one_that_is_not_finite_fail() -> None:
    subject = subject_of()
    run = motion_of(subject)
    still = np.zeros_like(run.position)
    still[0] = run.position[0]
    stopped = replace(run, position=still, velocity=np.concatenate([run.velocity[:1], still[1:]]))
    assert finding(subject, stopped).outcome == "fail"


def test_a_start_on_the_other_root_shows_no_growth() -> None:
    """z' = q2 z."""
    _, second = roots(subject_of().instance.scene)
    subject = subject_of(x0="1,0", v0=f"{second.real!r},{second.imag!r}")
    assert CHECK.applies(subject) == "the start has no part in what grows"


@pytest.mark.parametrize(
    "elements",
    [
        [SPRING, FLUID, UniformGravity(g=(0.0, -1.0, 0.0))],
        [SPRING, SPRING, FLUID],
        [FLUID],
        [Spring(a=0, stiffness=8.0, length=1.0), FLUID],
        [Spring(a=0, stiffness=8.0, cubic=1.0), FLUID],
        [SPRING, FLUID, Dashpot(a=0, van_der_pol=1.0)],
        [SPRING, RotatingDashpot(a=0, damping=1.0, anchor_b=(1.0, 0.0, 0.0))],
        [SPRING, RotatingDashpot(a=0, damping=1.0, rate=(1.0, 0.0, 0.0))],
    ],
)
def test_other_scenes_are_left_alone(elements: list[Element]) -> None:
    body = Body(mass=2.0, position=(1.0, 0.0, 0.0))
    shaft = instance([body], elements, times=(0.0, 1.0))
    subject = Subject(shaft, ENGINE.method("exact-whirl"), (0.0,), None)
    assert "not one point on a linear spring" in str(CHECK.applies(subject))


def test_a_scene_without_a_fluid_that_turns_is_left_alone() -> None:
    shaft = instance([Body(mass=2.0)], [SPRING], times=(0.0, 1.0))
    subject = Subject(shaft, ENGINE.method("exact-whirl"), (0.0,), None)
    assert CHECK.applies(subject) == "the scene has no fluid that turns"
    assert Scene.of([Body(mass=2.0)], [SPRING, FLUID]).is_driven()
