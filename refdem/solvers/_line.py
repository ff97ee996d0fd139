"""A point that moves along one line: the line, its spring, dashpot, weight and drives, read off a
scene.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import UnsupportedError
from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single

Array = NDArray[np.float64]

ELEMENTS = (Spring, Dashpot, Force, UniformGravity)
ASKEW = 1e-15
"""Part of a vector that may point off the line: round-off of a scene turned into some other
direction.
"""


@dataclass(frozen=True)
class Line:
    """`axis` (3,) and `origin` (3,) [m], where the spring is at rest; on it place [m], velocity
    [m/s] and weight [N] of the point.

    `drives` (M, 3): force [N], frequency [rad/s] and phase along the axis; `offset` [m] from the
    dashpot's anchor to the origin.
    """

    axis: Array
    origin: Array
    place: float
    speed: float
    mass: float
    weight: float
    spring: Spring
    damping: float
    van_der_pol: float
    offset: float
    drives: Array

    def trajectory(self, t: Array, x: Array, v: Array, **more: Any) -> Trajectory:
        """The motion in space of places x (T,) and velocities v (T,); raises UnsupportedError if it
        passed the spring's anchor.
        """
        if self.spring.length > 0 and np.any(x <= -self.spring.length):
            raise UnsupportedError(
                "the point passes the anchor of its spring: the force turns round there, which no"
                " series shows"
            )
        position = self.origin + x[:, None, None] * self.axis
        return Trajectory.of_points(t, position, v[:, None, None] * self.axis, **more)


def unsupported(problem: Motion) -> str | None:
    """None for one point on one spring to the world, with at most one dashpot, forces and gravity,
    all along one line.
    """
    scene = problem.scene
    others = [element.kind for element in scene.elements if not isinstance(element, ELEMENTS)]
    if others:
        return f"{others[0]} is more than an oscillator on a line has"
    if len(scene.bodies) != 1 or scene.bodies.fixed.any():
        return f"{len(scene.bodies)} bodies, or a fixed one; expected one that moves"
    if len(scene.all(Spring)) != 1 or len(scene.all(Dashpot)) > 1:
        return (
            f"{len(scene.all(Spring))} springs and {len(scene.all(Dashpot))} dashpots; expected one"
            " and at most one"
        )
    return single.turning(scene) or _askew(scene)


def line_of(request: Request) -> Line:
    """The line of a scene that is not refused."""
    scene = request.problem.scene
    bodies = scene.bodies
    spring = scene.all(Spring)[0]
    axis = _axis(scene)
    origin = np.array(spring.anchor_b) + spring.length * axis
    dashpot = next(iter(scene.all(Dashpot)), Dashpot(a=0))
    drives = []
    for force in scene.all(Force):
        amplitude = force.amplitude * float(axis @ np.array(force.axis))
        drives.append((amplitude, force.frequency, force.phase))
    # Places count from where the spring is at rest, not from its anchor.
    from_anchor = float(axis @ (bodies.position[0] - np.array(spring.anchor_b)))
    mass = float(bodies.mass[0])
    return Line(
        axis=axis,
        origin=origin,
        place=from_anchor - spring.length,
        speed=float(axis @ bodies.velocity[0]),
        mass=mass,
        weight=mass * float(axis @ single.gravity(scene)),
        spring=spring,
        damping=dashpot.damping,
        van_der_pol=dashpot.van_der_pol,
        offset=float(axis @ (origin - np.array(dashpot.anchor_b))),
        drives=np.array(drives, float).reshape(-1, 3),
    )


def _axis(scene: Scene) -> Array:
    """The unit vector of the line; away from the anchor of a spring that has a length."""
    arm = scene.bodies.position[0] - np.array(scene.all(Spring)[0].anchor_b)
    candidates = [
        arm,
        *(np.array(force.axis) for force in scene.all(Force)),
        scene.bodies.velocity[0],
        single.gravity(scene),
    ]
    # What rests without a force may be taken along x.
    candidates.append(np.array([1.0, 0.0, 0.0]))
    first = next(vector for vector in candidates if np.any(vector))
    axis: Array = first / np.linalg.norm(first)
    return axis


def _askew(scene: Scene) -> str | None:
    """None if everything lies on the line."""
    links = [element for element in scene.elements if isinstance(element, Link)]
    if any(link.b >= 0 for link in links):
        return "a link between bodies"
    axis = _axis(scene)
    anchor = np.array(scene.all(Spring)[0].anchor_b)
    vectors = [scene.bodies.position[0] - anchor, scene.bodies.velocity[0], single.gravity(scene)]
    vectors += [np.array(force.axis) for force in scene.all(Force)]
    vectors += [np.array(dashpot.anchor_b) - anchor for dashpot in scene.all(Dashpot)]
    for vector in vectors:
        aside = np.linalg.norm(vector - (vector @ axis) * axis)
        if aside > ASKEW * np.linalg.norm(vector):
            return "the motion is not along one line"
    return None
