"""Velocity Verlet and Runge-Kutta hold their order through springs, orbits and contacts, and keep
what they claim to keep.
"""

from itertools import pairwise

import numpy as np
import pytest

from refdem.core import discovery, symmetry
from refdem.core.balance import angular, linear, mechanical
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

ORDERS = {"velocity-verlet": 2, "rk4": 4}
ULP = 2.0**-53
HEAD_ON = {"damping": "6"}
RUBBING = {
    "damping": "1",
    "masses": "1,3",
    "radii": "1/2,4/5",
    "angle": "1/2",
    "friction": "0.3",
    "tangential_stiffness": "100",
}
SPINS = {"spins": "0,0,2,0,0,-5"}
COLLISIONS = {
    "elastic": {"damping": "0"},
    "damped, zero overlap": HEAD_ON,
    "damped, zero force": {**HEAD_ON, "cutoff": "zero_force"},
    "sliding": {"damping": "0", "angle": "1", "friction": "0.3"},
    "sliding, then rolling": {
        "damping": "1",
        "angle": "0.1",
        "friction": "0.3",
        "cutoff": "zero_force",
    },
    "stick and slip": {**RUBBING, **SPINS},
    "stick and slip, zero force, arm R": {**RUBBING, "cutoff": "zero_force", "branch": "R"},
}


def collision(**given: str) -> Scene:
    """Two spheres of the case `two-spheres`."""
    return discovery.case("two-spheres").at(**given).scene


def run(
    scene: Scene, method: str, duration: float, steps: int = 0, samples: int = 16
) -> Trajectory:
    """A run whose every interval is cut into `steps` steps; 0 for exact methods."""
    times = np.arange(samples + 1) * 2.0 ** np.ceil(np.log2(duration / samples))
    request = Request(
        problem=Motion(scene, times), method=method, step=times[1] / steps if steps else None
    )
    return ENGINE.run(request)[0]


def observed(
    scene: Scene, method: str, duration: float, exact: Trajectory, steps: tuple[int, ...]
) -> list[float]:
    """Orders from pair to pair of the largest error of any velocity or place."""
    errors = []
    for count in steps:
        seen = run(scene, method, duration, count)
        errors.append(
            max(
                np.abs(seen.position - exact.position).max(),
                np.abs(seen.velocity - exact.velocity).max(),
            )
        )
    return [float(np.log2(a / b)) for a, b in pairwise(errors)]


@pytest.mark.parametrize("method", ORDERS)
@pytest.mark.parametrize("given", COLLISIONS.values(), ids=COLLISIONS)
def test_order_is_that_of_smooth_motion_although_contact_ends_inside_a_step(method, given):
    scene = collision(**given)
    exact = run(scene, "contact-events", 0.4)
    assert {event.kind for event in exact.events} == {"release"}
    orders = observed(scene, method, 0.4, exact, (8, 16, 32, 64))
    assert min(orders) > ORDERS[method] - 0.2, orders


@pytest.mark.parametrize("method", ORDERS)
def test_order_holds_on_a_kepler_orbit(method):
    scene = Scene.of(
        [Body(mass=2.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.25, 0.0))],
        [CentralField(gm=1.0)],
    )
    exact = run(scene, "exact-kepler", 8.0)
    orders = observed(scene, method, 8.0, exact, (32, 64, 128))
    assert np.abs(np.array(orders) - ORDERS[method]).max() < 0.15


@pytest.mark.parametrize("method", ORDERS)
def test_order_holds_on_a_hanging_spring(method):
    scene = Scene.of(
        [Body(mass=1.0, position=(1.0, 0.5, 0.0))],
        [Spring(a=0, stiffness=4.0), UniformGravity(g=(0.0, -2.0, 0.0))],
    )
    exact = run(scene, "exact-harmonic", 8.0)
    orders = observed(scene, method, 8.0, exact, (8, 16, 32))
    assert np.abs(np.array(orders) - ORDERS[method]).max() < 0.15


@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
def test_verlet_keeps_second_order_with_springs_of_any_exponent(exponent):
    """v^2/2 + x^(n+1)/(n+1) is kept; from x = 1 the speed at the centre is sqrt(2/(n+1))."""
    scene = Scene.of(
        [Body(mass=1.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=1.0, exponent=exponent)]
    )
    swings = []
    for steps in (32, 64, 128):
        seen = run(scene, "velocity-verlet", 16.0, steps)
        swings.append(np.ptp(mechanical(scene, seen)))
    assert np.all(np.log2(np.array(swings[:-1]) / swings[1:]) > 1.8)


