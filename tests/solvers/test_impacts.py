"""The event-driven method for rigid spheres: against truth, against a plain twin in numpy, and what
no impact may change.
"""

from itertools import combinations

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import angular, kinetic, linear
from refdem.core.problem import Motion, Request
from refdem.errors import EngineError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import impacts
from refdem.solvers.impacts import METHOD

U = 2.0**-53


def sphere(**more):
    radius = more.pop("radius", 0.5)
    mass = more.pop("mass", 1.0)
    moment = more.pop("factor", 0.4) * mass * radius**2
    shape = Sphere(radius=radius)
    return Body(mass=mass, inertia=(moment, moment, moment), shape=shape, **more)


def run(scene, times):
    problem = Motion(scene, np.asarray(times, float))
    assert METHOD.unsupported(problem) is None
    return METHOD.run(Request(problem=problem, method="impacts", step=None))[0]


def crowd(seed, *, walls, count=8, **law):
    """Spheres of many sizes on a lattice, so that they start apart, with spins; in a box or not."""
    rng = np.random.default_rng(seed)
    bodies = []
    for k in range(count):
        place = 2.0 * np.array([k % 2, k // 2 % 2, k // 4], float) - [1.0, 1.0, count / 8]
        if walls:
            velocity = rng.normal(size=3)
        else:
            velocity = -place + 0.2 * rng.normal(size=3)
        body = sphere(
            mass=float(rng.uniform(0.5, 2)),
            radius=float(rng.uniform(0.5, 0.9)),
            factor=float(rng.uniform(0.2, 0.6)),
            position=tuple(place.tolist()),
            velocity=tuple(velocity.tolist()),
            omega=tuple(rng.normal(size=3).tolist()),
        )
        bodies.append(body)
    elements = [Contact(law="rigid", **law)]
    if walls:
        for axis in range(3):
            for side in (-1.0, 1.0):
                normal = [0.0, 0.0, 0.0]
                normal[axis] = -side
                point = [0.0, 0.0, 0.0]
                point[axis] = 4.0 * side
                elements.append(Plane(point=tuple(point), normal=tuple(normal)))
    return Scene.of(bodies, elements)


def twin(scene, end):
    """The same motion by all pairs at every event, each as its quadratic's root by numpy.roots, and
    each impact as a linear system for what it changes; returns the state at the end and the number
    of impacts.
    """
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    planes = [(np.array(p.point), np.array(p.normal)) for p in scene.all(Plane)]
    r, v, omega = (np.array(x) for x in (bodies.position, bodies.velocity, bodies.omega))
    now = 0.0
    for count in range(10_000):
        due = []
        for i, j in combinations(range(len(bodies)), 2):
            d, w = r[j] - r[i], v[j] - v[i]
            reach = bodies.radius[i] + bodies.radius[j]
            if d @ w < -1e-12:
                roots = np.roots([w @ w, 2 * d @ w, d @ d - reach**2])
                if np.all(np.isreal(roots)):
                    due.append((max(0.0, float(min(roots.real))), i, j))
        for i in range(len(bodies)):
            for k, (point, normal) in enumerate(planes):
                if v[i] @ normal < -1e-12:
                    height = (r[i] - point) @ normal - bodies.radius[i]
                    due.append((max(0.0, height / -(v[i] @ normal)), i, -1 - k))
        when, i, j = min(due, default=(np.inf, 0, 0))
        if now + when > end:
            return r + v * (end - now), v, omega, count
        r += v * when
        now += when
        strike(bodies, law, v, omega, i, j, r, planes)
    raise AssertionError("too many impacts")


def strike(bodies, law, v, omega, i, j, r, planes):
    """The impulse that gives the asked velocity of contact, from the 3 x 3 matrix that maps one to
    the other; cut at the cone.
    """
    if j < 0:
        normal = -planes[-1 - j][1]
    else:
        normal = (r[j] - r[i]) / np.linalg.norm(r[j] - r[i])
    met = [(i, 1.0)] + ([(j, -1.0)] if j >= 0 else [])
    matrix = np.zeros((3, 3))
    speed = np.zeros(3)
    for body, side in met:
        lever = side * bodies.radius[body] * normal
        turn = np.array(
            [[0, -lever[2], lever[1]], [lever[2], 0, -lever[0]], [-lever[1], lever[0], 0]]
        )
        matrix += np.eye(3) / bodies.mass[body] - turn @ turn / bodies.inertia[body, 0]
        speed += side * (v[body] + np.cross(omega[body], lever))
    along = speed @ normal
    slip = speed - along * normal
    asked = -law.restitution * along * normal - law.slip_restitution * slip
    impulse = np.linalg.solve(matrix, asked - speed)
    pressing = -(impulse @ normal)
    rubbing = impulse + pressing * normal
    size = np.linalg.norm(rubbing)
    if size > law.friction * pressing:
        impulse = -pressing * normal + rubbing * (law.friction * pressing / size)
    for body, side in met:
        lever = side * bodies.radius[body] * normal
        v[body] += side * impulse / bodies.mass[body]
        omega[body] += np.cross(lever, side * impulse) / bodies.inertia[body, 0]


@pytest.mark.parametrize("walls", [False, True])
@pytest.mark.parametrize(
    "law",
    [
        {"restitution": 1.0},
        {"restitution": 0.8, "friction": 0.2},
        {"restitution": 0.5, "friction": 50.0, "tangential_restitution": 0.7},
    ],
)
def test_many_impacts_are_those_of_a_plain_twin(walls, law):
    """A tolerance: every impact of convex bodies multiplies errors, here by less than 100 in all of
    the two seconds, and the twin's roots lose half of their digits where spheres all but graze.
    """
    for seed in range(3):
        scene = crowd(seed, walls=walls, **law)
        trajectory = run(scene, np.linspace(0.0, 2.0, 9))
        r, v, omega, count = twin(scene, 2.0)
        assert len(trajectory.events) == count >= 3
        assert np.abs(trajectory.position[-1] - r).max() < 1e-8
        assert np.abs(trajectory.velocity[-1] - v).max() < 1e-8
        assert np.abs(trajectory.omega[-1] - omega).max() < 1e-8


@pytest.mark.parametrize("law", [{"restitution": 1.0}, {"restitution": 0.7, "friction": 0.3}])
def test_momentum_and_angular_momentum_stay_whatever_meets(law):
    scene = crowd(5, walls=False, count=27, **law)
    trajectory = run(scene, np.linspace(0.0, 8.0, 33))
    assert len(trajectory.events) > 10
    momentum = linear(scene, trajectory)
    total = angular(scene, trajectory)["total"]
    # Ten roundings an impact at least are allowed to each of the bodies that met.
    room = 100 * U * len(trajectory.events)
    assert np.abs(momentum - momentum[0]).max() < room * 27
    assert np.abs(total - total[0]).max() < room * 27 * 8


def test_what_is_lost_is_what_the_run_says():
    scene = crowd(6, walls=True, restitution=0.7, friction=0.3)
    trajectory = run(scene, np.linspace(0.0, 5.0, 33))
    energy = kinetic(scene, trajectory)
    work = trajectory.channels["dissipated_work"]
    assert work[-1] > 0.1 * energy[0]
    assert np.all(np.diff(work) >= 0)
    assert np.abs(energy + work - energy[0]).max() < 1e-12 * energy[0]


def test_elastic_spheres_in_a_box_keep_their_energy_over_many_impacts():
    scene = crowd(7, walls=True, restitution=1.0)
    trajectory = run(scene, np.linspace(0.0, 2000.0, 9))
    energy = kinetic(scene, trajectory)
    count = len(trajectory.events)
    assert count > 5000
    assert np.abs(energy / energy[0] - 1).max() < 10 * U * count


@pytest.mark.parametrize("given", [{}, {"friction": "1/4", "spins": "1,2,3,-1,1/2,4"}])
def test_an_impact_agrees_with_truth_wherever_the_origin_is(given):
    instance = discovery.case("hard-spheres").at(**given)
    shift = np.array([3.0, -5.0, 2.0])
    scene = instance.scene.with_state(position=instance.scene.bodies.position + shift)
    first = run(instance.scene, instance.times)
    moved = run(scene, instance.times)
    assert np.abs(first.velocity - moved.velocity).max() < 1e-13
    assert len(first.events) == len(moved.events) == 1


def test_without_restitution_a_head_on_pair_goes_on_together_and_meets_once():
    """The rounded speed at which they then seem to close is no impact."""
    for speed in (1.0, 1 / 3, 0.1, 7e-5, 1e3):
        for mass in (1.0, 3.0, 1e6):
            pair = [
                sphere(mass=mass, position=(-2.0, 0.3, 0.1), velocity=(speed, 0.0, 0.0)),
                sphere(position=(2.0, 0.3, 0.1), velocity=(-speed, 0.0, 0.0)),
            ]
            scene = Scene.of(pair, [Contact(law="rigid")])
            trajectory = run(scene, np.linspace(0.0, 8 / speed, 17))
            assert len(trajectory.events) == 1
            apart = trajectory.velocity[-1, 0] - trajectory.velocity[-1, 1]
            assert np.abs(apart).max() < 1e-14 * speed


def test_a_ball_between_fixed_ones_and_a_wall_bounces_for_ever():
    bodies = [
        sphere(position=(0.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0)),
        sphere(position=(3.0, 0.0, 0.0), fixed=True),
    ]
    wall = Plane(point=(-2.5, 0.0, 0.0), normal=(1.0, 0.0, 0.0))
    scene = Scene.of(bodies, [Contact(law="rigid", restitution=1.0), wall])
    trajectory = run(scene, np.arange(0.0, 81.0))
    # From -2 to 2 and back in 8 s.
    assert [event.time for event in trajectory.events] == list(np.arange(2.0, 81.0, 4.0))
    expected = 2 - np.abs(np.mod(trajectory.t + 2, 8) - 4)
    assert np.abs(trajectory.position[:, 0, 0] - expected).max() < 1e-13
    assert np.all(trajectory.position[:, 1] == [3.0, 0.0, 0.0])


def test_a_spinning_ball_turns_between_impacts_as_a_free_body_does():
    body = sphere(omega=(0.3, -0.4, 1.2), velocity=(0.1, 0.0, 0.0))
    scene = Scene.of([body], [Contact(law="rigid")])
    trajectory = run(scene, np.linspace(0.0, 10.0, 11))
    angle = 1.3 * trajectory.t / 2
    axis = np.array([0.3, -0.4, 1.2]) / 1.3
    expected = np.column_stack([np.cos(angle), np.sin(angle)[:, None] * axis])
    assert np.abs(trajectory.attitude[:, 0] - expected).max() < 1e-14


TWO = [sphere(position=(-2.0, 0.0, 0.0)), sphere(position=(2.0, 0.0, 0.0))]
LAW = Contact(law="rigid", friction=0.5)


@pytest.mark.parametrize(
    ("bodies", "elements", "word"),
    [
        (
            [sphere(fixed=True, position=(9.0, 0.0, 0.0)), TWO[0]],
            [LAW, UniformGravity(g=(0.0, -1.0, 0.0))],
            "no quadratic",
        ),
        (TWO, [Contact(law="linear", stiffness=1.0)], "linear"),
        ([TWO[0], Body(mass=1.0)], [LAW], "no sphere"),
        ([TWO[0], sphere(position=(-1.5, 0.0, 0.0))], [LAW], "overlaps"),
        (TWO, [LAW, Plane(point=(1.9, 0.0, 0.0), normal=(1.0, 0.0, 0.0))], "behind a plane"),
        ([TWO[0], Body(mass=1.0, shape=Sphere(radius=0.5))], [LAW], "moments of inertia"),
        (
            [Body(mass=1.0, shape=Sphere(radius=0.5), inertia=(1.0, 1.0, 1.5))],
            [LAW],
            "not constant",
        ),
        (
            [sphere(fixed=True, velocity=(1.0, 0.0, 0.0)), TWO[0]],
            [LAW],
            "fixed, and moves",
        ),
    ],
)
def test_what_it_cannot_do_is_refused_with_the_reason(bodies, elements, word):
    problem = Motion(Scene.of(bodies, elements), np.array([0.0, 1.0]))
    assert word in METHOD.unsupported(problem)


def test_backwards_is_refused():
    problem = Motion(Scene.of(TWO, [LAW]), np.array([0.0, -1.0]))
    assert "backwards" in METHOD.unsupported(problem)


def test_impacts_without_end_are_an_error_not_a_hang(monkeypatch):
    monkeypatch.setattr(impacts, "LONGEST", 50)
    scene = crowd(7, walls=True, restitution=1.0)
    with pytest.raises(EngineError, match="50 impacts did not lead to"):
        run(scene, np.linspace(0.0, 2000.0, 3))


def test_an_impact_is_as_exact_whenever_it_happens():
    """Times are counted from the start, which may be late: 2^30 s is a whole number of ulps."""
    instance = discovery.case("hard-spheres").at(friction="1/4", spins="1,2,3,-1,1/2,4")
    first = run(instance.scene, np.arange(0.0, 5.0))
    later = run(instance.scene, 2.0**30 + np.arange(0.0, 5.0))
    assert np.array_equal(first.position, later.position)
    assert np.array_equal(first.velocity, later.velocity)
    assert later.events[0].time == pytest.approx(2.0**30 + first.events[0].time)


@pytest.mark.parametrize("unit", [2.0**-400, 2.0**-100, 2.0**100, 2.0**300])
def test_an_impact_is_as_exact_in_any_unit_of_length(unit):
    """Powers of two change no digit, unless a product of lengths leaves the range of numbers."""
    scene = discovery.case("hard-spheres").at(friction="1/4").scene
    bodies = scene.bodies
    scaled = [
        sphere(
            radius=float(bodies.radius[k] * unit),
            position=tuple((bodies.position[k] * unit).tolist()),
            velocity=tuple((bodies.velocity[k] * unit).tolist()),
        )
        for k in (0, 1)
    ]
    plain = run(scene, np.arange(0.0, 5.0))
    found = run(Scene.of(scaled, scene.elements), np.arange(0.0, 5.0))
    assert len(found.events) == 1
    assert np.abs(found.position / unit - plain.position).max() < 1e-13
    assert np.abs(found.omega - plain.omega).max() < 1e-13


def test_spheres_that_fall_together_meet_as_without_gravity():
    times = np.linspace(0.0, 2.0, 33)
    bodies = [
        sphere(position=(-1.0, 0.25, 0.0), velocity=(1.0, 0.0, 0.0)),
        sphere(position=(1.0, 0.0, 0.0), mass=3.0),
    ]
    free = run(Scene.of(bodies, [Contact(law="rigid", restitution=0.5)]), times)
    g = np.array([0.5, -9.8125, 0.25])
    gravity = UniformGravity(g=tuple(g.tolist()))
    fallen = run(Scene.of(bodies, [Contact(law="rigid", restitution=0.5), gravity]), times)
    assert len(free.events) == len(fallen.events) == 1
    depth = times[:, None, None] ** 2 / 2 * g
    assert fallen.position - depth == pytest.approx(free.position, abs=64 * U * 40)
    assert fallen.velocity - times[:, None, None] * g == pytest.approx(
        free.velocity, abs=64 * U * 40
    )


@pytest.mark.parametrize("upwards", [0.0, 2.0, -3.0])
def test_a_sphere_falls_on_a_plane_and_bounces_by_the_formula(upwards):
    g = 8.0
    height = 1.0
    body = sphere(position=(0.0, 0.5 + height, 0.0), velocity=(1.0, upwards, 0.0))
    elements = [
        Contact(law="rigid", restitution=0.5),
        Plane(normal=(0.0, 1.0, 0.0)),
        UniformGravity(g=(0.0, -g, 0.0)),
    ]
    # They end at 1.5 s, 1.9 s and 1.5 s.
    ended = run(Scene.of([body], elements), np.linspace(0.0, 1.375, 9))
    speed = np.sqrt(upwards**2 + 2 * g * height)
    first = (upwards + speed) / g
    # Each flight lasts 2 e^n v/g.
    due = first + np.append(0.0, np.cumsum(2 * speed / g * 0.5 ** np.arange(1, 20)))
    seen = np.array([event.time for event in ended.events])
    assert len(seen) >= 2
    assert seen == pytest.approx(due[: len(seen)], abs=64 * U * 2)
    assert np.all(ended.position[:, 0, 1] >= 0.5 - 64 * U)


def test_gravity_away_from_a_plane_may_turn_a_sphere_before_it():
    for speed, count in ((3.9, 0), (4.1, 1)):
        # It comes 4^2/(2 g) = 1 m near with 4 m/s.
        body = sphere(position=(0.0, 1.5, 0.0), velocity=(0.0, -speed, 0.0))
        elements = [
            Contact(law="rigid", restitution=1.0),
            Plane(normal=(0.0, 1.0, 0.0)),
            UniformGravity(g=(0.0, 8.0, 0.0)),
        ]
        assert len(run(Scene.of([body], elements), np.linspace(0.0, 2.0, 5)).events) == count
