"""Clock, signs, units and quaternions of the adapter, against motions that are known in closed
form.
"""

import numpy as np

from refdem.scene import Body, Scene
from refdem.scene.elements.force import Force
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity


def test_times_are_whole_numbers_of_steps(run):
    flight = run(Scene.of([Body(mass=1.0, velocity=(1.0, 0.0, 0.0))]), 2.0, 8, 2.0**-6)
    assert np.array_equal(flight.t, np.arange(9) / 4)
    assert np.array_equal(flight.position[:, 0], flight.t[:, None] * [1.0, 0.0, 0.0])


def test_a_quarter_turn_about_z_is_the_quaternion_cos_45_0_0_sin_45(run):
    spinning = Scene.of([Body(mass=2.0, inertia=(1.0, 2.0, 3.0), omega=(0.0, 0.0, np.pi / 2))])
    turned = run(spinning, 1.0, 4, 2.0**-4)
    assert np.allclose(turned.attitude[-1, 0], [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)], atol=1e-14)
    assert np.allclose(turned.omega[:, 0], [0.0, 0.0, np.pi / 2], atol=1e-15)


def test_an_attitude_about_z_survives_the_door(run):
    half = 0.3
    tilted = Body(
        mass=1.0,
        inertia=(1.0, 1.0, 2.0),
        attitude=(np.cos(half), 0.0, 0.0, np.sin(half)),
        omega=(0.0, 0.0, -0.5),
    )
    turned = run(Scene.of([tilted]), 2.0, 4, 2.0**-5)
    assert np.allclose(turned.attitude[0, 0], [np.cos(half), 0.0, 0.0, np.sin(half)], atol=1e-15)
    assert np.allclose(
        turned.attitude[-1, 0], [np.cos(half - 0.5), 0.0, 0.0, np.sin(half - 0.5)], atol=1e-14
    )


def test_gravity_pulls_along_minus_y_with_an_error_of_half_a_step(run):
    step = 2.0**-7
    fall = run(Scene.of([Body(mass=3.0)], [UniformGravity(g=(0.0, -8.0, 0.0))]), 1.0, 4, step)
    assert np.allclose(fall.position[:, 0, 1], -4.0 * fall.t**2 + 4.0 * step * fall.t, atol=1e-13)
    assert np.allclose(fall.velocity[:, 0, 1], -8.0 * fall.t, atol=1e-13)


def test_an_off_centre_spring_turns_the_body_by_j3(run):
    """A small turn: J3 phi'' = -k r^2 phi for a spring of natural length 0 from (r, 0) to its own
    place.
    """
    body = Body(mass=1e9, inertia=(0.4, 0.3, 0.5), attitude=(np.cos(5e-5), 0.0, 0.0, np.sin(5e-5)))
    turned = run(
        Scene.of(
            [body], [Spring(a=0, stiffness=2.0, anchor_a=(1.0, 0.0, 0.0), anchor_b=(1.0, 0.0, 0.0))]
        ),
        3.0,
        6,
        2.0**-12,
    )
    angle = 2 * np.arctan2(turned.attitude[:, 0, 3], turned.attitude[:, 0, 0])
    assert np.allclose(angle, 1e-4 * np.cos(2.0 * turned.t), atol=1e-7)


def test_momentum_and_angular_momentum_of_a_pair_stay_to_round_off(run):
    pair = [
        Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 0.5, 0.0)),
        Body(mass=3.0, velocity=(0.1, -0.2, 0.0)),
    ]
    for element in (Spring(a=0, b=1, stiffness=2.0, length=0.8), Rod(a=0, b=1, length=1.0)):
        moved = run(Scene.of(pair, [element]), 8.0, 32, 2.0**-6)
        mass = np.array([1.0, 3.0])
        momentum = np.einsum("n,tnk->tk", mass, moved.velocity)
        turn = np.einsum("n,tn->t", mass, np.cross(moved.position, moved.velocity)[..., 2])
        assert np.abs(momentum - momentum[0]).max() < 2e-14
        assert np.abs(turn - turn[0]).max() < 5e-14


def test_a_drive_with_a_phase_follows_the_clock_forwards(run):
    """v = A/(m w) (sin(w t + phase) - sin phase): with the other sign of the clock it would turn
    back another way.
    """
    amplitude = 12.0
    mass = 2.0
    rate = 1.25
    phase = -0.7
    step = 2.0**-12
    driven = run(
        Scene.of(
            [Body(mass=mass)],
            [Force(a=0, amplitude=amplitude, frequency=rate, phase=phase, axis=(0.0, 1.0, 0.0))],
        ),
        1.0,
        8,
        step,
    )
    velocity = amplitude / (mass * rate) * (np.sin(rate * driven.t + phase) - np.sin(phase))
    np.testing.assert_allclose(driven.velocity[:, 0, 1], velocity, atol=amplitude / mass * step)
