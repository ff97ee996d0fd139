"""Pendulums stepped together: against the closed form start by start, order, blocks, the way
back.
"""

import flint
import numpy as np
import pytest

from refdem.core.problem import Ensemble, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers._ensemble_symplectic import WEIGHTS

G = 9.8125


def ensemble(members, times=(0.0, 1.0, 2.0)):
    """Swinging, rotating and near the top, members of one scene."""
    angle = np.linspace(-3.0, 3.0, members)
    rate = np.linspace(9.0, -2.0, members)
    place = np.stack([np.sin(angle), -np.cos(angle), 0 * angle], axis=-1)[:, None]
    speed = (rate[:, None] * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1))[:, None]
    body = Body(mass=1.0, position=tuple(place[0, 0]), velocity=tuple(speed[0, 0]))
    scene = Scene.of([body], [Rod(a=0, b=-1, length=1.0), UniformGravity(g=(0.0, -G, 0.0))])
    return Ensemble(scene=scene, times=np.array(times), position=place, velocity=speed)


def run(problem, method, step=None):
    return ENGINE.run(Request(problem=problem, method=method, step=step))[0].values


def in_many_digits(order, angle, time, steps):
    """Angle (flint.arb) of a pendulum with g/l = 1 from rest, by the composition of that order in
    200 bits.
    """
    half = [flint.arb(part) for part in WEIGHTS[order]]
    parts = half + half[-2::-1]
    h = flint.arb(time) / steps
    rate = flint.arb(0)
    for _ in range(steps):
        for part in parts:
            angle += part * h * rate / 2
            rate -= part * h * angle.sin()
            angle += part * h * rate / 2
    return angle


@pytest.mark.parametrize(("order", "coarse", "fine"), [(8, 20, 40), (10, 20, 32)])
def test_compositions_have_their_order(order, coarse, fine):
    """Where order 10 shows, binary64 has no digits left to show it."""
    with flint.ctx.workprec(200):
        exact, *found = (
            in_many_digits(o, flint.arb(1.5), 6, steps)
            for o, steps in ((10, 100), (order, coarse), (order, fine))
        )
        errors = [float(abs(angle - exact)) for angle in found]
    assert np.log(errors[0] / errors[1]) / np.log(fine / coarse) == pytest.approx(order, abs=0.5)


@pytest.mark.parametrize(
    ("method", "order", "step"),
    [("ensemble-symplectic", 8, 2.0**-5), ("ensemble-symplectic-10", 10, 2.0**-4)],
)
def test_error_falls_at_least_with_the_order_to_that_of_the_closed_form(method, order, step):
    problem = ensemble(40)
    exact = run(problem, "carried-ensemble")
    errors = [
        np.abs(run(problem, method, h)["position"] - exact["position"]).max()
        for h in (2 * step, step)
    ]
    assert np.log2(errors[0] / errors[1]) > order - 0.3
    fine = run(problem, method, 2.0**-8)
    grown = 9.0 * np.exp(
        2 * np.sqrt(G)
    )  # what two seconds near the top make of an ulp of the speed
    assert np.abs(fine["velocity"] - exact["velocity"]).max() < 64 * 2.0**-53 * grown


def test_members_do_not_depend_on_the_block_that_they_are_in():
    many = run(ensemble(1500), "ensemble-symplectic", 2.0**-5)["position"]
    problem = ensemble(1500)
    some = Ensemble(
        scene=problem.scene,
        times=problem.times,
        position=problem.position[700:713],
        velocity=problem.velocity[700:713],
    )
    assert np.array_equal(run(some, "ensemble-symplectic", 2.0**-5)["position"], many[:, 700:713])


def test_time_runs_backwards_to_where_it_began():
    problem = ensemble(20)
    there = run(problem, "ensemble-symplectic", 2.0**-6)
    scene = problem.scene
    back_times = np.array((2.0, 1.0, 0.0))
    back = Ensemble(
        scene=scene,
        times=back_times,
        position=there["position"][-1],
        velocity=there["velocity"][-1],
    )
    assert (
        np.abs(run(back, "ensemble-symplectic", 2.0**-6)["position"][-1] - problem.position).max()
        < 2e-12
    )


def test_a_request_for_an_ensemble_tells_its_step_to_others_and_to_the_store():
    fine, coarse = (
        Request(problem=ensemble(3), method="ensemble-symplectic", step=2.0**-k) for k in (5, 4)
    )
    assert Request.from_json(fine.to_json()).step == 2.0**-5
    assert fine.key("same") != coarse.key("same")
