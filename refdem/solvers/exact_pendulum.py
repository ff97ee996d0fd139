"""A point on a rod to the world in uniform gravity, in closed form (kernels/pendulum.c)."""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer, prepared, timed
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver

PLANAR = 1e-12
"""Part of the speed that may point out of the plane or along the rod: round-off of a scene turned
into some other plane.
"""


class ExactPendulum(Solver):
    """Swinging, rotating, on the separatrix, at rest at the bottom or at the top, in any plane that
    contains gravity.
    """

    claims = Method(
        name="exact-pendulum",
        summary="plane pendulum in closed form: Jacobi functions, their phase in double-double",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("pendulum",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one point on one rod to the world that moves in a plane with gravity."""
        scene = problem.scene
        reason = single.unsupported(scene, Rod)
        if reason:
            return reason
        if scene.bodies.fixed.any():
            return "the rod does not hang from the world"
        return _astray(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and rod force [N] at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        rod = scene.all(Rod)[0]
        given = (
            single.gravity(scene),
            single.anchor(rod),
            scene.bodies.position[0].copy(),
            scene.bodies.velocity[0].copy(),
        )
        # Filled, not only allocated: the first touch of memory is set-up.
        position = np.full((len(t), 1, 3), np.nan)
        velocity = np.full((len(t), 1, 3), np.nan)
        force = np.full((len(t), 1), np.nan)
        columns = [pointer("pendulum", column) for column in given]
        out = [pointer("pendulum", column, output=True) for column in (position, velocity, force)]
        lib = load("pendulum").lib
        motion = prepared("pendulum")
        body = (scene.bodies.mass[0], rod.length, *columns)
        samples = pointer("pendulum", t)
        lib.refdem_pendulum_prepare(*body, t[0], len(t), samples, *out, motion)
        started = perf_counter()
        seconds = timed(lib.refdem_pendulum_run, motion)
        cost = Cost(seconds=seconds, setup=started - begun)
        return Trajectory.of_points(t, position, velocity, channels={"rod_force": force}), cost


def _astray(scene: Scene) -> str | None:
    """None if position and velocity agree with a rod that swings in a plane."""
    rod = scene.all(Rod)[0]
    arm = scene.bodies.position[0] - single.anchor(rod)
    velocity = scene.bodies.velocity[0]
    gravity = single.gravity(scene)
    speed = float(np.linalg.norm(velocity))
    reach = float(np.linalg.norm(arm))
    if abs(reach - rod.length) > 1e-9 * rod.length:
        return f"the rod of length {rod.length} starts {reach} long"
    if abs(arm @ velocity) > PLANAR * reach * speed:
        return "the point starts with a speed along the rod"
    pull = float(np.linalg.norm(gravity))
    out_of_plane = abs(np.cross(arm, gravity) @ velocity)
    if out_of_plane > PLANAR * reach * pull * speed:
        return "the motion is not in a plane: a spherical pendulum"
    return None


METHOD = ExactPendulum()
