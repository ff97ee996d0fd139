"""What REBOUND's integrators are worth on the oscillator, the Kepler orbit, the pendulum and a
tumbling body.
"""

import math

import numpy as np
import pytest

from refdem.scene import Body, Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.engines.accuracy import agm, orders

OSCILLATOR = Scene.of([Body(mass=2.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=2.0)])


def orbit(eccentricity: float) -> Scene:
    """An orbit of semi-major axis 1 m about gm = 1 m^3/s^2, from periapsis."""
    speed = math.sqrt((1 + eccentricity) / (1 - eccentricity))
    return Scene.of(
        [Body(mass=1.0, position=(1 - eccentricity, 0.0, 0.0), velocity=(0.0, speed, 0.0))],
        [CentralField(gm=1.0)],
    )


def kepler(t: np.ndarray, e: float) -> np.ndarray:
    """Places (T, 2) [m] on that orbit: Kepler's equation by Newton's method in long double."""
    mean = t.astype(np.longdouble)
    anomaly = mean + e * np.sin(mean)
    for _ in range(50):
        anomaly -= (anomaly - e * np.sin(anomaly) - mean) / (1 - e * np.cos(anomaly))
    return np.stack(
        [np.cos(anomaly) - e, np.sqrt(np.longdouble(1 - e * e)) * np.sin(anomaly)], axis=-1
    ).astype(float)


@pytest.mark.parametrize(
    ("method", "order", "steps"), [("leapfrog", 2, (3, 4, 5, 6)), ("leapfrog-8", 8, (0, 1, 2))]
)
def test_leapfrog_has_its_order_on_the_oscillator_and_the_orbit(run, method, order, steps):
    swings = [run(OSCILLATOR, 16.0, 16, method, step=2.0**-k) for k in steps]
    assert orders(
        [np.abs(s.position[:, 0, 0] - np.cos(s.t)).max() for s in swings]
    ) == pytest.approx([order] * (len(steps) - 1), abs=0.15)
    turns = [run(orbit(0.3), 8.0, 16, method, step=2.0 ** -(k + 1)) for k in steps]
    assert orders([np.abs(s.position[:, 0, :2] - kepler(s.t, 0.3)).max() for s in turns])[
        -1
    ] == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize(("method", "step"), [("leapfrog", 2.0**-4), ("leapfrog-8", 2.0**-2)])
def test_leapfrog_comes_back_to_round_off_with_velocities_flipped_and_with_negative_steps(
    run, method, step
):
    start = orbit(0.3)
    end = run(start, 16.0, 16, method, step=step).end()
    flipped = run(
        start.with_state(position=end["position"], velocity=-end["velocity"]),
        16.0,
        16,
        method,
        step=step,
    ).end()
    backward = run(
        start.with_state(position=end["position"], velocity=end["velocity"]),
        -16.0,
        16,
        method,
        step=step,
    ).end()
    assert np.abs(flipped["position"] - start.bodies.position).max() < 2e-12
    assert np.abs(flipped["velocity"] + start.bodies.velocity).max() < 2e-12
    assert np.abs(backward["position"] - start.bodies.position).max() < 2e-12
    assert np.abs(backward["velocity"] - start.bodies.velocity).max() < 2e-12


@pytest.mark.parametrize(
    ("eccentricity", "bound"), [(0.0, 3e-13), (0.5, 5e-13), (0.9, 1e-11), (0.99, 2e-10)]
)
def test_whfast_and_ias15_follow_the_orbit_to_round_off(run, eccentricity, bound):
    for method in ("whfast", "ias15"):
        turn = run(orbit(eccentricity), 20.0, 64, method)
        assert np.abs(turn.position[:, 0, :2] - kepler(turn.t, eccentricity)).max() < bound


@pytest.mark.parametrize(
    ("method", "control", "bound"),
    [("ias15", {}, 1e-13), ("bs", {"tolerance": 1e-6}, 1e-6), ("bs", {"tolerance": 1e-12}, 1e-12)],
)
def test_the_pendulum_is_right_after_nine_eighths_of_a_period_and_so_is_its_rod_force(
    run, method, control, bound
):
    """From rest at 2 rad: there sin(theta/2) = k sn(K/2) = k/sqrt(1 + k'), k = sin 1 (DLMF 22.5.2);

    F = 3 cos theta - 2 cos 2.
    """
    k = math.sin(1.0)
    k1 = math.cos(1.0)
    duration = 9 * math.pi / (4 * agm(1.0, k1))
    bob = Body(mass=1.0, position=(math.sin(2.0), -math.cos(2.0), 0.0))
    swing = run(
        Scene.of([bob], [Rod(a=0, length=1.0), UniformGravity(g=(0.0, -1.0, 0.0))]),
        duration,
        36,
        method,
        **control,
    )
    sine = k / math.sqrt(1 + k1)
    assert swing.position[-1, 0, 0] == pytest.approx(2 * sine * math.sqrt(1 - sine**2), abs=bound)
    assert np.abs(np.linalg.norm(swing.position[:, 0], axis=-1) - 1).max() < bound
    assert swing.channels["rod_force"][-1, 0] == pytest.approx(
        3 * (1 - 2 * sine**2) - 2 * math.cos(2.0), abs=4 * bound
    )


def test_bs_keeps_energy_and_angular_momentum_of_a_tumbling_body_to_its_tolerance(run):
    inertia = np.array([1.0, 2.0, 3.0])
    body = Scene.of([Body(mass=1.0, inertia=tuple(inertia), omega=(0.9, 1.1, 1.3))])
    errors = []
    for tolerance in (1e-4, 1e-7, 1e-10):
        turned = run(body, 16.0, 64, "bs", tolerance=tolerance)
        w, x, y, z = turned.attitude[:, 0].T
        rows = [[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]]
        rows += [[2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)]]
        rows += [[2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]]
        axes = np.moveaxis(np.array(rows), -1, 0)  # rows are the body's axes in space
        spin = np.einsum("tij,tj->ti", axes, turned.omega[:, 0]) * inertia
        in_space = np.einsum("tij,ti->tj", axes, spin)
        errors.append(np.abs(in_space - in_space[0]).max())
        assert errors[-1] < 1e3 * tolerance
    assert errors[0] > errors[1] > errors[2]


def test_ias15_is_off_by_its_own_clock_and_not_by_its_integration(run):
    """Its steps are no multiples of the unit in the last place of t, so that `t += dt` loses a
    part, the same one at each sample.

    512 samples of 20 s: off by 1.5e-13; with the clock put back to zero before every sample by
    7e-16.
    """
    swing = run(OSCILLATOR, 20.0, 512, "ias15")
    off = np.abs(swing.position[:, 0, 0] - np.cos(swing.t)).max()
    state = OSCILLATOR
    restarted = [1.0]
    for _ in range(512):
        end = run(state, 20.0 / 512, 1, "ias15").end()
        state = state.with_state(position=end["position"], velocity=end["velocity"])
        restarted.append(end["position"][0, 0])
    assert 1e-14 < off < 2e-12
    assert np.abs(np.array(restarted) - np.cos(swing.t)).max() < 1e-14


def test_output_every_step_leaves_the_bits_of_leapfrog_as_they_are(run):
    coarse, fine = (run(OSCILLATOR, 8.0, n, "leapfrog", step=2.0**-4) for n in (8, 128))
    assert np.array_equal(coarse.position, fine.position[::16])
