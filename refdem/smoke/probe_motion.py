"""The motion of a few rigid bodies under gravity, linear springs and dashpots, for probes that
have no formula.

m dv/dt = F, dr/dt = v, dL/dt = T, dq/dt = (0, omega) q / 2 with omega = R J^-1 R^T L: all in space
axes, by classical Runge-Kutta (Goldstein, Classical Mechanics, chapters 4 and 5). Shares no code
with the solvers.

Euler's equations in body axes, J dw/dt = T - g w x J w with g = 1, have the same motion. Where an
engine takes another g, dL/dt = T + (1 - g) omega x L in space axes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import conjugate, product, rotated
from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
State = tuple[Array, Array, Array, Array]
"""Position, velocity, attitude and angular momentum about each centre, (N, 3 or 4), space axes."""

LONGEST_STEP = 2.0**-6
"""Longest step [s] with which the motions of all probes but one have errors within UNCERTAINTY."""
SHORT_STEP = 2.0**-8
"""Longest step [s] for a spring whose ends pass close to each other."""
UNCERTAINTY = 5e-6
"""Bound on the error of the motions of probes, in units of their scales."""


def motion(
    scene: Scene, t: Array, *, gyroscopic: float = 1.0, longest_step: float = LONGEST_STEP
) -> dict[str, Array]:
    """Position, velocity, attitude and omega (T, N, 3 or 4) at the times t (T,) [s] since the
    start, t[0] = 0, rising or falling.

    `gyroscopic` is the factor g of the gyroscopic term: 1 is right, 0 leaves the term out. Steps
    are at most `longest_step` [s].
    """
    bodies = scene.bodies
    body_omega = rotated(conjugate(bodies.attitude), bodies.omega)
    spin = rotated(bodies.attitude, bodies.inertia * body_omega)
    state: State = (bodies.position, bodies.velocity, bodies.attitude, spin)
    rows = [state]
    for gap in np.diff(t):
        steps = max(1, int(np.ceil(abs(gap) / longest_step)))
        for _ in range(steps):
            state = _stepped(scene, state, gap / steps, gyroscopic)
        rows.append(state)
    position, velocity, attitude, momentum = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    omega = _omega(scene, attitude, momentum)
    return {"position": position, "velocity": velocity, "attitude": attitude, "omega": omega}


def _stepped(scene: Scene, state: State, h: float, gyroscopic: float) -> State:
    """The state one step h [s] of classical Runge-Kutta later, with attitudes made unit again."""
    first = _rate(scene, state, gyroscopic)
    second = _rate(scene, _ahead(state, first, h / 2), gyroscopic)
    third = _rate(scene, _ahead(state, second, h / 2), gyroscopic)
    fourth = _rate(scene, _ahead(state, third, h), gyroscopic)
    new = []
    for x, a, b, c, d in zip(state, first, second, third, fourth, strict=True):
        # y + h/6 (k1 + 2 k2 + 2 k3 + k4).
        new.append(x + h / 6 * (a + 2 * b + 2 * c + d))
    position, velocity, attitude, momentum = new
    attitude = attitude / np.linalg.norm(attitude, axis=-1, keepdims=True)
    return position, velocity, attitude, momentum


def _ahead(state: State, rate: State, h: float) -> State:
    """The state y + h y' with the rate y'."""
    position, velocity, attitude, momentum = (x + h * k for x, k in zip(state, rate, strict=True))
    return position, velocity, attitude, momentum


def _omega(scene: Scene, attitude: Array, momentum: Array) -> Array:
    """omega = R J^-1 R^T L, (..., N, 3) in space axes; zero for points, whose J is 0."""
    inertia = scene.bodies.inertia
    in_body = rotated(conjugate(attitude), momentum)
    omega_body = np.divide(in_body, inertia, out=np.zeros_like(in_body), where=inertia > 0)
    return rotated(attitude, omega_body)


def _rate(scene: Scene, state: State, gyroscopic: float) -> State:
    """Rates of the state: r' = v, v' = F/m, q' = (0, omega) q/2, L' = T + (1 - g) omega x L."""
    position, velocity, attitude, momentum = state
    mass = scene.bodies.mass[:, None]
    force = np.zeros_like(position)
    torque = np.zeros_like(position)
    for gravity in scene.all(UniformGravity):
        force += mass * np.array(gravity.g)
    omega = _omega(scene, attitude, momentum)
    for spring in scene.all(Spring):
        ends = _ends(spring, position, attitude)
        _add(spring, ends, _pull(spring, ends), force, torque)
    for dashpot in scene.all(Dashpot):
        ends = _ends(dashpot, position, attitude)
        _add(dashpot, ends, _resistance(dashpot, ends, velocity, omega), force, torque)
    attitude_rate = product(np.pad(omega, ((0, 0), (1, 0))), attitude) / 2
    momentum_rate = torque + (1.0 - gyroscopic) * np.cross(omega, momentum)
    return velocity, force / mass, attitude_rate, momentum_rate


@dataclass(frozen=True)
class _Ends:
    """Anchors of a link in space: arms from the centres of a and b [m], and the branch from a's
    anchor to b's [m]; (3,) each. The arm of an anchor in the world is 0.
    """

    arm_a: Array
    arm_b: Array
    branch: Array


def _ends(link: Link, position: Array, attitude: Array) -> _Ends:
    """The anchors of a link for these positions (N, 3) and attitudes (N, 4)."""
    arm_a = rotated(attitude[link.a], np.array(link.anchor_a))
    end_b = np.array(link.anchor_b)
    arm_b = np.zeros(3)
    if link.b >= 0:
        arm_b = rotated(attitude[link.b], end_b)
        end_b = position[link.b] + arm_b
    return _Ends(arm_a, arm_b, end_b - position[link.a] - arm_a)


def _pull(spring: Spring, ends: _Ends) -> Array:
    """The force (3,) [N] of a linear spring on a: k (d - length) along the line from a to b."""
    distance = float(np.linalg.norm(ends.branch))
    force: Array = spring.stiffness * (distance - spring.length) * ends.branch / distance
    return force


def _resistance(dashpot: Dashpot, ends: _Ends, velocity: Array, omega: Array) -> Array:
    """The force (3,) [N] of a dashpot on a: -c times the velocity of a's anchor against b's."""
    relative = velocity[dashpot.a] + np.cross(omega[dashpot.a], ends.arm_a)
    if dashpot.b >= 0:
        relative = relative - velocity[dashpot.b] - np.cross(omega[dashpot.b], ends.arm_b)
    force: Array = -dashpot.damping * relative
    return force


def _add(link: Link, ends: _Ends, on_a: Array, force: Array, torque: Array) -> None:
    """Adds the force `on_a` (3,) [N] of a link at its anchors, and its torques about the centres,
    to `force` and `torque` (N, 3).
    """
    force[link.a] += on_a
    torque[link.a] += np.cross(ends.arm_a, on_a)
    if link.b >= 0:
        force[link.b] -= on_a
        torque[link.b] -= np.cross(ends.arm_b, on_a)