@pytest.mark.parametrize(
    ("method", "steps"), [("velocity-verlet", 8), ("velocity-verlet", 512), ("contact-events", 0)]
)
def test_total_angular_momentum_is_kept_in_an_oblique_collision_of_unequal_spinning_spheres(
    method, steps
):
    scene = collision(**RUBBING, **SPINS)
    seen = run(scene, method, 0.4, steps)
    total = angular(scene, seen)["total"]
    momentum = linear(scene, seen)
    assert np.abs(angular(scene, seen)["spin"] - angular(scene, seen)["spin"][0]).max() > 0.01
    assert np.abs(total - total[0]).max() < 24 * ULP * np.sqrt(max(steps, 1) * 16)
    assert np.abs(momentum - momentum[0]).max() < 8 * ULP * np.sqrt(max(steps, 1) * 16)


def test_the_arm_of_a_full_radius_changes_angular_momentum_because_arms_exceed_the_distance():
    scene = collision(**RUBBING, **SPINS, branch="R")
    total = angular(scene, run(scene, "contact-events", 0.4))["total"]
    assert np.abs(total[-1] - total[0]).max() > 1e-3


def test_runge_kutta_keeps_momentum_but_not_angular_momentum():
    scene = collision(**RUBBING, **SPINS)
    seen = run(scene, "rk4", 0.4, 8)
    assert np.abs(linear(scene, seen) - linear(scene, seen)[0]).max() < 100 * ULP
    total = angular(scene, seen)["total"]
    assert 1e-13 < np.abs(total - total[0]).max() < 1e-4


def there_and_back(scene: Scene, backward: bool, **clock: float) -> float:
    """Distance from the start after a run and its way back, by flipped velocities or by negative
    steps.
    """
    times = np.arange(17) * clock["interval"]
    out = ENGINE.run(
        Request(problem=Motion(scene, times), method="velocity-verlet", step=clock["step"])
    )[0]
    end = out.end()
    if backward:
        sign = 1.0
    else:
        sign = -1.0
    turned = scene.with_state(
        **{**end, "velocity": sign * end["velocity"], "omega": sign * end["omega"]}
    )
    back = Request(
        problem=Motion(turned, times[::-1].copy() if backward else times),
        method="velocity-verlet",
        step=clock["step"],
    )
    home = ENGINE.run(back)[0]
    start = scene.bodies
    return max(
        np.abs(home.position[-1] - start.position).max(),
        np.abs(sign * home.velocity[-1] - start.velocity).max(),
    )


@pytest.mark.parametrize("backward", [False, True])
def test_verlet_returns_through_an_elastic_collision_to_round_off(backward):
    """Both spheres must part and meet again inside a step of the way back."""
    assert there_and_back(collision(damping="0"), backward, interval=2.0**-5, step=2.0**-7) < 1e-13


@pytest.mark.parametrize("backward", [False, True])
def test_verlet_returns_from_a_spring_and_from_an_orbit_to_round_off(backward):
    spring = Scene.of(
        [Body(mass=1.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=1.0, exponent=3.0)]
    )
    orbit = Scene.of(
        [Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.2, 0.0))], [CentralField(gm=1.0)]
    )
    for scene in (spring, orbit):
        assert there_and_back(scene, backward, interval=0.5, step=2.0**-6) < 1e-13


def test_a_bouncing_ball_finds_the_ground_at_the_right_moment():
    """Dropped from h over the ground it touches at sqrt(2 h/g), whatever the step: free fall is
    exact in velocity Verlet.
    """
    ball = Body(mass=1.0, inertia=(0.1,) * 3, position=(0.0, 0.0, 1.5), shape=Sphere(radius=0.5))
    scene = Scene.of(
        [ball], [Plane(), UniformGravity(g=(0.0, 0.0, -8.0)), Contact(law="linear", stiffness=1e5)]
    )
    seen = run(scene, "velocity-verlet", 0.7, 4)
    touched = [event for event in seen.events if event.kind == "contact"]
    assert touched[0].time == pytest.approx(0.5, abs=1e-15)
    assert seen.channels["contacts"][0] == 0


