"""Probes of bodies that rotate away from the origin, move, and are held or pulled off their
centres.

At the origin and at rest, a displaced centre of mass, the velocity of another point, and body axes
in place of space axes would not be detected.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import product
from refdem.scene import Body, Scene
from refdem.scene.element import Element
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.probe_motion import LONGEST_STEP, SHORT_STEP, UNCERTAINTY, motion
from refdem.smoke.probes import Probe, turning_mistakes

Array = NDArray[np.float64]

TUMBLING = Body(
    mass=2.0,
    inertia=(1.5, 1.0, 2.0),
    position=(1.5, -0.75, 0.5),
    velocity=(-1.25, 2.0, 0.75),
    attitude=(0.5, 0.5, -0.1, 0.7),
    omega=(1.25, -1.75, 2.0),
)
"""A general body: three different moments, an attitude and omega along no axis, away from the
origin, moving.
"""
OTHER = Body(
    mass=5.0,
    inertia=(2.0, 3.5, 4.0),
    position=(-2.0, 1.0, 1.25),
    velocity=(0.5, -0.25, -1.5),
    attitude=(0.7, -0.1, 0.5, -0.5),
    omega=(-1.5, 1.0, 0.75),
)
"""Another general body, all of whose numbers differ from those of TUMBLING."""
FLAT = Body(
    mass=2.0,
    inertia=(1.0, 1.0, 1.5),
    position=(1.5, -0.75, 0.0),
    velocity=(-1.25, 2.0, 0.0),
    attitude=(0.8, 0.0, 0.0, 0.6),
    omega=(0.0, 0.0, 2.0),
)
"""The same in a plane, for engines that have no third dimension."""
LEVER = (0.5, -0.25, 0.75)
FLAT_LEVER = (0.5, -0.25, 0.0)


def turning_probes() -> tuple[Probe, ...]:
    """The probes of bodies that turn: thrown, on springs and dashpots, and on a ball joint."""
    return (*_tumbles(), *_pulled(), *_swung())


def _integrated(
    name: str,
    verifies: str,
    bodies: list[Body],
    elements: list[Element],
    *,
    backwards: bool = False,
    longest_step: float = LONGEST_STEP,
) -> Probe:
    """A probe whose motion is that of probe_motion, with steps of at most `longest_step` [s]."""
    scene = Scene.of(bodies, elements)
    return Probe(
        name=name,
        verifies=verifies,
        scene=scene,
        expected=lambda t: motion(scene, t, longest_step=longest_step),
        uncertainty=UNCERTAINTY,
        backwards=backwards,
        mistakes=turning_mistakes(scene),
    )


def _tumbles() -> tuple[Probe, ...]:
    """Bodies that are thrown and tumble, in a plane and in space, one and two of them."""
    down_z = UniformGravity(g=(0.0, 0.0, -9.75))
    askew = UniformGravity(g=(2.0, -1.0, 3.0))
    flat = UniformGravity(g=(3.0, -9.75, 0.0))
    of_body = (
        "the position and velocity of the centre of mass, the quaternion convention and the axes of"
        " omega and inertia"
    )
    of_order = "the order of the bodies"
    of_time = "steps backwards in time"
    single = (
        _integrated("flat throw", of_body, [FLAT], [flat]),
        _integrated("tumble", of_body, [TUMBLING], []),
        _integrated("tumbling throw", of_body, [TUMBLING], [down_z]),
    )
    # Two bodies in either order: one that is taken for the other shows in at least one.
    ordered = (
        _integrated("two tumbling", of_order, [TUMBLING, OTHER], [askew]),
        _integrated("two in the other order", of_order, [OTHER, TUMBLING], [askew]),
    )
    backwards = _integrated("tumble backwards", of_time, [TUMBLING], [down_z], backwards=True)
    return (*single, *ordered, backwards)


def _pulled() -> tuple[Probe, ...]:
    """Springs and dashpots that are fixed to bodies off their centres."""
    anchored = "anchors off the centre of mass, in body axes, and their torque"
    to_wall = Spring(a=0, stiffness=8.0, length=0.5, anchor_a=LEVER, anchor_b=(-0.5, 1.0, 2.0))
    flat_to_wall = Spring(
        a=0, stiffness=8.0, length=0.5, anchor_a=FLAT_LEVER, anchor_b=(-0.5, 1.0, 0.0)
    )
    between = Spring(
        a=1, b=0, stiffness=8.0, length=0.5, anchor_a=LEVER, anchor_b=(-0.25, 0.5, 1.0)
    )
    damped = Dashpot(a=1, b=0, damping=4.0, anchor_a=LEVER, anchor_b=(-0.25, 0.5, 1.0))
    flat_damped = Dashpot(a=0, damping=4.0, anchor_a=FLAT_LEVER, anchor_b=(-0.5, 1.0, 0.0))
    at_centres = Spring(a=1, b=0, stiffness=8.0, length=0.5)
    points = [
        Body(mass=b.mass, position=b.position, velocity=b.velocity) for b in (TUMBLING, OTHER)
    ]
    ends = "both ends of a spring and its rest length"
    springs = (
        _integrated("spring between points", ends, points, [at_centres]),
        _integrated(
            "spring off the centre in a plane",
            anchored,
            [FLAT],
            [flat_to_wall],
            longest_step=SHORT_STEP,
        ),
        _integrated("spring off the centre", anchored, [TUMBLING], [to_wall]),
        _integrated("spring between two bodies", anchored, [TUMBLING, OTHER], [between]),
    )
    dashpots = (
        _integrated("dashpot off the centre in a plane", anchored, [FLAT], [flat_damped]),
        _integrated("dashpot between two bodies", anchored, [TUMBLING, OTHER], [damped]),
    )
    return (*springs, *dashpots)


def _swung() -> tuple[Probe, ...]:
    """A body on a ball joint off its centre, which turns steadily about the line through the pivot
    that is parallel to z, a principal axis.

    With the arm a from the pivot P to the centre: r = P + Q(t) a, v = omega x Q(t) a.
    """
    pivot = np.array([0.5, -1.0, 0.25])
    anchor = np.array([-0.5, 0.75, 0.0])
    attitude = np.array([0.8, 0.0, 0.0, 0.6])
    rate = 2.0
    # The matrix of `attitude`: cos = 0.8^2 - 0.6^2, sin = 2 * 0.8 * 0.6.
    body_to_space = np.array([[0.28, -0.96, 0.0], [0.96, 0.28, 0.0], [0.0, 0.0, 1.0]])
    # The vector from the pivot to the centre at the start.
    arm = -body_to_space @ anchor

    def expected(t: Array) -> dict[str, Array]:
        c = np.cos(rate * t)
        s = np.sin(rate * t)
        zero = 0 * t
        # The arm turned by the angle rate t about z, and omega x arm.
        x = c * arm[0] - s * arm[1]
        y = s * arm[0] + c * arm[1]
        rotated_arm = np.column_stack([x, y, zero])
        velocity = rate * np.column_stack([-y, x, zero])
        half = rate * t / 2
        rotation = np.column_stack([np.cos(half), zero, zero, np.sin(half)])
        return {
            "position": (pivot + rotated_arm)[:, None],
            "velocity": velocity[:, None],
            "attitude": product(rotation, attitude)[:, None],
            "omega": np.tile([0.0, 0.0, rate], (len(t), 1, 1)),
        }

    start = expected(np.zeros(1))
    body = Body(
        mass=2.0,
        inertia=(1.0, 1.5, 2.0),
        position=tuple(start["position"][0, 0].tolist()),
        velocity=tuple(start["velocity"][0, 0].tolist()),
        attitude=tuple(attitude.tolist()),
        omega=(0.0, 0.0, rate),
    )
    joint = BallJoint(a=0, anchor_a=tuple(anchor.tolist()), anchor_b=tuple(pivot.tolist()))
    verifies = "the anchor of a joint, in body axes, and its pivot"
    return (
        Probe(
            name="ball joint", verifies=verifies, scene=Scene.of([body], [joint]), expected=expected
        ),
    )
