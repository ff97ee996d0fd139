"""Where an adapter begins to refuse: of each condition, a scene just on either side of it.

Links are named in both orders, and by the first body as well as by others: a condition on the
number of a body that is off by one shows.
"""

from dataclasses import dataclass, field

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.scene import Body, Point, Polyhedron, Scene, Sphere, box
from refdem.scene.element import Element
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

RUBS = {"friction": 0.5, "normal_force": 2.0}
OFF = (0.25, 0.0, 0.0)
SOFT = Contact(law="linear", stiffness=9.0)
HARD = Contact(law="rigid", restitution=0.5)
DOWN = UniformGravity(g=(0.0, 0.0, -9.8))
GROUND = Plane(normal=(0.0, 0.0, 1.0))


def points(*places: float, fixed: tuple[int, ...] = (), y: float = 0.5) -> list[Body]:
    """Points beside the x axis, so that a scene is planar."""
    return [
        Body(mass=1.0 + n, position=(x, y * n, 0.0), fixed=n in fixed) for n, x in enumerate(places)
    ]


def hanging(stretch: float = 0.0, slip: float = 0.0, below: float = 0.0) -> list[Body]:
    """Three points below one another, 2 m each; the upper one off the rod, the lowest off its."""
    return [
        Body(mass=1.0, position=(0.0, -2.0 * (1 + stretch), 0.0), velocity=(1.0, slip, 0.0)),
        Body(mass=1.0, position=(0.0, -4.0 - 2 * stretch, 0.0), velocity=(1.0, slip, 0.0)),
        Body(mass=1.0, position=(0.0, -6.0 - 2 * stretch - below, 0.0), velocity=(1.0, slip, 0.0)),
    ]


CHAIN = [Rod(a=0, length=2.0), Rod(a=1, b=0, length=2.0), Rod(a=2, b=1, length=2.0)]


def spheres(count: int, *, radius: float = 0.5, fixed: int = -1) -> list[Body]:
    """Spheres that do not touch."""
    return [
        Body(
            mass=1.0,
            position=(3.0 * n, 0.1 * n, 0.2 * n),
            shape=Sphere(radius=radius),
            fixed=n == fixed,
        )
        for n in range(count)
    ]


@dataclass(frozen=True)
class Edge:
    """A condition: scenes that are run, and scenes that are refused in these words."""

    engine: str
    method: str
    words: str
    runs: list[tuple[list[Body], list[Element]]] = field(default_factory=list)
    refused: list[tuple[list[Body], list[Element]]] = field(default_factory=list)


