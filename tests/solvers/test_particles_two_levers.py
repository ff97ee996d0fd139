"""The contact law whose slip is at R and whose torque is at R - d/2 (branch slip-R)."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.scene.elements.contact import Contact

OBLIQUE = {"damping": "0", "angle": "1/2", "friction": "1000000000", "tangential_stiffness": "64"}
SUPPORTED = ("velocity-verlet", "rk4", "contact-events")
EXACT = "contact-events"


def collision(**given):
    return discovery.case("two-spheres").at(**OBLIQUE | given)


def motion(method, **given):
    problem = collision(**given).problem
    step = problem.interval / 64
    if ENGINE.method(method).control != "step":
        step = None
    run, _ = ENGINE.run(Request(problem=problem, method=method, step=step))
    return run


def kinetic_and_normal(scene, run):
    """Kinetic energy and that of the normal spring (T,) [J]."""
    bodies = scene.bodies
    moving = 0.5 * np.sum(bodies.mass[:, None] * run.velocity**2, axis=(1, 2))
    spinning = 0.5 * np.sum(bodies.inertia[:, :1] * run.omega**2, axis=(1, 2))
    return moving + spinning + scene.potential(run.position, run.attitude)


@pytest.mark.parametrize(("branch", "spin"), [("slip-R", -0.565), ("R-d/2", -0.600)])
@pytest.mark.parametrize("method", SUPPORTED)
def test_the_spin_after_a_collision_tells_two_levers_from_one(method, branch, spin):
    run = motion(method, branch=branch)
    assert run.omega[-1, :, 2] == pytest.approx(spin, abs=5e-4)


def plain_spin(slip_share, torque_share, steps=2**14):
    """omega_z of both spheres behind the collision, by the midpoint rule on the law as it stands
    in words: equal spheres in the frame of their centre of mass, m = 1, R = 1/2.
    """
    k, k_t, inertia = 128.0, 64.0, 0.4 * 0.25
    radius = 0.5

    def rate(y):
        # The second centre from the first, its velocity, the spin of either, the spring.
        place, velocity, omega, stretch = y[:2], y[2:4], y[4], y[5]
        distance = np.hypot(*place)
        overlap = 1 - distance
        normal = place / distance
        across = np.array([-normal[1], normal[0]])
        slip = -velocity @ across + 2 * (radius - slip_share * overlap) * omega
        # On the first body; the second has the opposite force and the same torque.
        friction = -k_t * stretch
        on_first = -k * overlap * normal + friction * across
        spin_rate = (radius - torque_share * overlap) * friction / inertia
        return np.array([*velocity, *(-2 * on_first), spin_rate, slip])

    y = np.array([1.0, 0.0, -np.cos(0.5), -np.sin(0.5), 0.0, 0.0])
    h = 0.5 / steps
    for _ in range(steps):
        before = y
        y = y + h * rate(y + h / 2 * rate(y))
        overlaps = 1 - np.hypot(*before[:2]), 1 - np.hypot(*y[:2])
        if overlaps[1] < 0:
            # The end of the contact, within the step.
            part = overlaps[0] / (overlaps[0] - overlaps[1])
            return (before + part * (y - before))[4]
    raise AssertionError("the spheres do not part")


@pytest.mark.parametrize(("branch", "shares"), [("slip-R", (0.0, 0.5)), ("R-d/2", (0.5, 0.5))])
def test_the_spin_is_that_of_the_law_integrated_in_twenty_lines(branch, shares):
    expected = plain_spin(*shares)
    found = motion(EXACT, branch=branch).omega[-1, :, 2]
    assert found == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("spring", ["64", "0"])
def test_what_friction_loses_is_counted_at_the_levers_of_the_torque(spring):
    given = {
        "branch": "slip-R",
        "friction": "1/4",
        "tangential_stiffness": spring,
        "spins": "0,0,1,0,0,2",
        "masses": "1,3",
        "radii": "1/2,3/4",
    }
    scene = collision(**given).scene
    run = motion(EXACT, **given)
    energy = kinetic_and_normal(scene, run)
    # Before the contact and behind it no tangential spring holds energy.
    lost = energy[0] - energy[-1]
    assert abs(lost) > 1e-3
    assert run.channels["dissipated_work"][-1] == pytest.approx(lost, abs=1e-12)


def test_momentum_and_total_angular_momentum_stay():
    given = {"branch": "slip-R", "masses": "1,3", "radii": "1/2,3/4", "spins": "1,2,3,-1,2,0"}
    scene = collision(**given).scene
    run = motion("velocity-verlet", **given)
    mass = scene.bodies.mass[:, None]
    momentum = np.sum(mass * run.velocity, axis=1)
    spin = np.sum(scene.bodies.inertia[:, :1] * run.omega, axis=1)
    angular = np.sum(np.cross(run.position, mass * run.velocity), axis=1) + spin
    assert np.ptp(momentum, axis=0).max() < 1e-13
    assert np.ptp(angular, axis=0).max() < 1e-13


def test_a_law_of_two_levers_is_a_feature_that_programs_must_name():
    numbers = {"law": "linear", "stiffness": 1.0, "branch": "slip-R"}
    assert "contact:two-levers" in Contact(**numbers, friction=0.1).features()
    assert "contact:two-levers" not in Contact(**numbers).features()
    one = Contact(law="linear", stiffness=1.0, friction=0.1, branch="R")
    assert "contact:two-levers" not in one.features()


def test_methods_with_one_lever_refuse_two():
    reason = ENGINE.unsupported_motion(
        collision(branch="slip-R").problem, ENGINE.method("oblique-contact")
    )
    assert reason == "friction whose slip and torque have different levers"
