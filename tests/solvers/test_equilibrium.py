"""Equilibrium takes scenes that certainly stay at rest, and refuses every one that does not."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

METHOD = ENGINE.method("equilibrium")
TIMES = np.arange(5) * 0.5


def unsupported(bodies: list[Body], *elements) -> str | None:
    """What the method says to a scene."""
    return ENGINE.unsupported_motion(Motion(Scene.of(bodies, elements), TIMES), METHOD)


def block(x: float, z: float, **more) -> Body:
    """A cube of side 1."""
    return Body(
        mass=1.0, inertia=(1 / 6,) * 3, position=(x, 0.0, z), shape=box(1.0, 1.0, 1.0), **more
    )


def stacked(*bodies: Body, friction: float = 0.5) -> str | None:
    """What it says to bodies on level ground under the rigid law."""
    return unsupported(
        list(bodies),
        Plane(),
        UniformGravity(g=(0.0, 0.0, -9.8)),
        Contact(law="rigid", friction=friction),
    )


def on_slope(friction: float) -> str | None:
    """What it says to a cube on a 3-4-5 slope: the plane is level, gravity is turned."""
    return unsupported(
        [block(0.0, 0.5)],
        Plane(),
        UniformGravity(g=(4.8, 0.0, -6.4)),
        Contact(law="rigid", friction=friction),
    )


@pytest.mark.parametrize("member", ["block", "stack", "spheres"])
def test_members_at_rest_stay_to_the_last_bit(member):
    problem = discovery.case("newtons-first-law").at(member=member).problem
    assert ENGINE.best(problem).name == "equilibrium"
    seen, _ = ENGINE.run(Request(problem=problem, method="equilibrium"))
    assert np.all(seen.position == problem.scene.bodies.position)
    assert not np.any(seen.velocity)


def test_a_tower_stands_while_what_is_above_each_foot_is_over_it():
    """Harmonic overhang of unit cubes, from the top: 1/2, 1/4 (closed at the edge); a little more
    falls.
    """
    assert stacked(block(0.0, 0.5), block(0.25, 1.5), block(0.75, 2.5)) is None
    assert stacked(block(0.0, 0.5), block(0.25, 1.5), block(0.76, 2.5)) is not None
    assert "centre of mass" in stacked(block(0.0, 0.5), block(0.26, 1.5), block(0.76, 2.5))


def test_a_block_in_the_air_or_in_the_ground_does_not_stand():
    assert "stand" in stacked(block(0.0, 0.75))
    assert "stand" in stacked(block(0.0, 0.25))


def test_static_friction_holds_on_a_slope_of_three_in_four_from_three_quarters_on():
    assert on_slope(0.75) is None
    assert on_slope(0.8) is None
    assert "friction" in on_slope(0.7499)


def test_a_tall_block_topples_on_a_slope_that_friction_would_hold():
    tall = Body(
        mass=1.0, inertia=(1.0, 1.0, 0.1), position=(0.0, 0.0, 2.0), shape=box(1.0, 1.0, 4.0)
    )
    said = unsupported(
        [tall], Plane(), UniformGravity(g=(4.8, 0.0, -6.4)), Contact(law="rigid", friction=1.0)
    )
    assert "centre of mass" in said


def test_a_sphere_stands_on_level_ground_and_rolls_on_a_slope():
    ball = Body(mass=1.0, inertia=(0.1,) * 3, position=(0.0, 0.0, 0.5), shape=Sphere(radius=0.5))
    assert stacked(ball) is None
    assert "centre of mass" in unsupported(
        [ball], Plane(), UniformGravity(g=(0.6, 0.0, -8.0)), Contact(law="rigid", friction=1.0)
    )


def test_a_sphere_pressed_by_less_than_its_weight_is_not_in_balance():
    weight = 8.0
    laws = Plane(), UniformGravity(g=(0.0, 0.0, -weight)), Contact(law="linear", stiffness=1024.0)

    def said(overlap: float) -> str | None:
        return unsupported(
            [
                Body(
                    mass=1.0,
                    inertia=(0.1,) * 3,
                    position=(0.0, 0.0, 0.5 - overlap),
                    shape=Sphere(radius=0.5),
                )
            ],
            *laws,
        )

    assert said(weight / 1024.0) is None
    assert "add up" in said(0.99 * weight / 1024.0)
    assert "add up" in said(0.0)


def test_a_hanging_spring_rests_at_its_stretched_length_only():
    def said(depth: float) -> str | None:
        hanging = Body(mass=1.0, position=(0.0, -depth, 0.0))
        return unsupported(
            [hanging], Spring(a=0, stiffness=4.0, length=1.0), UniformGravity(g=(0.0, -8.0, 0.0))
        )

    assert said(3.0) is None
    assert "add up" in said(3.0001)


def test_what_moves_is_refused():
    assert "moves" in unsupported([Body(mass=1.0, velocity=(0.0, 1.0, 0.0))])
    assert unsupported([Body(mass=1.0)]) is None
