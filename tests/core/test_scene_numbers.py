"""The numbers of a scene have the keys of `request.txt`, and change with those of a case as its
formulas say.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.request_text import request_text
from refdem.core.scene_numbers import (
    keys_of,
    numbers_in,
    observed_slopes,
    rounding_of_slopes,
    scene_rates,
)
from refdem.core.trajectory import Trajectory
from refdem.truth.sensitivities import Number

BALL = discovery.case("bouncing-ball").at(radius="1/2", mass="3", inertia_factor="2/5")
PENDULUM = discovery.case("pendulum").at(theta0="1/2", thetadot0="1/4", length="2")


def test_every_number_of_a_scene_has_its_key_in_the_text_of_the_request():
    request = Request(problem=BALL.problem, method="any", step=float(BALL.times[1]))
    lines = dict(line.split(" ", 1) for line in request_text(request).splitlines())
    numbers = numbers_in(BALL.scene)
    assert {key: float(lines[key]) for key in numbers} == numbers
    assert numbers["scene.bodies.0.mass"] == 3.0


def test_a_radius_lifts_the_centre_and_makes_the_moments_larger():
    # y = height + R, J = 2/5 m R^2: dJ/dR = 4/5 m R = 6/5.
    rates = scene_rates(BALL, BALL.p, Number("radius"))
    expected = {f"scene.bodies.0.inertia.{axis}": 1.2 for axis in range(3)}
    expected |= {"scene.bodies.0.position.1": 1.0, "scene.bodies.0.shape.radius": 1.0}
    assert rates == pytest.approx(expected, rel=1e-11)


def test_an_angle_turns_place_and_velocity():
    # x = l sin, y = -l cos, v = l thetadot (cos, sin).
    rates = scene_rates(PENDULUM, PENDULUM.p, Number("theta0"))
    s, c = np.sin(0.5), np.cos(0.5)
    expected = {"position.0": 2 * c, "position.1": 2 * s}
    expected |= {"velocity.0": -0.5 * s, "velocity.1": 0.5 * c}
    expected = {f"scene.bodies.0.{key}": rate for key, rate in expected.items()}
    assert rates == pytest.approx(expected, rel=1e-11)


def test_an_angle_of_many_turns_is_moved_by_no_more_than_any_other():
    # x = l sin theta0 at theta0 = -147: the error of the differences is that at any angle.
    turned = discovery.case("pendulum").at(theta0="-147", thetadot0="0")
    rates = scene_rates(turned, turned.p, Number("theta0"))
    assert rates["scene.bodies.0.position.0"] == pytest.approx(np.cos(-147.0), rel=1e-11)


@pytest.mark.parametrize("number", ["friction", "tangential_restitution"])
def test_a_number_without_a_scene_on_one_side_has_no_rates(number):
    assert scene_rates(BALL, BALL.p, Number(number)) is None


def test_numbers_on_which_nothing_acts_are_not_asked_for():
    rates = {"height": {"scene.bodies.0.position.1": 1.0}, "friction": None}
    assert keys_of(rates, BALL.scene) == ("scene.bodies.0.position.1",)


def test_what_is_observed_is_differentiated_through_the_states_and_the_number_itself():
    # theta = atan2(x, -y) of a state that a change of theta0 turns: dtheta/dtheta0 = 1.
    rates = scene_rates(PENDULUM, PENDULUM.p, Number("theta0"))
    body = PENDULUM.scene.bodies
    t = np.array([0.0])
    slopes = {key: np.zeros((1, 1, 13)) for key in rates}
    for axis in (0, 1):
        slopes[f"scene.bodies.0.position.{axis}"][..., axis] = 1.0
        slopes[f"scene.bodies.0.velocity.{axis}"][..., 3 + axis] = 1.0
    run = Trajectory.of_points(t, body.position[None], body.velocity[None], derivatives=slopes)
    seen = observed_slopes(PENDULUM, PENDULUM.p, Number("theta0"), run, rates)
    assert seen["theta"] == pytest.approx([1.0], rel=1e-10)
    assert seen["thetadot"] == pytest.approx([0.0], abs=1e-10)
    assert seen["x"] == pytest.approx([2 * np.cos(0.5)], rel=1e-10)


def test_an_angle_is_differentiated_across_its_cut():
    # At theta = pi the observed angle jumps from pi to -pi; its derivative does not.
    upright = discovery.case("pendulum").at(theta0="3217/1024", thetadot0="1")
    rates = scene_rates(upright, upright.p, Number("theta0"))
    body = upright.scene.bodies
    slopes = {key: np.zeros((1, 1, 13)) for key in rates}
    for axis in (0, 1):
        slopes[f"scene.bodies.0.position.{axis}"][..., axis] = 1.0
        slopes[f"scene.bodies.0.velocity.{axis}"][..., 3 + axis] = 1.0
    run = Trajectory.of_points(
        np.array([0.0]), body.position[None], body.velocity[None], derivatives=slopes
    )
    seen = observed_slopes(upright, upright.p, Number("theta0"), run, rates)
    assert seen["theta"] == pytest.approx([1.0], rel=1e-10)
    assert abs(float(upright.p.theta0) - np.pi) < float(Fraction(1, 512))


@pytest.mark.parametrize(("height", "most"), [("1", 1e-11), ("1/1024", 1e-9)])
def test_what_rounding_leaves_of_a_slope_grows_as_a_number_is_felt_less(height, most):
    # y = height + R is rounded by u y, and moved by a part of the height: the error is u y/height.
    ball = discovery.case("bouncing-ball").at(height=height, radius="1")
    number = Number("height")
    rates = scene_rates(ball, ball.p, number)
    body = ball.scene.bodies
    slopes = {key: np.zeros((1, 1, 13)) for key in rates}
    slopes["scene.bodies.0.position.1"][..., 1] = 1.0
    start = body.position[None], body.velocity[None]
    run = Trajectory.of_points(np.array([0.0]), *start, derivatives=slopes)
    seen = observed_slopes(ball, ball.p, number, run, rates)
    rounding = rounding_of_slopes(ball, ball.p, number, run, rates)
    error = abs(seen["y"][0] - 1.0) / ball.quantities["y"].scale
    unit = 1.0 / ball.quantities["y"].scale
    assert error <= rounding < most * unit