TWO = points(0.0, 2.0)
THREE = points(0.0, 2.0, 5.0)
LINE = points(0.0, 2.0, y=0.0)
EDGES = [
    Edge(
        "mujoco",
        "euler",
        "dry friction between bodies",
        runs=[(LINE, [Slider(a=n, **RUBS)]) for n in (0, 1)],
        refused=[(LINE, [Slider(a=a, b=1 - a, **RUBS)]) for a in (0, 1)],
    ),
    Edge(
        "mujoco",
        "euler",
        "other axes",
        runs=[
            (TWO, [Slider(a=0, axis=axis, **RUBS)])
            for axis in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0))
        ],
        refused=[
            (TWO, [Slider(a=0, axis=axis, **RUBS)]) for axis in ((0.6, 0.8, 0), (0.8, 0, 0.6))
        ],
    ),
    Edge(
        "mujoco",
        "euler",
        "a belt",
        runs=[
            (LINE, [Slider(a=1, belt_velocity=1.5, axis=(s, 0, 0), **RUBS)]) for s in (1.0, -1.0)
        ],
        refused=[(TWO, [Slider(a=1, belt_velocity=1.5, **RUBS)])],
    ),
    Edge(
        "mujoco",
        "euler",
        "a start off the rod",
        runs=[
            (hanging(), CHAIN),
            (hanging(stretch=0.9e-9), CHAIN),
            (hanging(stretch=-0.9e-9), CHAIN),
            (hanging(slip=0.9e-9), CHAIN),
            (hanging(below=1.7e-9), CHAIN),
        ],
        refused=[
            (hanging(stretch=1.2e-9), CHAIN),
            (hanging(stretch=-1.2e-9), CHAIN),
            (hanging(slip=1.2e-9), CHAIN),
            (hanging(slip=-1.2e-9), CHAIN),
            (hanging(below=2.3e-9), CHAIN),
        ],
    ),
    Edge(
        "mujoco",
        "euler",
        "rods that do not hang",
        runs=[(hanging()[:n], CHAIN[:n]) for n in (1, 2, 3)],
        refused=[
            (hanging(), CHAIN[1:]),
            (hanging()[:2], [Rod(a=1, b=0, length=2.0)]),
            (hanging()[:2], [Rod(a=1, b=0, length=2.0), Rod(a=0, b=1, length=2.0)]),
            (hanging()[:1], [Rod(a=0, length=2.0), Rod(a=0, length=2.0)]),
        ],
    ),
    Edge(
        "mujoco",
        "euler",
        "on a body that hangs on a rod",
        runs=[([*hanging()[:1], *points(3.0)], [CHAIN[0], Spring(a=1, stiffness=2.0)])],
        refused=[
            (hanging()[:2], [*CHAIN[:2], Spring(a=0, stiffness=2.0)]),
            (hanging()[:2], [*CHAIN[:2], Spring(a=1, stiffness=2.0)]),
            ([*points(3.0), *hanging()[:1]], [Rod(a=1, length=2.0), Spring(a=0, b=1, stiffness=2)]),
            (hanging()[:2], [*CHAIN[:2], Dashpot(a=1, damping=2.0)]),
        ],
    ),
    Edge(
        "mujoco",
        "euler",
        "a point other than the centre",
        refused=[
            (hanging()[:1], [Rod(a=0, anchor_a=OFF, length=2.0)]),
            (hanging()[:2], [CHAIN[0], Rod(a=1, b=0, anchor_b=OFF, length=2.0)]),
        ],
    ),
    Edge(
        "mujoco",
        "euler",
        "by mjcb_passive off the centre|a dashpot off the centre",
        runs=[(TWO, [Force(a=1, b=0, amplitude=1.0)]), (TWO, [Dashpot(a=1, b=0, damping=1.0)])],
        refused=[
            (TWO, [Force(a=1, b=0, amplitude=1.0, anchor_b=OFF)]),
            (TWO, [Force(a=0, amplitude=1.0, anchor_a=OFF)]),
            (TWO, [Dashpot(a=1, b=0, damping=1.0, anchor_b=OFF)]),
            (TWO, [Dashpot(a=1, damping=1.0, anchor_a=OFF)]),
        ],
    ),
    Edge(
        "mujoco",
        "euler",
        "by mjcb_passive on a fixed body",
        runs=[(points(0.0, 2.0, fixed=(0,)), [Force(a=1, amplitude=1.0)])],
        refused=[
            (points(0.0, 2.0, fixed=(0,)), [Force(a=1, b=0, amplitude=1.0)]),
            (points(0.0, 2.0, fixed=(1,)), [Force(a=1, b=0, amplitude=1.0)]),
        ],
    ),
    Edge(
        "rebound",
        "bs",
        "rods that share a body",
        runs=[
            (
                points(0.0, 2.0, 5.0, 7.0, y=0.0),
                [Rod(a=0, b=1, length=2.0), Rod(a=3, b=2, length=2.0)],
            )
        ],
        refused=[
            (points(0.0, 2.0, 4.0, y=0.0), [Rod(a=0, b=1, length=2.0), Rod(a=2, b=1, length=2.0)]),
            (points(2.0, 0.0, 4.0, y=0.0), [Rod(a=1, b=0, length=2.0), Rod(a=2, b=0, length=2.0)]),
        ],
    ),
    Edge(
        "rebound",
        "bs",
        "a rod whose length differs",
        runs=[(points(2.0), [Rod(a=0, length=2.0 * (1 + gap))]) for gap in (0.0, 0.9e-9, -0.9e-9)],
        refused=[(points(2.0), [Rod(a=0, length=2.0 * (1 + gap))]) for gap in (1.2e-9, -1.2e-9)],
    ),
    Edge(
        "rebound",
        "bs",
        "a rod between bodies that do not move",
        runs=[(points(0.0, 2.0, y=0.0, fixed=(n,)), [Rod(a=0, b=1, length=2.0)]) for n in (0, 1)],
        refused=[
            (points(0.0, 2.0, y=0.0, fixed=(0, 1)), [Rod(a=0, b=1, length=2.0)]),
            (points(2.0, y=0.0, fixed=(0,)), [Rod(a=0, length=2.0)]),
        ],
    ),
    Edge(
        "rebound",
        "leapfrog",
        "more than 64 spheres",
        runs=[(spheres(64), [SOFT])],
        refused=[(spheres(65), [SOFT])],
    ),
    Edge(
        "rebound",
        "leapfrog",
        "hard spheres on which forces act|that no collision moves|points beside hard spheres",
        runs=[(spheres(1), [HARD]), (spheres(3), [HARD]), (spheres(65), [HARD])],
        refused=[
            (spheres(3), [HARD, DOWN]),
            (spheres(3), [HARD, Spring(a=2, b=1, stiffness=1.0)]),
            (spheres(3, fixed=0), [HARD]),
            (spheres(3, fixed=2), [HARD]),
            ([*spheres(2), Body(mass=1.0, position=(0.0, 9.0, 0.0), shape=Point())], [HARD]),
        ],
    ),
    Edge(
        "rebound",
        "leapfrog",
        "a force off the centre",
        runs=[(TWO, [Spring(a=1, anchor_b=OFF, stiffness=1.0)])],
        refused=[
            (TWO, [Spring(a=1, anchor_a=OFF, stiffness=1.0)]),
            (TWO, [Spring(a=1, b=0, anchor_b=OFF, stiffness=1.0)]),
        ],
    ),
    Edge(
        "rebound",
        "whfast",
        "other than one attracting centre",
        runs=[(TWO, [CentralField(gm=1.0)])],
        refused=[(TWO, []), (TWO, [DOWN]), (TWO, [CentralField(gm=1.0), DOWN])],
    ),
    Edge(
        "rebound",
        "ias15",
        "not smooth where it changes sign",
        runs=[(TWO, [Spring(a=0, stiffness=1.0, exponent=n)]) for n in (1.0, 3.0, 5.0)],
        refused=[(TWO, [Spring(a=0, stiffness=1.0, exponent=n)]) for n in (1.5, 2.0, 4.0)],
    ),
    Edge(
        "pymunk",
        "semi-implicit-euler",
        "a dashpot between bodies",
        runs=[(TWO, [Dashpot(a=n, damping=1.0)]) for n in (0, 1)],
        refused=[(TWO, [Dashpot(a=a, b=1 - a, damping=1.0)]) for a in (0, 1)],
    ),
    Edge(
        "pymunk",
        "semi-implicit-euler",
        "a dashpot off the centre",
        refused=[(TWO, [Dashpot(a=0, damping=1.0, anchor_a=OFF)])],
    ),
    Edge(
        "pymunk",
        "semi-implicit-euler",
        "between bodies or on a fixed body",
        runs=[(TWO, [Force(a=n, amplitude=1.0)]) for n in (0, 1)],
        refused=[
            (TWO, [Force(a=1, b=0, amplitude=1.0)]),
            (TWO, [Force(a=0, b=1, amplitude=1.0)]),
            (points(0.0, 2.0, fixed=(0,)), [Force(a=0, amplitude=1.0)]),
        ],
    ),
    Edge(
        "pymunk",
        "semi-implicit-euler",
        "dry friction along one axis of a planar motion",
        runs=[(LINE, [Slider(a=0, **RUBS)])],
        refused=[(TWO, [Slider(a=0, **RUBS)])],
    ),
]


