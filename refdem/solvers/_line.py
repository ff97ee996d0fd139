"""A point that moves along one line, with its spring, dashpot, weight and drives, taken from a
scene.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, ScenePattern

Array = NDArray[np.float64]

PATTERN = ScenePattern(
    elements={Spring: ONE, Dashpot: OPTIONAL, Force: ANY, UniformGravity: ANY},
    bodies=ONE,
    only_points=True,
)
"""One point on one spring to the world, with at most one dashpot, forces and gravity."""
ASKEW = 1e-15
"""Largest relative component off the line: round-off of a scene that was rotated."""


@dataclass(frozen=True)
class Line:
    """Motion x(t) along the unit vector `axis` (3,) from `origin` (3,) [m], where the spring is
    relaxed.

    - `x0` [m] and `v0` [m/s] are x and x' at the start; `weight` [N] acts along the axis.
    - `damping` and `van_der_pol` are the dashpot's coefficients.
    - `drives` (M, 3) are amplitude [N] along the axis, frequency [rad/s] and phase of each force.
    - `offset` [m] is the distance from the dashpot's anchor to the origin.
    """

    axis: Array
    origin: Array
    x0: float
    v0: float
    mass: float
    weight: float
    spring: Spring
    damping: float
    van_der_pol: float
    offset: float
    drives: Array

    def trajectory(self, t: Array, x: Array, v: Array, **more: Any) -> Trajectory:
        """The motion in space from positions x (T,) and velocities v (T,) along the line."""
        position = self.origin + x[:, None, None] * self.axis
        return Trajectory.of_points(t, position, v[:, None, None] * self.axis, **more)


def line_of(scene: Scene) -> Line:
    """The line of a scene that matches PATTERN."""
    bodies = scene.bodies
    spring = scene.all(Spring)[0]
    axis = _axis(scene)
    anchor = single.anchor(spring)
    # x = axis . (r - anchor) - l is the stretch: x = 0 where the spring is relaxed.
    origin = anchor + spring.length * axis
    from_anchor = float(axis @ (bodies.position[0] - anchor))
    dashpot = next(iter(scene.all(Dashpot)), Dashpot(a=0))
    offset = float(axis @ (origin - single.anchor(dashpot)))
    mass = float(bodies.mass[0])
    return Line(
        axis=axis,
        origin=origin,
        x0=from_anchor - spring.length,
        v0=float(axis @ bodies.velocity[0]),
        mass=mass,
        weight=mass * float(axis @ single.gravity(scene)),
        spring=spring,
        damping=dashpot.damping,
        van_der_pol=dashpot.van_der_pol,
        offset=offset,
        drives=_drives(scene, axis),
    )


def _drives(scene: Scene, axis: Array) -> Array:
    """Amplitude along the axis [N], frequency [rad/s] and phase (M, 3) of every force."""
    drives = []
    for force in scene.all(Force):
        amplitude = force.amplitude * float(axis @ np.array(force.axis))
        drives.append((amplitude, force.frequency, force.phase))
    return np.array(drives, float).reshape(-1, 3)


def _axis(scene: Scene) -> Array:
    """The unit vector of the line: from the spring's anchor to the point, else along a force, the
    velocity or gravity.
    """
    arm = scene.bodies.position[0] - np.array(scene.all(Spring)[0].anchor_b)
    candidates = [
        arm,
        *(np.array(force.axis) for force in scene.all(Force)),
        scene.bodies.velocity[0],
        single.gravity(scene),
    ]
    # A point at rest on which no force acts may be described along any axis, here x.
    candidates.append(np.array([1.0, 0.0, 0.0]))
    first = next(vector for vector in candidates if np.any(vector))
    axis: Array = first / np.linalg.norm(first)
    return axis


def askew(scene: Scene) -> str | None:
    """None if everything lies on the line, else the reason."""
    if any(link.b >= 0 for link in scene.all(Link)):
        return "a link between bodies"
    axis = _axis(scene)
    bodies = scene.bodies
    anchor = single.anchor(scene.all(Spring)[0])
    vectors = [bodies.position[0] - anchor, bodies.velocity[0], single.gravity(scene)]
    vectors += [np.array(force.axis) for force in scene.all(Force)]
    vectors += [single.anchor(dashpot) - anchor for dashpot in scene.all(Dashpot)]
    for vector in vectors:
        on_line = (vector @ axis) * axis
        if np.linalg.norm(vector - on_line) > ASKEW * np.linalg.norm(vector):
            return "the motion is not along one line"
    return None
