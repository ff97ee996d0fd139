"""A body on MuJoCo's ball joint: against the reference, from any place and attitude, and what is
refused.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.mujoco.unsupported import unsupported
from refdem.engines.reference import ENGINE
from refdem.mechanics.quaternion import rotated
from refdem.scene import Body, Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

TIMES = np.linspace(0.0, 1.0, 9)
GRAVITY = UniformGravity(g=(1.0, -2.0, -8.0))

PAIR = [Body(mass=1.0, inertia=(1.0, 1.0, 1.0), position=(float(k), 0.0, 0.0)) for k in range(2)]


def top(**changed):
    """A body that is not symmetric, from some attitude, on a joint away from the origin; its centre
    on its second axis.
    """
    attitude = np.array([0.5, 0.5, -0.1, 0.7])
    omega = np.array([3.0, -2.0, 1.0])
    place = np.array([1.0, 2.0, 3.0])
    attitude = attitude / np.linalg.norm(attitude)
    arm = rotated(attitude, np.array([0.0, 0.5, 0.0]))
    state = {
        "position": place + arm,
        "velocity": np.cross(omega, arm),
        "attitude": attitude,
        "omega": omega,
    } | changed
    body = Body(
        mass=2.0, inertia=(1.0, 2.0, 2.5), **{name: tuple(value) for name, value in state.items()}
    )
    return Scene.of(
        [body], [BallJoint(a=0, anchor_a=(0.0, -0.5, 0.0), anchor_b=tuple(place)), GRAVITY]
    )


def test_motion_is_that_of_the_reference(engine):
    problem = Motion(top(), TIMES)
    exact, _ = ENGINE.run(Request(problem=problem, method="spinning-top"))
    errors = []
    for step in (1 / 64, 1 / 128):
        run, _ = engine.run(Request(problem=problem, method="rk4", step=step))
        errors.append(
            [
                np.abs(getattr(run, name) - getattr(exact, name)).max()
                for name in ("position", "velocity", "omega")
            ]
        )
    assert max(errors[1]) < 1e-5
    assert np.divide(*errors) == pytest.approx([16.0] * 3, rel=0.15)


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (top(), None),
        (top(velocity=(0.0, 0.0, 0.0)), "open"),
        (top(position=(0.0, 0.0, 0.0)), "open"),
        (
            Scene(top().bodies, (*top().elements, Rod(a=0, length=0.5, anchor_b=(1.0, 2.0, 3.0)))),
            "out of a plane",
        ),
        (Scene(top().bodies, (*top().elements, top().elements[0])), "more than one on a body"),
        (
            Scene.of([*PAIR], [BallJoint(a=1, b=0, anchor_a=(-1.0, 0.0, 0.0))]),
            "ball joints between bodies",
        ),
    ],
)
def test_what_is_no_top_is_refused(scene, reason):
    said = unsupported(Motion(scene, TIMES))
    assert said is None if reason is None else reason in str(said)