@pytest.mark.parametrize("edge", EDGES, ids=lambda edge: f"{edge.engine}-{edge.words}")
def test_an_adapter_refuses_from_the_edge_of_a_condition_on(edge: Edge) -> None:
    engine = discovery.engine(edge.engine)
    method = engine.method(edge.method)
    times = 0.125 * np.arange(3)
    for bodies, elements in edge.runs:
        assert engine.unsupported(Motion(Scene.of(bodies, elements), times), method) is None
    for bodies, elements in edge.refused:
        said = engine.unsupported(Motion(Scene.of(bodies, elements), times), method)
        assert said is not None, elements
        assert any(words in said for words in edge.words.split("|"))


NORMALS = [
    (0.0, 0.0, 1.0),
    (0.0, 0.0, -1.0),
    (1.0, 0.0, 0.0),
    (0.0, -1.0, 0.0),
    (2 / 3, -1 / 3, -2 / 3),
    (-2 / 3, 2 / 3, 1 / 3),
    (0.48, 0.64, -0.6),
    (1e-9, 0.0, -1.0),
]


@pytest.mark.parametrize("normal", NORMALS)
def test_mujocos_planes_are_turned_up_by_a_unit_quaternion(
    normal: tuple[float, float, float],
) -> None:
    from refdem.engines.mujoco.shapes import _turned_up
    from refdem.mechanics.quaternion import rotated

    q = _turned_up(normal)
    assert abs(np.linalg.norm(q) - 1) < 1e-14
    np.testing.assert_allclose(rotated(q, np.array([0.0, 0.0, 1.0])), normal, atol=1e-14)


def test_mujocos_boxes_are_about_their_centre_along_their_axes() -> None:
    from refdem.engines.mujoco.shapes import box_sides

    cuboid = box(1.0, 2.0, 3.0)
    sides = box_sides(cuboid)
    assert sides is not None
    assert sides.tolist() == [1.0, 2.0, 3.0]
    corners = np.array(cuboid.vertices)
    shifted = corners + np.array([0.25, 0.0, 0.0])
    pushed = corners.copy()
    pushed[3] *= 1.25
    turned = corners @ np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    for wrong in (shifted, pushed, turned):
        shape = Polyhedron(vertices=tuple(map(tuple, wrong.tolist())), faces=cuboid.faces)
        assert box_sides(shape) is None


def test_pairs_that_may_meet_in_mujoco_have_their_effective_masses() -> None:
    from refdem.engines.mujoco.shapes import effective_masses

    bodies = [
        Body(mass=2.0, shape=Sphere(radius=1.0)),
        Body(mass=9.0, shape=Point()),
        Body(mass=3.0, position=(5.0, 0.0, 0.0), shape=Sphere(radius=1.0)),
        Body(mass=4.0, position=(9.0, 0.0, 0.0), shape=Sphere(radius=1.0), fixed=True),
        Body(mass=5.0, position=(13.0, 0.0, 0.0), shape=Sphere(radius=1.0), fixed=True),
    ]
    found = sorted(effective_masses(Scene.of(bodies, [GROUND, SOFT])))
    # Of the pairs 0-2, 0-3, 0-4, 2-3, 2-4, and of 0 and 2 with the plane.
    np.testing.assert_allclose(found, [1.2, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0], rtol=1e-15)
