"""A point that falls, or is thrown up, against quadratic drag: tan on the way up, Riccati's
solution on the way down.

Scaled variables: u is the velocity along gravity in units of the terminal velocity v_t = sqrt(m
g/c), s = g t/v_t the time, and X the distance in units of v_t^2/g. Then m v' = m g - c |v| v reads

    X' = u,   u' = 1 - |u| u              (' is d/ds).
"""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene import Scene
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._line import ASKEW
from refdem.solvers._scene_pattern import ONE, SOME, ScenePattern, SceneSolver

Array = NDArray[np.float64]


class ExactDrag(SceneSolver):
    """One point whose velocity is along gravity, in a fluid at rest."""

    claims = Method(
        name="exact-drag",
        summary="fall with quadratic drag in closed form",
        control="exact",
        cost_rank=1,
    )

    pattern = ScenePattern(
        elements={Drag: ONE, UniformGravity: SOME},
        bodies=ONE,
        only_points=True,
        irreversible="before some time in the past the velocity is infinite",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a body that moves along gravity against a drag that is not zero."""
        scene = problem.scene
        drag = scene.all(Drag)[0]
        if drag.b >= 0:
            return "a drag between bodies"
        if not drag.coefficient > 0:
            return "the drag is zero"
        weight = single.gravity(scene)
        strength = float(np.linalg.norm(weight))
        if not strength > 0:
            return "no gravity"
        velocity = scene.bodies.velocity[0]
        across = velocity - (velocity @ weight) / strength**2 * weight
        if np.linalg.norm(across) > ASKEW * np.linalg.norm(velocity):
            return "the motion is not along one line"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Positions and velocities at the samples, along the direction of gravity."""
        begun = perf_counter()
        scene = request.problem.scene
        times = request.problem.times
        terminal = terminal_velocity(scene)
        weight = single.gravity(scene)
        gravity = float(np.linalg.norm(weight))
        down = weight / gravity
        start = float(scene.bodies.velocity[0] @ down) / terminal
        started = perf_counter()
        # s = g t/v_t; then x = X v_t^2/g and v = u v_t.
        way, speed = fallen(start, gravity * (times - times[0]) / terminal)
        position = scene.bodies.position + (way * terminal**2 / gravity)[:, None, None] * down
        velocity = (speed * terminal)[:, None, None] * down
        seconds = perf_counter() - started
        trajectory = Trajectory.of_points(times, position, velocity)
        return trajectory, Cost(seconds=seconds, setup=started - begun)


def terminal_velocity(scene: Scene) -> float:
    """The terminal velocity v_t = sqrt(m g/c) [m/s]."""
    mass = float(scene.bodies.mass[0])
    gravity = float(np.linalg.norm(single.gravity(scene)))
    return float(np.sqrt(mass * gravity / scene.all(Drag)[0].coefficient))


def fallen(start: float, s: Array) -> tuple[Array, Array]:
    """X and u (T,) at scaled times s (T,) after a start with the velocity `start` along gravity."""
    if start >= 0:
        return _down(start, s)
    # The turning point is at s1 = arctan(-u0) and X = -ln sqrt(1 + u0^2), above the start.
    top_time = np.arctan(-start)
    top = -0.5 * np.log1p(start**2)
    way_down, speed_down = _down(0.0, np.maximum(s - top_time, 0.0))
    way_up, speed_up = _up(start, np.minimum(s, top_time))
    is_rising = s < top_time
    return np.where(is_rising, way_up, top + way_down), np.where(is_rising, speed_up, speed_down)


def _down(start: float, s: Array) -> tuple[Array, Array]:
    """X = ln(cosh s + u0 sinh s) and u = (u0 + tanh s)/(1 + u0 tanh s)."""
    tangent = np.tanh(s)
    # X = s + ln(1 + (u0 - 1)(1 - exp(-2 s))/2) does not overflow at large s, but cancels at small
    # s, where X = ln(1 + 2 sinh^2(s/2) + u0 sinh s) is used.
    large = s + np.log1p((start - 1) * -np.expm1(-2 * s) / 2)
    near = np.minimum(s, 1.0)
    small = np.log1p(2 * np.sinh(near / 2) ** 2 + start * np.sinh(near))
    way = np.where(s < 1.0, small, large)
    return way, (start + tangent) / (1 + start * tangent)


def _up(start: float, s: Array) -> tuple[Array, Array]:
    """X = -ln(cos s - u0 sin s) and u = tan(s + arctan u0), for u0 < 0 up to the turning point."""
    sine = np.sin(s)
    # cos s - u0 sin s = 1 + excess, excess = -2 sin^2(s/2) - u0 sin s; u = (sin s + u0 cos s)/(1 +
    # excess).
    excess = -2 * np.sin(s / 2) ** 2 - start * sine
    speed = (sine + start * np.cos(s)) / (1 + excess)
    return -np.log1p(excess), speed


METHOD = ExactDrag()