@pytest.mark.parametrize("method", ["velocity-verlet", "rk4"])
def test_spheres_that_balance_exactly_rest_to_the_last_bit_over_a_million_steps(method):
    scene = discovery.case("newtons-first-law").at(member="spheres").scene
    seen = run(scene, method, 64.0, 2**16)
    assert np.array_equal(seen.position[-1], scene.bodies.position)
    assert not np.any(seen.velocity)


@pytest.mark.parametrize(
    ("cutoff", "method", "steps", "allowed"),
    [
        ("zero_overlap", "velocity-verlet", 2048, 1e-6),
        ("zero_force", "velocity-verlet", 2048, 1e-6),
        ("zero_overlap", "contact-events", 0, 1e-14),
        ("zero_force", "contact-events", 0, 1e-14),
    ],
)
def test_energy_lost_and_dissipated_work_balance_after_the_collision(
    cutoff, method, steps, allowed
):
    scene = collision(damping="6", cutoff=cutoff)
    seen = run(scene, method, 0.4, steps)
    balance = mechanical(scene, seen) + seen.channels["dissipated_work"]
    assert np.abs(balance - balance[0]).max() < allowed
    assert seen.channels["dissipated_work"][-1] > 0.05


def test_runge_kutta_refuses_springs_that_are_not_smooth():
    scene = Scene.of(
        [Body(mass=1.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=1.0, exponent=1.5)]
    )
    problem = Motion(scene, np.arange(3) * 0.5)
    assert ENGINE.unsupported_motion(problem, ENGINE.method("rk4"))
    assert ENGINE.unsupported_motion(problem, ENGINE.method("velocity-verlet")) is None


@pytest.mark.parametrize("method", ["velocity-verlet", "rk4"])
def test_a_steady_turn_keeps_the_quaternion_at_unit_length_over_many_steps(method: str) -> None:
    """The same turn rounds the same way at every step: without correction |q| drifts by up to an
    ulp a step.
    """
    body = Body(mass=1.0, inertia=(0.4, 0.4, 0.4), omega=(1.29363, 0.263766, -0.761473))
    request = Request(
        problem=Motion(Scene.of([body]), np.arange(65) / 4), method=method, step=2.0**-8
    )
    assert ENGINE.unsupported_motion(request.problem, ENGINE.method(method)) is None
    attitude = ENGINE.run(request)[0].attitude
    assert np.abs(np.linalg.norm(attitude, axis=-1) - 1).max() < 12 * ULP


@pytest.mark.parametrize("name", ["shifted", "rescaled"])
def test_a_spring_that_points_against_the_slip_of_a_plane_motion_stays_in_the_plane(name):
    """Rounding would turn it round, from where it is held as a pencil on its tip is."""
    given = {
        "radii": "0.7255859375,1.215087890625",
        "damping": "0.699951171875",
        "closing_speed": "0.39697265625",
        "friction": "0.75",
    }
    given |= {
        "tangential_stiffness": "38.39990234375",
        "angle": "0.008727",
        "spins": "0,0,1,0,0,-2",
        "branch": "R",
    }
    instance = discovery.case("two-spheres").at(**given)
    view, motion = symmetry.image(instance, name)
    step = instance.problem.interval / 16
    pairs = ((instance.problem, step), (motion, step * view.units[2]))
    plain, other = (
        ENGINE.run(Request(problem=problem, method="velocity-verlet", step=h))[0]
        for problem, h in pairs
    )
    assert np.abs(view.undone(other).velocity - plain.velocity).max() < 1e-13


@pytest.mark.parametrize("method", ["velocity-verlet", "rk4"])
def test_each_of_several_bodies_is_attracted_from_its_own_place(method):
    near = Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))
    far = Body(mass=2.0, position=(0.0, 3.0, 1.0), velocity=(0.5, 0.0, 0.0))
    field = CentralField(gm=1.25)
    together, *alone = (
        run(Scene.of(bodies, [field]), method, 2.0, 256) for bodies in ([near, far], [near], [far])
    )
    for number, single in enumerate(alone):
        assert np.abs(together.position[:, number] - single.position[:, 0]).max() < 1e-14
