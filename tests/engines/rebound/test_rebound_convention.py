"""Clock, signs, units and quaternions of the adapter, against motions that are known in closed
form.
"""

import signal
from math import gamma

import numpy as np
import pytest

from refdem.errors import EngineError
from refdem.scene import Body, Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

EVERY = [
    ("leapfrog", {"step": 2.0**-5}),
    ("leapfrog-8", {"step": 2.0**-3}),
    ("ias15", {}),
    ("bs", {"tolerance": 1e-10}),
]


@pytest.mark.parametrize(("method", "control"), EVERY)
def test_a_free_body_flies_straight_in_three_dimensions(run, method, control):
    flight = run(
        Scene.of([Body(mass=1.0, position=(1.0, 2.0, 3.0), velocity=(0.5, -0.25, 1.0))]),
        8.0,
        16,
        method,
        **control,
    )
    assert np.allclose(
        flight.position[:, 0], [1.0, 2.0, 3.0] + flight.t[:, None] * [0.5, -0.25, 1.0], atol=1e-13
    )


@pytest.mark.parametrize(("method", "control"), EVERY)
def test_gravity_is_an_acceleration_along_g(run, method, control):
    fall = run(
        Scene.of([Body(mass=3.0)], [UniformGravity(g=(0.0, -8.0, 1.0))]), 2.0, 4, method, **control
    )
    assert np.allclose(
        fall.position[:, 0], 0.5 * fall.t[:, None] ** 2 * [0.0, -8.0, 1.0], atol=1e-12
    )
    assert np.allclose(fall.velocity[:, 0], fall.t[:, None] * [0.0, -8.0, 1.0], atol=1e-12)


def test_a_spring_of_power_three_halves_swings_with_the_period_of_the_beta_function(run):
    """m x'' = -k |x|^1/2 x from amplitude A: T = 4 sqrt(m/(5k)) A^(-1/4) B(2/5, 1/2)."""
    period = 4 * np.sqrt(2.0 / (5 * 3.0)) * 0.5**-0.25 * gamma(0.4) * gamma(0.5) / gamma(0.9)
    scene = Scene.of(
        [Body(mass=2.0, position=(0.5, 0.0, 0.0))], [Spring(a=0, stiffness=3.0, exponent=1.5)]
    )
    swing = run(scene, period, 4, "bs", tolerance=1e-10)
    assert np.allclose(swing.position[:, 0, 0], [0.5, 0.0, -0.5, 0.0, 0.5], atol=1e-7)


def test_two_bodies_on_a_spring_turn_about_their_centre_of_mass(run):
    """A circle: m_eff w^2 r = k (r - length)."""
    masses = np.array([1.0, 3.0])
    r = 1.25
    w = np.sqrt(8.0 * (r - 1.0) / (0.75 * r))
    arms = r * np.array([0.75, -0.25])
    bodies = [
        Body(mass=m, position=(a, 0.0, 0.0), velocity=(0.0, w * a, 0.0))
        for m, a in zip(masses, arms, strict=True)
    ]
    turn = run(Scene.of(bodies, [Spring(a=0, b=1, stiffness=8.0, length=1.0)]), 4.0, 16, "ias15")
    assert np.allclose(turn.position[:, 0, 0], arms[0] * np.cos(w * turn.t), atol=1e-12)
    assert np.allclose(turn.position[:, 1, 1], arms[1] * np.sin(w * turn.t), atol=1e-12)
    assert np.abs(masses @ turn.velocity).max() < 1e-14


def test_a_pair_on_a_rod_turns_and_pulls_it(run):
    """Tension m_eff w^2 length, positive."""
    bodies = [
        Body(mass=1.0, position=(1.5, 0.0, 0.0), velocity=(0.0, 3.0, 0.0)),
        Body(mass=3.0, position=(-0.5, 0.0, 0.0), velocity=(0.0, -1.0, 0.0)),
    ]
    turn = run(Scene.of(bodies, [Rod(a=0, b=1, length=2.0)]), 4.0, 16, "ias15")
    assert np.allclose(turn.position[:, 0, 0], 1.5 * np.cos(2.0 * turn.t), atol=1e-12)
    assert np.allclose(turn.channels["rod_force"], 0.75 * 4.0 * 2.0, atol=1e-12)


def test_a_fixed_body_stays(run):
    bodies = [Body(mass=1.0, position=(1.0, 0.0, 0.0)), Body(mass=1.0, fixed=True)]
    swing = run(
        Scene.of(bodies, [Spring(a=0, b=1, stiffness=1.0), UniformGravity(g=(0.0, -1.0, 0.0))]),
        3.0,
        6,
        "ias15",
    )
    assert not swing.position[:, 1].any()
    assert np.allclose(swing.position[:, 0, 0], np.cos(swing.t), atol=1e-12)


def test_a_quarter_turn_about_x_and_omega_in_space_axes(run):
    """A sphere's omega is constant in space; here the body starts turned by 90 degrees about z."""
    start = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
    body = Body(mass=1.0, inertia=(2.0, 2.0, 2.0), attitude=start, omega=(np.pi / 2, 0.0, 0.0))
    turned = run(Scene.of([body]), 1.0, 4, "bs", tolerance=1e-12)
    assert np.allclose(turned.omega[:, 0], [np.pi / 2, 0.0, 0.0], atol=1e-14)
    assert np.allclose(
        turned.attitude[-1, 0], [0.5, 0.5, -0.5, 0.5], atol=1e-12
    )  # (c, s, 0, 0) times (c, 0, 0, c), c = s


def test_a_symmetric_top_precesses_about_its_angular_momentum(run):
    """omega_body turns at (J3 - J1)/J1 w3 about the third axis, positive sense in the body."""
    scene = Scene.of([Body(mass=1.0, inertia=(1.0, 1.0, 1.5), omega=(1.0, 0.0, 2.0))])
    top = run(scene, 5.0, 20, "bs", tolerance=1e-12)
    w, x, y, z = top.attitude[:, 0].T
    first = np.stack(
        [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1
    )  # R e_1
    assert np.allclose(
        np.sum(first * top.omega[:, 0], axis=-1), np.cos(0.5 * 2.0 * top.t), atol=1e-10
    )


def test_the_clock_starts_where_the_problem_does_and_runs_both_ways(run):
    orbit = Scene.of(
        [Body(mass=5.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))], [CentralField(gm=1.0)]
    )
    for method, control in [*EVERY, ("whfast", {})]:
        back = run(orbit, -4.0, 8, method, **control)
        assert np.allclose(
            back.position[:, 0, 1], np.sin(back.t), atol=5e-3 if method == "leapfrog" else 1e-8
        )
        assert back.t[-1] == pytest.approx(-4.0, abs=1e-13)


def test_the_interrupt_handler_is_left_as_it_was(run):
    before = signal.getsignal(signal.SIGINT)
    called = []
    signal.signal(signal.SIGINT, lambda *_: called.append(True))
    try:
        run(Scene.of([Body(mass=1.0, velocity=(1.0, 0.0, 0.0))]), 1.0, 2, "ias15")
        signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
    assert called == [True]


def test_a_layout_that_the_callbacks_do_not_know_is_an_error():
    from refdem.engines.rebound.simulation import _callback

    with pytest.raises(EngineError, match="byte 4096"):
        _callback("forces", 4096)
