"""A block on a slope: decided exactly at the boundary, a parabola below it; the reference, pymunk,
and faults that are seen.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.errors import UsageError
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.solvers import exact_slide
from refdem.truth.closed_forms.block_on_slope import slides

REGIMES = {
    "above": {"friction": "0.9"},
    "at": {},
    "below": {"friction": "1/2"},
    "ice": {"friction": "0"},
    "steep": {"angle": "1.4"},
}


def failures(engine, method, **given):
    """Quantities that fail, and how many were decided."""
    instance = discovery.case("block-on-slope").at(**given)
    findings = record_of(
        task_of(discovery.engine(engine), method, instance, truth_of(instance), 3)
    ).findings
    return {f.quantity for f in findings if f.outcome in ("fail", "error")}, sum(
        f.outcome == "pass" for f in findings
    )


@pytest.mark.parametrize("regime", REGIMES)
def test_the_reference_holds_every_regime(regime):
    given = REGIMES[regime]
    method = (
        discovery.engine("reference")
        .best(discovery.case("block-on-slope").at(**given).problem)
        .name
    )
    assert method == ("equilibrium" if regime in ("above", "at") else "exact-slide")
    failed, passed = failures("reference", method, **given)
    assert failed == set()
    assert passed >= 4


@pytest.mark.parametrize("regime", ["at", "below"])
def test_pymunk_holds_the_block_and_lets_it_slide(regime):
    failed, passed = failures("pymunk", "semi-implicit-euler", duration="1", **REGIMES[regime])
    assert failed == set()
    assert passed > 10


def test_the_fall_line_turns_with_the_heading_and_the_way_down_it_does_not_change():
    """60 degrees from x towards z; the heading is rounded to 16 digits."""
    straight = discovery.case("block-on-slope").at(friction="1/2")
    turned = discovery.case("block-on-slope").at(friction="1/2", heading="1.0471975511965976")
    reference = discovery.engine("reference")
    trajectories = []
    for instance in (straight, turned):
        request = Request(problem=instance.problem, method="exact-slide")
        trajectory, _ = reference.run(request)
        trajectories.append(trajectory)
    way = trajectories[0].position[:, 0, 0]
    assert trajectories[1].position[:, 0, 0] == pytest.approx(way / 2, rel=1e-14)
    assert trajectories[1].position[:, 0, 2] == pytest.approx(way * 0.75**0.5, rel=1e-14)
    seen = turned.case.observe(turned.p, trajectories[1])
    assert seen["s"] == pytest.approx(way, rel=1e-14)
    assert seen["v"] == pytest.approx(trajectories[0].velocity[:, 0, 0], rel=1e-14)


@pytest.mark.parametrize("method", ["rk4", "euler", "implicitfast"])
def test_tuned_mujoco_brakes_in_every_direction_and_as_shipped_less_on_the_diagonal(method):
    given = {"friction": "1/2", "heading": "0.7854", "duration": "0.5"}
    assert failures("mujoco", method, **given)[0] == set()
    assert failures("mujoco", "euler-as-shipped", **given)[0] >= {"s", "v"}


def test_a_hundred_digits_off_the_boundary_is_not_the_boundary():
    hair = Fraction(1, 10**60)
    assert not slides(Fraction(3, 4), Fraction(3, 4), None)
    assert slides(Fraction(3, 4) - hair, Fraction(3, 4), None)
    tangent = Fraction(
        "0.546302489843790513255179465780285383297551720179791246164091385932907510518025815715180648270656218589"
    )
    assert slides(tangent - hair, Fraction(0), Fraction(1, 2))  # tan(1/2) to 100 digits
    assert not slides(tangent + hair, Fraction(0), Fraction(1, 2))
    assert not slides(Fraction(0), Fraction(0), Fraction(0))


def test_way_and_speed_are_those_of_the_work_that_is_left():
    instance = discovery.case("block-on-slope").at(friction="1/2", gravity="10")
    balls = instance.truth().at(Fraction(3))
    rise = 10 * (Fraction(3, 5) - Fraction(1, 2) * Fraction(4, 5))  # 3-4-5
    assert abs(balls["v"].mid - 3 * rise) < Fraction(1, 10**38)
    assert abs(balls["v"].mid ** 2 / 2 - rise * balls["s"].mid) < Fraction(1, 10**36)


def test_the_block_stays_bit_for_bit_over_a_million_steps():
    instance = discovery.case("block-on-slope").at(duration="1e5", samples="1000")
    trajectory, _ = discovery.engine("reference").run(next(iter(runs_of(instance))))
    assert np.array_equal(trajectory.position, np.repeat(trajectory.position[:1], 1001, axis=0))
    assert not trajectory.velocity.any()


def runs_of(instance):
    yield Request(problem=instance.problem, method="equilibrium")


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("friction uphill lost", 0.0),
        ("friction downhill", -1.0),
        ("friction of half the load", 0.5),
    ],
)
def test_wrong_friction_is_seen(monkeypatch, name, change):
    steepness = exact_slide._balance.Load.steepness.fget
    monkeypatch.setattr(
        exact_slide.ExactSlide, "run", wrong(exact_slide.ExactSlide.run, change, steepness)
    )
    assert failures("reference", "exact-slide", friction="1/2")[0] >= {"s", "v"}


def wrong(run, change, steepness):
    """The run with friction changed by a factor: the acceleration grows by what friction took too
    little.
    """

    def changed(self, request):
        trajectory, cost = run(self, request)
        load = exact_slide._balance.pressed(request.problem.scene)
        factor = (1 - change * 0.5 / steepness(load)) / (1 - 0.5 / steepness(load))
        trajectory.velocity[:] *= factor
        trajectory.position[:] = (
            trajectory.position[0] + (trajectory.position - trajectory.position[0]) * factor
        )
        return trajectory, cost

    return changed


def test_slopes_on_which_the_block_tips_are_refused():
    with pytest.raises(UsageError, match="slope"):
        discovery.case("block-on-slope").at(slope="9")


def test_a_tall_block_that_would_tip_is_not_said_to_slide(monkeypatch):
    from refdem.cases import _slope

    monkeypatch.setattr(_slope, "SIDES", (0.25, 2.0, 2.0))
    problem = discovery.case("block-on-slope").at(friction="1/2").problem
    assert "not over it" in exact_slide.METHOD.unsupported(problem)
