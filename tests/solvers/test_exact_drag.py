"""Fall with quadratic drag in closed form: which scenes it takes, falls along any direction."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.uniform_gravity import UniformGravity

METHOD = next(m for m in ENGINE.methods if m.name == "exact-drag")
TIMES = np.linspace(0.0, 2.0, 9)


def falling(velocity, coefficient=0.25, gravity=(0.0, -8.0, 0.0)):
    body = Body(mass=2.0, velocity=velocity)
    return Scene.of([body], [UniformGravity(g=gravity), Drag(a=0, coefficient=coefficient)])


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (falling((1.0, 0.0, 0.0)), "not along one line"),
        (falling((0.0, 1.0, 0.0), coefficient=0.0), "the drag is zero"),
        (falling((0.0, 1.0, 0.0), gravity=(0.0, 0.0, 0.0)), "no gravity"),
    ],
)
def test_what_is_no_fall_along_a_line_is_refused(scene, reason):
    assert reason in (ENGINE.unsupported(Motion(scene, TIMES), METHOD) or "")


def test_the_fall_is_the_same_along_any_direction():
    instance = discovery.case("quadratic-drag").at(v0="3")
    along_y = ENGINE.run(Request(problem=instance.problem, method="exact-drag"))[0]
    axis = np.array([2.0, -1.0, 2.0]) / 3
    scene = falling(tuple(-3.0 * axis), gravity=tuple(8.0 * axis))
    turned = ENGINE.run(Request(problem=Motion(scene, instance.times), method="exact-drag"))[0]
    height = -turned.position[:, 0] @ axis
    assert height == pytest.approx(along_y.position[:, 0, 1], abs=1e-12)
