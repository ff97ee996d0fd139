"""A point on a rod to the world, in space, in Cartesian coordinates with its constraint force
(kernels/rod_taylor.c).
"""

from math import inf, sqrt
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer, timed
from refdem.scene.elements.rod import Rod
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]
FITS = 1e-9
"""Part of a length, or of a speed, by which the start may miss what a rigid rod allows: rounding.
"""


class RodTaylor(Solver):
    """The plane and the spherical pendulum: no angles, so that no direction is special."""

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

    def unsupported(self, problem: Motion) -> str | None:
        """None for one point on one rod to the world, in gravity or none."""
        scene = problem.scene
        reason = single.unsupported(scene, Rod)
        if reason:
            return reason
        rod = scene.all(Rod)[0]
        if scene.bodies.fixed.any():
            return "the rod does not hang from the world"
        arm = scene.bodies.position[0] - single.anchor(rod)
        velocity = scene.bodies.velocity[0]
        if abs(float(np.linalg.norm(arm)) - rod.length) > FITS * rod.length:
            return f"the rod of length {rod.length} starts {float(np.linalg.norm(arm))} long"
        along = abs(float(arm @ velocity)) > FITS * rod.length * float(np.linalg.norm(velocity))
        if along:
            return "the point starts with a speed along the rod"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and rod force [N] at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        rod = scene.all(Rod)[0]
        mass = float(scene.bodies.mass[0])
        gravity = single.gravity(scene)
        speed = scene.bodies.velocity[0]
        # The kernel's unit of time [s]: accelerations are as its square, velocities as it.
        unit = single.time_unit([swing_time(rod.length, gravity), turn_time(rod.length, speed)])
        place = scene.bodies.position[0].copy()
        given = (gravity * unit**2, single.anchor(rod), place, speed * unit)
        clock = np.ascontiguousarray(t / unit)
        position = np.empty((len(t), 1, 3))
        velocity = np.empty((len(t), 1, 3))
        force = np.empty((len(t), 1))
        columns = [pointer("rod_taylor", column) for column in given]
        samples = pointer("rod_taylor", clock)
        out = [pointer("rod_taylor", column, output=True) for column in (position, velocity, force)]
        body = (mass, rod.length, *columns)
        arguments = (*body, float(clock[0]), len(t), samples, *out)
        started = perf_counter()
        seconds = timed(load("rod_taylor").lib.refdem_rod_taylor, *arguments)
        cost = Cost(seconds=seconds, setup=started - begun)
        if not np.isfinite(force).all():
            raise EngineError(
                "rod-taylor: the series do not reach the last sample; expected a motion of finite"
                " speed"
            )
        channels = {"rod_force": force / unit**2}
        return Trajectory.of_points(t, position, velocity / unit, channels=channels), cost


def swing_time(length: float, gravity: Array) -> float:
    """sqrt(l/g) [s]; infinite without gravity."""
    size = float(np.linalg.norm(gravity))
    if size > 0:
        return sqrt(length / size)
    return inf


def turn_time(length: float, velocity: Array) -> float:
    """The time l/|v| [s] in which the point would fly a rod's length; infinite at rest."""
    size = float(np.linalg.norm(velocity))
    if size > 0:
        return length / size
    return inf


METHOD = RodTaylor()
