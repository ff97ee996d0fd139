"""The exact method of a sphere that slides and rolls: against truth, in any plane, and what it
refuses.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.mechanics.quaternion import rotated
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers.exact_rolling import METHOD

CASE = discovery.case("rolling")
U = 2.0**-53
GIVEN = [
    {},
    {"spin": "20", "inertia_factor": "1"},
    {"spin": "-8"},
    {"slope": "3/4", "speed": "-2"},
    {"slope": "7/8"},
    {"slope": "7/8", "speed": "0"},
    {"slope": "1", "speed": "0"},
    {"slope": "2", "speed": "-4"},
    {"friction": "0", "slope": "1/2"},
    {"radius": "1/10", "speed": "0.3", "spin": "-3"},
]


def ran(problem):
    assert METHOD.unsupported(problem) is None
    return METHOD.run(Request(problem=problem, method="exact-rolling", step=None))[0]


@pytest.mark.parametrize("given", GIVEN, ids=str)
def test_it_is_the_truth_to_round_off(given):
    instance = CASE.at(**given)
    truth = instance.truth()
    run = ran(instance.problem)
    seen = instance.observe(run)
    for k, t in enumerate(instance.times):
        told = truth.at(Fraction(float(t)))
        allowed = 100 * U * truth.sensitivity(Fraction(float(t)))
        for name, quantity in instance.quantities.items():
            assert abs(seen[name][k] - float(told[name].mid)) <= allowed * quantity.scale
    scalars = truth.scalars()
    if "friction_work" in scalars:
        work = float(scalars["friction_work"].mid)
        assert abs(run.channels["dissipated_work"][-1] - work) <= 100 * U * work
    times = [event.time for event in run.events]
    assert len(times) == ("roll_time" in scalars)
    for time in times:
        assert abs(time - float(scalars["roll_time"].mid)) <= 100 * U * instance.times[-1]


def test_its_attitude_turns_by_the_way_while_it_rolls():
    """R omega = -v: the angle is the way over the radius, backwards about z."""
    instance = CASE.at(spin="-8", slope="1/2")
    run = ran(instance.problem)
    angle = -run.position[:, 0, 0] / 0.5
    expected = np.stack([np.cos(angle / 2), np.sin(angle / 2)], axis=1)
    seen = run.attitude[:, 0, [0, 3]]
    assert np.allclose(seen, expected, rtol=0, atol=1e-13)
    assert not run.attitude[:, 0, 1:3].any()


@pytest.mark.parametrize("seed", range(6))
def test_it_is_the_same_in_a_plane_of_any_direction(seed):
    rng = np.random.default_rng(seed)
    turn = rng.normal(size=4)
    turn /= np.linalg.norm(turn)
    instance = CASE.at(slope=("0", "3/4", "2")[seed % 3], speed="-2", spin="5")
    scene = instance.scene
    bodies = scene.bodies
    body = Body(
        mass=1.0,
        inertia=tuple(bodies.inertia[0].tolist()),
        shape=Sphere(radius=0.5),
        position=tuple(rotated(turn, bodies.position[0]).tolist()),
        velocity=tuple(rotated(turn, bodies.velocity[0]).tolist()),
        omega=tuple(rotated(turn, bodies.omega[0]).tolist()),
    )
    normal = rotated(turn, np.array([0.0, 1.0, 0.0]))
    g = rotated(turn, np.array(scene.all(UniformGravity)[0].g))
    elements = [
        Contact(law="rigid", friction=0.25),
        Plane(normal=tuple((normal / np.linalg.norm(normal)).tolist())),
        UniformGravity(g=tuple(g.tolist())),
    ]
    turned = ran(Motion(Scene.of([body], elements), instance.times))
    plain = ran(instance.problem)
    for name in ("position", "velocity", "omega"):
        expected = rotated(turn, getattr(plain, name)[:, 0])
        size = max(1.0, float(np.abs(expected).max()))
        # A rotation is rounded a few times, and what follows from it grows with S.
        assert np.abs(getattr(turned, name)[:, 0] - expected).max() <= 1e-12 * size


def lying(**more):
    """A sphere on the plane z = 0, with other numbers."""
    law = more.pop("law", Contact(law="rigid", friction=0.25))
    g = more.pop("g", (0.0, 0.0, -10.0))
    inertia = more.pop("inertia", (0.1, 0.1, 0.1))
    position = more.pop("position", (0.0, 0.0, 0.5))
    body = Body(mass=1.0, inertia=inertia, shape=Sphere(radius=0.5), position=position, **more)
    elements = [law, Plane(), UniformGravity(g=g)]
    return Motion(Scene.of([body], elements), np.linspace(0.0, 1.0, 5))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"velocity": (1.0, 0.0, 0.0), "omega": (3.0, 0.0, 0.0)}, "another axis"),
        ({"velocity": (1.0, 0.0, 0.0), "omega": (0.0, 0.0, 3.0)}, "another axis"),
        ({"velocity": (1.0, 0.0, 0.0), "g": (0.0, 1.0, -10.0)}, "leaves the line"),
        ({"velocity": (1.0, 0.0, -1.0)}, "towards the plane"),
        ({"velocity": (1.0, 0.0, 0.0), "position": (0.0, 0.0, 0.6)}, "does not touch"),
        ({"velocity": (1.0, 0.0, 0.0), "g": (0.0, 0.0, 10.0)}, "does not press"),
        ({"velocity": (1.0, 0.0, 0.0), "inertia": (0.1, 0.2, 0.1)}, "moments of inertia differ"),
        ({"velocity": (1.0, 0.0, 0.0), "inertia": (0.0, 0.0, 0.0)}, "inertia"),
    ],
)
def test_what_does_not_stay_on_a_line_is_refused(given, words):
    assert words in str(METHOD.unsupported(lying(**given)))


def test_time_does_not_run_backwards():
    problem = lying(velocity=(1.0, 0.0, 0.0))
    backwards = Motion(problem.scene, problem.times[::-1].copy())
    assert "backwards" in str(METHOD.unsupported(backwards))


def test_it_slides_down_and_rolls_along_any_line_of_a_level_plane():
    run = ran(lying(velocity=(0.6, 0.8, 0.0)))
    assert np.allclose(run.velocity[-1, 0], (0.6 * 5 / 7, 0.8 * 5 / 7, 0.0), rtol=1e-14, atol=0)
    # v = omega x R n.
    rolled = 0.5 * np.cross(run.omega[-1, 0], (0.0, 0.0, 1.0))
    assert np.allclose(rolled, run.velocity[-1, 0], rtol=1e-14, atol=1e-15)
