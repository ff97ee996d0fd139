"""Bodies that do not feel each other: a fixed one stays to the last bit, and of many in one field
each moves as if alone.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers._particles import pairs

TIMES = np.linspace(0.0, 1.0, 9)
GRAVITY = UniformGravity(g=(0.25, 0.5, -8.0))
SOFT = Contact(law="linear", stiffness=512.0, damping=1.0)
ROUGH = Contact(
    law="linear", stiffness=512.0, damping=1.0, tangential_stiffness=64.0, friction=0.25
)


def sphere(place, *, fixed):
    """A sphere of diameter 1 that spins where it may."""
    if fixed:
        spin = (0.0, 0.0, 0.0)
    else:
        spin = (0.5, -0.25, 1.0)
    return Body(
        mass=2.0,
        inertia=(0.2, 0.2, 0.2),
        position=place,
        omega=spin,
        shape=Sphere(radius=0.5),
        fixed=fixed,
    )


PAIR = [sphere((0.125, 0.0, 1.25), fixed=False), sphere((0.0, 0.0, 0.0), fixed=True)]
POINTS = [
    Body(mass=1.0, position=(1.0, 0.0, 0.0)),
    Body(mass=3.0, position=(0.0, 0.0, 0.5), fixed=True),
]
SCENES = {
    "a smooth contact": (
        Scene.of(PAIR, [SOFT, GRAVITY]),
        {"velocity-verlet", "rk4", "contact-events"},
    ),
    "a rough contact": (
        Scene.of(PAIR, [ROUGH, GRAVITY]),
        {"velocity-verlet", "rk4", "contact-events"},
    ),
    "a spring": (
        Scene.of(POINTS, [Spring(a=0, b=1, stiffness=16.0, length=0.5), GRAVITY]),
        {"velocity-verlet", "rk4"},
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_fixed_body_does_not_move_and_the_other_does(name):
    scene, expected = SCENES[name]
    problem = Motion(scene, TIMES)
    methods = [
        method for method in ENGINE.methods if ENGINE.unsupported_motion(problem, method) is None
    ]
    assert {method.name for method in methods} >= expected
    for method in methods:
        if method.control == "step":
            step = 1 / 1024
        else:
            step = None
        run, _ = ENGINE.run(Request(problem=problem, method=method.name, step=step))
        for column in ("position", "velocity", "attitude", "omega"):
            start = getattr(scene.bodies, column)[1]
            assert np.array_equal(getattr(run, column)[:, 1], np.tile(start, (len(TIMES), 1))), (
                f"{method.name}: {column}"
            )
        assert np.ptp(run.position[:, 0], axis=0).min() > 1e-3, method.name


def test_points_in_one_central_field_move_as_each_does_alone():
    points = [
        Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.25)),
        Body(mass=2.0, position=(0.0, -2.0, 0.5), velocity=(0.5, 0.0, 0.25)),
        Body(mass=3.0, position=(0.0, 0.25, 4.0), velocity=(0.5, 0.125, 0.0)),
    ]
    field = CentralField(gm=1.0)
    together = Motion(Scene.of(points, [field]), TIMES)
    methods = [
        method
        for method in ENGINE.methods
        if ENGINE.unsupported_motion(together, method) is None and method.control == "step"
    ]
    assert {method.name for method in methods} >= {"velocity-verlet", "rk4"}
    for method in methods:
        run, _ = ENGINE.run(Request(problem=together, method=method.name, step=1 / 64))
        for number, point in enumerate(points):
            alone, _ = ENGINE.run(
                Request(
                    problem=Motion(Scene.of([point], [field]), TIMES),
                    method=method.name,
                    step=1 / 64,
                )
            )
            assert np.array_equal(run.position[:, number], alone.position[:, 0]), method.name


def test_pairs_are_of_what_moves_with_what_stands_and_of_no_two_that_stand():
    spheres = [sphere((2.0 * number, 0.0, 0.0), fixed=number != 1) for number in range(3)]
    found = pairs(Scene.of(spheres, [SOFT, Plane()]))
    assert found.tolist() == [[0, 1], [1, 2], [1, -1]]
