"""Equations of motion of simple scenes as first-order systems, written once for numbers and for
symbols alike.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
Sine = Callable[[Any], Any]


@dataclass(frozen=True)
class Equations:
    """y' = rates(y, sine) from `start`, and the motion of the scene from states (T, n).

    Two systems are the same if their keys are equal. `sine` is that of numbers or of symbols.
    """

    key: tuple[Any, ...]
    start: tuple[float, ...]
    rates: Callable[[Sequence[Any], Sine], list[Any]]
    trajectory: Callable[[Array, Array], Trajectory]


def equations(problem: Motion, *, cartesian: bool = False) -> Equations | None:
    """The equations of the scene, a rod's in its angle or `cartesian`.

    None if it is not one of the simple ones.
    """
    scene = problem.scene
    if len(scene.bodies) != 1 or scene.bodies.fixed.any():
        return None
    kinds = sorted(element.kind for element in scene.elements)
    is_pendulum = kinds == ["rod", "uniform_gravity"]
    if cartesian:
        # Only the pendulum has equations of its own in Cartesian coordinates.
        if is_pendulum:
            return _pendulum_in_the_plane(scene)
        return None
    if is_pendulum:
        return _pendulum(scene)
    if not kinds:
        return _free_body(scene)
    if kinds == ["central_field"]:
        return _kepler(scene)
    return _oscillator(scene)


def _free_body(scene: Scene) -> Equations | None:
    """Euler's equations in body axes and q' = q (0, omega) / 2; None for a body that does not turn.

    The state is omega_1, omega_2, omega_3 in body axes, then q as (w, x, y, z).
    """
    from refdem.mechanics.quaternion import conjugate, rotated

    bodies = scene.bodies
    if not bodies.omega.any():
        return None
    j1, j2, j3 = bodies.inertia[0].tolist()
    omega_body = rotated(conjugate(bodies.attitude[0]), bodies.omega[0])
    start = (*omega_body.tolist(), *bodies.attitude[0].tolist())

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        omega1, omega2, omega3, w, x, y, z = state
        # The quaternion product (w, x, y, z) (0, omega_1, omega_2, omega_3) = 2 q'.
        turn_w = -x * omega1 - y * omega2 - z * omega3
        turn_x = w * omega1 + y * omega3 - z * omega2
        turn_y = w * omega2 + z * omega1 - x * omega3
        turn_z = w * omega3 + x * omega2 - y * omega1
        return [
            # Euler's equations: J1 omega_1' = (J2 - J3) omega_2 omega_3, and cyclically.
            (j2 - j3) / j1 * (omega2 * omega3),
            (j3 - j1) / j2 * (omega3 * omega1),
            (j1 - j2) / j3 * (omega1 * omega2),
            0.5 * turn_w,
            0.5 * turn_x,
            0.5 * turn_y,
            0.5 * turn_z,
        ]

    def trajectory(t: Array, states: Array) -> Trajectory:
        lengths = np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
        attitude = states[:, 3:] / lengths
        omega = rotated(attitude, states[:, :3])
        velocity = np.broadcast_to(bodies.velocity, (len(t), 1, 3)).copy()
        position = bodies.position + (t - t[0])[:, None, None] * velocity
        return Trajectory(
            t=t,
            position=position,
            velocity=velocity,
            attitude=attitude[:, None],
            omega=omega[:, None],
        )

    return Equations(("free", j1, j2, j3), start, rates, trajectory)


def _hanging(scene: Scene) -> tuple[float, float] | None:
    """Length [m] and gravity [m/s^2] of a rod from the world's origin in the x-y plane, gravity
    along -y.
    """
    (rod,) = scene.all(Rod)
    (weight,) = scene.all(UniformGravity)
    bodies = scene.bodies
    out_of_plane = (bodies.position[0, 2], bodies.velocity[0, 2], weight.g[2])
    is_plane = weight.g[0] == 0 and not any(out_of_plane)
    hangs_at_origin = rod.b < 0 and not any((*rod.anchor_a, *rod.anchor_b))
    if not (is_plane and hangs_at_origin):
        return None
    return rod.length, -weight.g[1]


def _pendulum(scene: Scene) -> Equations | None:
    """The pendulum in its angle from the vertical: theta'' = -(g/l) sin(theta)."""
    hanging = _hanging(scene)
    if hanging is None:
        return None
    length, gravity = hanging
    x, y, _ = scene.bodies.position[0].tolist()
    vx, vy, _ = scene.bodies.velocity[0].tolist()
    angle = float(np.arctan2(x, -y))
    # theta' = (r x v)_z / l^2.
    rate = (x * vy - y * vx) / length**2
    start = (angle, rate)
    ratio = gravity / length

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        return [state[1], -ratio * sine(state[0])]

    def trajectory(t: Array, states: Array) -> Trajectory:
        # r = l (sin theta, -cos theta, 0), v = l theta' (cos theta, sin theta, 0).
        angle, rate = states.T
        s = np.sin(angle)
        c = np.cos(angle)
        zero = np.zeros(len(t))
        position = length * np.stack([s, -c, zero], axis=-1)
        velocity = (length * rate)[:, None] * np.stack([c, s, zero], axis=-1)
        return Trajectory.of_points(t, position[:, None], velocity[:, None])

    return Equations(("pendulum", ratio), start, rates, trajectory)


def _pendulum_in_the_plane(scene: Scene) -> Equations | None:
    """The pendulum in x and y: r'' = g - r (v . v + g . r)/(r . r).

    The force of the rod over r . r, not over l^2: without that a Taylor method leaves the circle.
    """
    hanging = _hanging(scene)
    if hanging is None:
        return None
    _, gravity = hanging

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        x, y, vx, vy = state
        pull = (vx * vx + vy * vy - gravity * y) / (x * x + y * y)
        return [vx, vy, -x * pull, -gravity - y * pull]

    return Equations(("constrained", gravity), _plane_start(scene), rates, _plane_motion)


def _kepler(scene: Scene) -> Equations | None:
    """r'' = -gm r/r^3 in the x-y plane."""
    bodies = scene.bodies
    gm = scene.all(CentralField)[0].gm
    if bodies.position[0, 2] or bodies.velocity[0, 2]:
        return None

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        x, y, vx, vy = state
        pull = gm * (x * x + y * y) ** -1.5
        return [vx, vy, -x * pull, -y * pull]

    return Equations(("kepler", gm), _plane_start(scene), rates, _plane_motion)


def _oscillator(scene: Scene) -> Equations | None:
    """m x'' = m g - k x - a x^2 - b x^3 along x, the spring of natural length 0."""
    others = {element.kind for element in scene.elements} - {"spring", "uniform_gravity"}
    springs = scene.all(Spring)
    if others or len(springs) != 1:
        return None
    spring = springs[0]
    if spring.length or spring.exponent != 1 or spring.b >= 0:
        return None
    position = scene.bodies.position[0]
    velocity = scene.bodies.velocity[0]
    weights = [element.g for element in scene.all(UniformGravity)]
    across = [*position[1:], *velocity[1:]]
    for g in weights:
        across += g[1:]
    if any(across) or any((*spring.anchor_a, *spring.anchor_b)):
        return None
    mass = float(scene.bodies.mass[0])
    gravity = sum(g[0] for g in weights)
    linear = spring.stiffness / mass
    square = spring.quadratic / mass
    cube = spring.cubic / mass

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        x, v = state
        # Terms with a coefficient of 0 are left out, because a peer would compute them.
        if square or cube:
            pull = x * (linear + x * (square + x * cube))
        else:
            pull = linear * x
        if gravity:
            return [v, gravity - pull]
        return [v, -pull]

    def trajectory(t: Array, states: Array) -> Trajectory:
        positions = np.zeros((len(t), 1, 3))
        velocities = np.zeros((len(t), 1, 3))
        positions[:, 0, 0] = states[:, 0]
        velocities[:, 0, 0] = states[:, 1]
        return Trajectory.of_points(t, positions, velocities)

    key = ("oscillator", gravity, linear, square, cube)
    start = (float(position[0]), float(velocity[0]))
    return Equations(key, start, rates, trajectory)


def _plane_start(scene: Scene) -> tuple[float, ...]:
    """Position x, y and velocity x, y of the body."""
    return (*scene.bodies.position[0, :2].tolist(), *scene.bodies.velocity[0, :2].tolist())


def _plane_motion(t: Array, states: Array) -> Trajectory:
    """The motion of a point in the x-y plane from its states x, y, vx, vy (T, 4)."""
    position = np.zeros((len(t), 1, 3))
    velocity = np.zeros((len(t), 1, 3))
    position[:, 0, :2] = states[:, :2]
    velocity[:, 0, :2] = states[:, 2:]
    return Trajectory.of_points(t, position, velocity)
