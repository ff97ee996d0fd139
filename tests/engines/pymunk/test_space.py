"""The space that a scene becomes, and what a body that never turns keeps."""

import numpy as np
import pytest

from refdem.core.static_problems import Polygon
from refdem.engines.pymunk.space import space_of
from refdem.engines.pymunk.statics import _is_convex
from refdem.scene import Body, Scene, Sphere
from refdem.scene.element import Element
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

ROD = Rod(a=0, length=1.0)
SPRINGS = [Spring(a=0, stiffness=1.0), Spring(a=0, b=1, stiffness=1.0), Spring(a=1, stiffness=2.0)]
RIGID = [Contact(law="rigid", restitution=0.5), Plane(normal=(0.0, 1.0, 0.0), point=(0, -9, 0))]


@pytest.mark.parametrize(
    ("elements", "iterations"),
    [
        ([], 1),
        (SPRINGS, 1),
        ([ROD], 1),
        ([ROD, *SPRINGS], 1),
        ([Slider(a=0, friction=0.5, normal_force=1.0)], 1),
        ([ROD, Rod(a=1, length=1.0)], 1),
        ([ROD, Rod(a=1, length=1.0), *SPRINGS], 1),
        ([ROD, Rod(a=1, b=0, length=2.0)], 200),
        ([Rod(a=1, b=0, length=2.0)], 1),
        ([ROD, Slider(a=0, friction=0.5, normal_force=1.0)], 200),
        (RIGID, 200),
        ([*RIGID, ROD], 200),
        ([Contact(law="linear", stiffness=3.0)], 1),
    ],
)
def test_joints_apart_are_solved_in_one_pass_and_what_is_coupled_in_many(
    elements: list[Element], iterations: int
) -> None:
    """A spring is a force, and a soft contact is a spring."""
    bodies = [
        Body(
            mass=1.0,
            inertia=(0.4, 0.4, 0.4),
            position=(1.0 + 2.0 * n, 0.0, 0.0),
            shape=Sphere(radius=0.5),
        )
        for n in range(2)
    ]
    space, *_ = space_of(Scene.of(bodies, elements))
    assert space.iterations == iterations
    shipped, *_ = space_of(Scene.of(bodies, elements), is_tuned=False)
    assert shipped.iterations == 10


def test_links_between_bodies_that_do_not_move_are_left_out() -> None:
    """A link to the world counts as one to a fixed body."""
    bodies = [Body(mass=1.0, position=(1.0 + n, 0.0, 0.0), fixed=n != 1) for n in range(3)]
    links = [
        Spring(a=0, b=2, stiffness=1.0),
        Spring(a=2, stiffness=1.0),
        Spring(a=0, b=1, stiffness=2.0),
        Spring(a=1, b=2, stiffness=3.0),
        Spring(a=1, stiffness=4.0),
    ]
    space, *_ = space_of(Scene.of(bodies, links))
    assert [joint.stiffness for joint in space.constraints] == [2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("dampings", "damping"),
    [((0.0, 0.0), 1.0), ((2.0, 3.0), np.exp(-1.0)), ((2.0, 1.5), 1.0), ((2.0, 0.0), 1.0)],
)
def test_only_equal_rates_of_damping_are_those_of_the_space(
    dampings: tuple[float, float], damping: float
) -> None:
    bodies = [Body(mass=2.0 + n, position=(1.0 + n, 0.0, 0.0)) for n in range(2)]
    links = [Dashpot(a=n, damping=value) for n, value in enumerate(dampings)]
    space, *_ = space_of(Scene.of(bodies, links))
    assert space.damping == pytest.approx(damping, rel=1e-15)


def attitudes() -> list[tuple[float, float, float, float]]:
    """Turns about z, beyond half a turn among them."""
    halves = np.concatenate([np.arange(-3.1, 3.2, 0.21), [0.0]])
    return [(float(np.cos(half)), 0.0, 0.0, float(np.sin(half))) for half in halves]


def test_what_never_turns_keeps_the_bits_of_its_attitude(run) -> None:  # type: ignore[no-untyped-def]
    """Also in free fall; the cosine and sine of its angle would be off by roundings."""
    bodies = [
        Body(mass=1.0, inertia=(1.0, 1.0, 1.0), position=(3.0 * n, 0.0, 0.0), attitude=q)
        for n, q in enumerate(attitudes())
    ]
    fell = run(Scene.of(bodies, [UniformGravity(g=(0.0, -1.0, 0.0))]), 1.0, 4, 2.0**-4)
    given = np.array(attitudes())
    assert np.array_equal(fell.attitude, np.broadcast_to(given, fell.attitude.shape))
    assert not fell.omega.any()


def test_what_is_turned_later_does_not_keep_it(run) -> None:  # type: ignore[no-untyped-def]
    """It is at rest at the start, and pulled off its centre."""
    for number in (0, 1):
        bodies = [
            Body(mass=1.0, inertia=(1.0, 1.0, 1.0), position=(9.0 * n, 0.0, 0.0)) for n in range(2)
        ]
        spring = Spring(
            a=number, stiffness=2.0, anchor_a=(0.5, 0.0, 0.0), anchor_b=(9.0 * number, 3.0, 0.0)
        )
        turned = run(Scene.of(bodies, [spring]), 0.5, 4, 2.0**-6)
        assert turned.attitude[-1, number, 3] > 0.01
        assert turned.omega[-1, number, 2] > 0.1
        assert np.array_equal(turned.attitude[:, 1 - number], [[1.0, 0.0, 0.0, 0.0]] * 5)


@pytest.mark.parametrize(
    ("corners", "is_convex"),
    [
        ([(0, 0), (2, 0), (0, 1)], True),
        ([(0, 0), (2, 0), (2, 1), (0, 1)], True),
        ([(0, 0), (2, 0), (0.5, 0.5), (0, 2)], False),
        ([(0.5, 0.5), (0, 2), (0, 0), (2, 0)], False),
        ([(0, 0), (2, 0), (2, 1), (1, 0.25), (0, 1)], False),
    ],
)
def test_a_polygon_is_convex_if_it_turns_left_everywhere(
    corners: list[tuple[float, float]], is_convex: bool
) -> None:
    vertices = tuple((float(x), float(y)) for x, y in corners)
    assert _is_convex(Polygon(vertices=vertices)) is is_convex
