"""What is fixed stays where it is to the last bit, whatever falls on it and pulls at it, in every method that takes the scene."""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

TIMES = np.linspace(0.0, 1.0, 9)
GRAVITY = UniformGravity(g=(0.25, 0.5, -8.0))
SOFT = Contact(law="linear", stiffness=512.0, damping=1.0)
ROUGH = Contact(law="linear", stiffness=512.0, damping=1.0, tangential_stiffness=64.0, friction=0.25)


def sphere(place, *, fixed):
    """A sphere of diameter 1 that spins where it may."""
    spin = (0.0, 0.0, 0.0) if fixed else (0.5, -0.25, 1.0)
    return Body(mass=2.0, inertia=(0.2, 0.2, 0.2), position=place, omega=spin, shape=Sphere(radius=0.5), fixed=fixed)


PAIR = [sphere((0.125, 0.0, 1.25), fixed=False), sphere((0.0, 0.0, 0.0), fixed=True)]
POINTS = [Body(mass=1.0, position=(1.0, 0.0, 0.0)), Body(mass=3.0, position=(0.0, 0.0, 0.5), fixed=True)]
SCENES = {
    "a smooth contact": (Scene.of(PAIR, [SOFT, GRAVITY]), {"velocity-verlet", "rk4", "contact-events"}),
    "a rough contact": (Scene.of(PAIR, [ROUGH, GRAVITY]), {"velocity-verlet", "rk4", "contact-events"}),
    "a spring": (Scene.of(POINTS, [Spring(a=0, b=1, stiffness=16.0, length=0.5), GRAVITY]), {"velocity-verlet", "rk4"}),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_fixed_body_does_not_move_and_the_other_does(name):
    scene, expected = SCENES[name]
    problem = Motion(scene, TIMES)
    methods = [method for method in ENGINE.methods if ENGINE.refusal(problem, method) is None]
    assert {method.name for method in methods} >= expected
    for method in methods:
        step = 1 / 1024 if method.control == "step" else None
        run, _ = ENGINE.run(Request(problem=problem, method=method.name, step=step))
        for column in ("position", "velocity", "attitude", "omega"):
            start = getattr(scene.bodies, column)[1]
            assert np.array_equal(getattr(run, column)[:, 1], np.tile(start, (len(TIMES), 1))), f"{method.name}: {column}"
        assert np.ptp(run.position[:, 0], axis=0).min() > 1e-3, method.name
