"""An outline carried by a linear flow in the open, for faults to be planted in: x'' + 2 delta x' +
w0^2 x = 0, start by start.
"""

from cmath import exp, sqrt
from collections.abc import Callable
from typing import Any

import numpy as np

from refdem.core.problem import Ensemble
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring


def linear_flow(x: float, v: float, square: float, delta: float, t: float) -> tuple[float, float]:
    """Place and velocity after t: the real parts of two exponentials."""
    root = sqrt(delta * delta - square)
    fast = -delta + root
    slow = -delta - root
    a = (v - slow * x) / (fast - slow)
    b = (fast * x - v) / (fast - slow)
    first = a * exp(fast * t)
    second = b * exp(slow * t)
    return (first + second).real, (fast * first + slow * second).real


def carried(problem: Ensemble, flow: Callable[..., Any]) -> Trajectory:
    """`position` and `velocity` (T, M, 1, 3) of starts along x."""
    scene = problem.scene
    mass = float(scene.bodies.mass[0])
    square = scene.all(Spring)[0].stiffness / mass
    delta = sum(dashpot.damping for dashpot in scene.all(Dashpot)) / (2 * mass)
    shape = (len(problem.times), len(problem.position), 1, 3)
    position = np.zeros(shape)
    velocity = np.zeros(shape)
    starts = list(
        zip(problem.position[:, 0, 0].tolist(), problem.velocity[:, 0, 0].tolist(), strict=True)
    )
    for sample, t in enumerate((problem.times - problem.times[0]).tolist()):
        for member, (x, v) in enumerate(starts):
            position[sample, member, 0, 0], velocity[sample, member, 0, 0] = flow(
                x, v, square, delta, t
            )
    return Trajectory.of_values(problem.times, {"position": position, "velocity": velocity})
