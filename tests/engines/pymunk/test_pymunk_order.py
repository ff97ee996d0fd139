"""What Chipmunk's step is worth: first order everywhere, no creep, no secular drift where a rod is
corrected at once.
"""

import math

import numpy as np
import pytest

from refdem.scene import Body, Scene, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.engines.accuracy import agm, orders

STEPS = [2.0**-k for k in (6, 7, 8, 9)]


def test_the_oscillator_is_first_order(run):
    oscillator = Scene.of([Body(mass=2.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=2.0)])
    errors = []
    for step in STEPS:
        swing = run(oscillator, 16.0, 64, step)
        errors.append(np.abs(swing.position[:, 0, 0] - np.cos(swing.t)).max())
    assert orders(errors) == pytest.approx([1.0] * 3, abs=0.02)
    assert errors[0] == pytest.approx(
        STEPS[0] / 2, rel=0.01
    )  # x of symplectic Euler runs ahead by h/2 sin t


def bob(theta: float, rate: float) -> Body:
    """A point on a rod of 1 m at the angle theta [rad] with the angular rate [rad/s]."""
    s = math.sin(theta)
    c = math.cos(theta)
    return Body(mass=1.0, position=(s, -c, 0.0), velocity=(rate * c, rate * s, 0.0))


def test_the_pendulum_is_first_order_an_eighth_after_one_period(run):
    """From rest at theta0: there sin(theta/2) = k sn(K/2) = k/sqrt(1 + k'), k = sin(theta0/2) (DLMF
    22.5.2).

    From the bottom it would be second order: where no force acts along the path, kicking late
    changes nothing.
    """
    k = math.sin(1.0)
    k1 = math.cos(1.0)
    eighth = math.pi / (4 * agm(1.0, k1))
    theta = 2 * math.asin(k / math.sqrt(1 + k1))
    scene = Scene.of([bob(2.0, 0.0)], [Rod(a=0, length=1.0), UniformGravity(g=(0.0, -1.0, 0.0))])
    ends = [run(scene, 9 * eighth, 36, eighth / 4 / n) for n in (32, 64, 128, 256)]
    assert orders(
        [abs(float(end.position[-1, 0, 0]) - math.sin(theta)) for end in ends]
    ) == pytest.approx([1.0] * 3, abs=0.1)
    lengths = [float(np.abs(np.linalg.norm(end.position[:, 0], axis=-1) - 1).max()) for end in ends]
    assert orders(lengths) == pytest.approx([2.0] * 3, abs=0.05)


def test_the_rod_loses_energy_at_third_order_in_the_step(run):
    scene = Scene.of([bob(2.0, 0.0)], [Rod(a=0, length=1.0), UniformGravity(g=(0.0, -1.0, 0.0))])
    losses = []
    for step in (2.0**-5, 2.0**-6, 2.0**-7):
        swing = run(scene, 1024.0, 2048, step)
        energy = 0.5 * np.sum(swing.velocity[:, 0] ** 2, axis=-1) + swing.position[:, 0, 1]
        losses.append(float(energy[:512].mean() - energy[-512:].mean()))
    assert min(losses) > 0
    assert orders(losses) == pytest.approx([3.0] * 2, abs=0.1)


def test_dry_friction_stops_the_oscillator_at_the_right_place_for_ever(run):
    dry = Scene.of(
        [Body(mass=1.0, position=(1.0, 0.0, 0.0))],
        [Spring(a=0, stiffness=1.0), Slider(a=0, friction=0.15, normal_force=1.0)],
    )
    for step in STEPS:
        stopped = run(dry, 64.0, 64, step)
        assert abs(stopped.position[-1, 0, 0] + 0.1) < step
        assert np.ptp(stopped.position[16:, 0, 0]) == 0.0
        assert not stopped.velocity[16:].any()


def test_friction_below_the_limit_holds_from_the_start(run):
    held = Scene.of(
        [Body(mass=1.0, position=(0.5, 0.0, 0.0))],
        [Spring(a=0, stiffness=1.0), Slider(a=0, friction=0.5, normal_force=1.0)],
    )
    assert np.ptp(run(held, 8.0, 16, 2.0**-5).position[:, 0, 0]) == 0.0


def test_a_planar_block_rests_on_a_plane(run):
    block = Body(
        mass=1.0, inertia=(1.0, 1.0, 1 / 6), position=(0.0, 0.5, 0.0), shape=box(1.0, 1.0, 1.0)
    )
    scene = Scene.of(
        [block],
        [
            Contact(law="rigid", friction=0.5),
            Plane(normal=(0.0, 1.0, 0.0)),
            UniformGravity(g=(0.0, -9.8125, 0.0)),
        ],
    )
    rest = run(scene, 16.0, 16, 2.0**-7)
    assert np.abs(rest.position[:, 0] - [0.0, 0.5, 0.0]).max() < 1e-5
    assert np.abs(rest.velocity).max() < 1e-12


def test_a_planar_block_slides_to_a_stop_under_friction(run):
    """Distance v^2/(2 mu g)."""
    block = Body(
        mass=1.0,
        inertia=(1.0, 1.0, 1 / 6),
        position=(0.0, 0.05, 0.0),
        velocity=(2.0, 0.0, 0.0),
        shape=box(1.0, 0.1, 1.0),
    )
    scene = Scene.of(
        [block],
        [
            Contact(law="rigid", friction=0.5),
            Plane(normal=(0.0, 1.0, 0.0)),
            UniformGravity(g=(0.0, -8.0, 0.0)),
        ],
    )
    assert run(scene, 1.0, 16, 2.0**-9).position[-1, 0, 0] == pytest.approx(0.5, abs=4e-3)
