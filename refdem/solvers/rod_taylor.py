"""A point on a rod in uniform gravity, in three dimensions, in Cartesian coordinates with the force
of the rod (kernels/rod_taylor.c).

    r' = v,   v' = g - lambda r,   lambda = (v . v + g . r)/l^2,   tension = m l lambda.
"""

from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern

Array = NDArray[np.float64]
FITS = 1e-9
"""Relative error of length and speed at the start that counts as rounding."""


class RodTaylor(KernelSolver):
    """The plane and the spherical pendulum, without angles, so that no direction is singular."""

    claims = Method(
        name="rod-taylor",
        summary=(
            "a point on a rod in Cartesian coordinates: Taylor series of order 24, held to the rod"
            " after each step"
        ),
        control="exact",
        conserves=frozenset({"energy", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=3,
    )
    kernels = ("rod_taylor",)

    pattern = ScenePattern(elements={Rod: ONE, UniformGravity: ANY}, bodies=ONE, only_points=True)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a point that starts on its rod without a speed along it, else the reason."""
        scene = problem.scene
        rod = scene.all(Rod)[0]
        arm = scene.bodies.position[0] - single.anchor(rod)
        velocity = scene.bodies.velocity[0]
        distance = float(np.linalg.norm(arm))
        speed = float(np.linalg.norm(velocity))
        if abs(distance - rod.length) > FITS * rod.length:
            return f"the rod of length {rod.length} starts {distance} long"
        if abs(float(arm @ velocity)) > FITS * rod.length * speed:
            return "the point starts with a speed along the rod"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Mass, rod, gravity and start in the kernel's unit of time."""
        scene = request.problem.scene
        t = request.problem.times
        rod = scene.all(Rod)[0]
        bodies = scene.bodies
        unit = _time_unit(scene)
        # In time units of u seconds accelerations are multiplied by u^2 and velocities by u.
        gravity = single.gravity(scene) * unit**2
        velocity = bodies.velocity[0] * unit
        constants = (float(bodies.mass[0]), rod.length, gravity, single.anchor(rod))
        return KernelCall(
            function="refdem_rod_taylor",
            inputs=(*constants, bodies.position[0], velocity),
            clock=samples_from_start(t / unit),
            outputs=(np.empty((len(t), 1, 3)), np.empty((len(t), 1, 3)), np.empty((len(t), 1))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and rod force [N] at the samples; raises EngineError if the series do
        not reach them.
        """
        position, velocity, force = call.outputs
        if not np.isfinite(force).all():
            raise EngineError(
                "rod-taylor: the series do not reach the last sample; expected a motion of finite"
                " speed"
            )
        unit = _time_unit(request.problem.scene)
        channels = {"rod_force": force / unit**2}
        t = request.problem.times
        return Trajectory.of_points(t, position, velocity / unit, channels=channels)


def _time_unit(scene: Scene) -> float:
    """The kernel's unit of time [s], near the shorter of sqrt(l/g) and l/|v|."""
    length = scene.all(Rod)[0].length
    swing = swing_time(length, single.gravity(scene))
    turn = turn_time(length, scene.bodies.velocity[0])
    return single.time_unit([swing, turn])


def swing_time(length: float, gravity: Array) -> float:
    """sqrt(l/g) [s]; infinite without gravity."""
    g = float(np.linalg.norm(gravity))
    if g > 0:
        return sqrt(length / g)
    return inf


def turn_time(length: float, velocity: Array) -> float:
    """l/|v| [s], the time in which the point moves by the length of the rod; infinite at rest."""
    speed = float(np.linalg.norm(velocity))
    if speed > 0:
        return length / speed
    return inf


METHOD = RodTaylor()
