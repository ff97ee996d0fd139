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

    `key` tells equal systems.
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
    kinds = sorted(element.kind for element in scene.elements)
    if len(scene.bodies) != 1 or scene.bodies.fixed.any():
        return None
    if not kinds:
        if cartesian or not scene.bodies.omega.any():
            return None
        return _free_body(scene)
    if kinds == ["rod", "uniform_gravity"]:
        if cartesian:
            return _constrained(scene)
        return _pendulum(scene)
    if cartesian:
        return None
    if kinds == ["central_field"]:
        return _kepler(scene)
    return _oscillator(scene)


def _free_body(scene: Scene) -> Equations:
    """Euler's equations in body axes and q' = q omega / 2."""
    from refdem.mechanics.quaternion import conjugate, rotated

    bodies = scene.bodies
    j1, j2, j3 = bodies.inertia[0].tolist()
    omega_body = rotated(conjugate(bodies.attitude[0]), bodies.omega[0])
    start = (*omega_body.tolist(), *bodies.attitude[0].tolist())

    def rates(y: Sequence[Any], sine: Sine) -> list[Any]:
        p, q, r, w, x, u, z = y
        # Euler's equations: J1 p' = (J2 - J3) q r, and cyclically.
        p_rate = (j2 - j3) / j1 * (q * r)
        q_rate = (j3 - j1) / j2 * (r * p)
        r_rate = (j1 - j2) / j3 * (p * q)
        # The quaternion product (w, x, u, z) (0, p, q, r), twice the rate of the attitude.
        turn_w = -x * p - u * q - z * r
        turn_x = w * p + u * r - z * q
        turn_u = w * q + z * p - x * r
        turn_z = w * r + x * q - u * p
        return [
            p_rate,
            q_rate,
            r_rate,
            0.5 * turn_w,
            0.5 * turn_x,
            0.5 * turn_u,
            0.5 * turn_z,
        ]

    def trajectory(t: Array, y: Array) -> Trajectory:
        attitude = y[:, 3:] / np.linalg.norm(y[:, 3:], axis=1, keepdims=True)
        velocity = np.broadcast_to(bodies.velocity, (len(t), 1, 3)).copy()
        place = bodies.position + (t - t[0])[:, None, None] * velocity
        return Trajectory(
            t=t,
            position=place,
            velocity=velocity,
            attitude=attitude[:, None],
            omega=rotated(attitude, y[:, :3])[:, None],
        )

    return Equations(("free", j1, j2, j3), start, rates, trajectory)


def _hanging(scene: Scene) -> tuple[float, float] | None:
    """Length [m] and gravity [m/s^2] of a rod from the world's origin in the x-y plane, gravity
    along -y.
    """
    (rod,) = scene.all(Rod)
    (weight,) = scene.all(UniformGravity)
    bodies = scene.bodies
    sideways = (
        bodies.position[0, 2],
        bodies.velocity[0, 2],
        weight.g[0],
        weight.g[2],
        *rod.anchor_a,
        *rod.anchor_b,
    )
    if any(sideways) or rod.b >= 0:
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
        angle, rate = states.T
        s = np.sin(angle)
        c = np.cos(angle)
        zero = np.zeros(len(t))
        place = length * np.stack([s, -c, zero], axis=-1)
        speed = (length * rate)[:, None] * np.stack([c, s, zero], axis=-1)
        return Trajectory.of_points(t, place[:, None], speed[:, None])

    return Equations(("pendulum", ratio), start, rates, trajectory)


def _constrained(scene: Scene) -> Equations | None:
    """r'' = g - r (v.v + g.r)/(r.r): the multiplier divided by r^2, without which a Taylor method
    leaves the circle.
    """
    hanging = _hanging(scene)
    if hanging is None:
        return None
    _, gravity = hanging

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        x, y, vx, vy = state
        pull = (vx * vx + vy * vy - gravity * y) / (x * x + y * y)
        return [vx, vy, -x * pull, -gravity - y * pull]

    return Equations(("constrained", gravity), _plane(scene), rates, _of_plane)


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

    return Equations(("kepler", gm), _plane(scene), rates, _of_plane)


def _oscillator(scene: Scene) -> Equations | None:
    """m x'' = m g - k x - a x^2 - b x^3 along x, the spring of natural length 0."""
    others = {element.kind for element in scene.elements} - {"spring", "uniform_gravity"}
    if others or len(scene.all(Spring)) != 1:
        return None
    (spring,) = scene.all(Spring)
    mass = float(scene.bodies.mass[0])
    weights = [element.g for element in scene.all(UniformGravity)]
    place = scene.bodies.position[0]
    speed = scene.bodies.velocity[0]
    aside = [*place[1:], *speed[1:], *spring.anchor_a, *spring.anchor_b]
    for g in weights:
        aside += g[1:]
    if any(aside) or spring.length or spring.exponent != 1 or spring.b >= 0:
        return None
    weight = sum(g[0] for g in weights)
    linear = spring.stiffness / mass
    square = spring.quadratic / mass
    cube = spring.cubic / mass

    def rates(state: Sequence[Any], sine: Sine) -> list[Any]:
        x, v = state
        if not (square or cube):
            force = linear * x
        else:
            force = x * (linear + x * (square + x * cube))
        if not weight:
            return [v, -force]
        return [v, weight - force]

    def trajectory(t: Array, states: Array) -> Trajectory:
        places = np.zeros((len(t), 1, 3))
        speeds = np.zeros((len(t), 1, 3))
        places[:, 0, 0], speeds[:, 0, 0] = states.T
        return Trajectory.of_points(t, places, speeds)

    return Equations(
        ("oscillator", weight, linear, square, cube),
        (float(place[0]), float(speed[0])),
        rates,
        trajectory,
    )


def _plane(scene: Scene) -> tuple[float, ...]:
    """Place and velocity in the x-y plane."""
    return (*scene.bodies.position[0, :2].tolist(), *scene.bodies.velocity[0, :2].tolist())


def _of_plane(t: Array, states: Array) -> Trajectory:
    """The motion of a point in the x-y plane from (T, 4)."""
    place = np.zeros((len(t), 1, 3))
    speed = np.zeros((len(t), 1, 3))
    place[:, 0, :2] = states[:, :2]
    speed[:, 0, :2] = states[:, 2:]
    return Trajectory.of_points(t, place, speed)
