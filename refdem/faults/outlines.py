"""An outline carried by the linear flow x'' + 2 delta x' + w0^2 x = 0, start by start, in plain
Python into which faults are planted.
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
    """Position [m] and velocity [m/s] after t [s] of x'' + 2 delta x' + w0^2 x = 0, for delta !=
    w0; `square` is w0^2.

    x(t) = a exp(l1 t) + b exp(l2 t), whose real part is taken: the roots may be complex.
    """
    # l1, l2 = -delta +- sqrt(delta^2 - w0^2).
    root = sqrt(delta * delta - square)
    l1 = -delta + root
    l2 = -delta - root
    # a + b = x and l1 a + l2 b = v.
    a = (v - l2 * x) / (l1 - l2)
    b = (l1 * x - v) / (l1 - l2)
    first = a * exp(l1 * t)
    second = b * exp(l2 * t)
    return (first + second).real, (l1 * first + l2 * second).real


def carried(problem: Ensemble, flow: Callable[..., Any]) -> Trajectory:
    """The trajectory of all starts along x, with `position` and `velocity` (T, M, 1, 3)."""
    scene = problem.scene
    mass = float(scene.bodies.mass[0])
    # w0^2 = k/m, 2 delta = c/m.
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
