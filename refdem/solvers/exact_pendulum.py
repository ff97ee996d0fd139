"""A point on a rod in uniform gravity, moving in a plane, in closed form by Jacobi functions
(kernels/pendulum.c): theta'' = -(g/l) sin(theta).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern

PLANAR = 1e-12
"""Relative velocity out of the plane or along the rod that is round-off of a scene that was
rotated.
"""


class ExactPendulum(KernelSolver):
    """Swinging, rotating, on the separatrix, or at rest at the bottom or the top, in any plane that
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

    pattern = ScenePattern(elements={Rod: ONE, UniformGravity: ANY}, bodies=ONE, only_points=True)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a point on the rod whose motion is in a plane with gravity, else the reason."""
        return _misfit(problem.scene)

    def prepare(self, request: Request) -> KernelCall:
        """Mass, rod, gravity and start; arrays for position, velocity and rod force."""
        scene = request.problem.scene
        t = request.problem.times
        rod = scene.all(Rod)[0]
        bodies = scene.bodies
        constants = (bodies.mass[0], rod.length, single.gravity(scene), single.anchor(rod))
        shapes = ((len(t), 1, 3), (len(t), 1, 3), (len(t), 1))
        return KernelCall(
            function="refdem_pendulum",
            inputs=(*constants, bodies.position[0], bodies.velocity[0]),
            clock=samples_from_start(t),
            # Filled and not only allocated, so that page faults of fresh memory count as set-up.
            outputs=tuple(np.full(shape, np.nan) for shape in shapes),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and rod force [N] at the samples."""
        position, velocity, force = call.outputs
        channels = {"rod_force": force}
        return Trajectory.of_points(request.problem.times, position, velocity, channels=channels)


def _misfit(scene: Scene) -> str | None:
    """None if position and velocity fit a rod that swings in a plane, else the reason."""
    rod = scene.all(Rod)[0]
    arm = scene.bodies.position[0] - single.anchor(rod)
    velocity = scene.bodies.velocity[0]
    gravity = single.gravity(scene)
    speed = float(np.linalg.norm(velocity))
    distance = float(np.linalg.norm(arm))
    if abs(distance - rod.length) > 1e-9 * rod.length:
        return f"the rod of length {rod.length} starts {distance} long"
    if abs(arm @ velocity) > PLANAR * distance * speed:
        return "the point starts with a speed along the rod"
    g = float(np.linalg.norm(gravity))
    # The normal of the plane of arm and gravity must be perpendicular to the velocity.
    out_of_plane = abs(np.cross(arm, gravity) @ velocity)
    if out_of_plane > PLANAR * distance * g * speed:
        return "the motion is not in a plane: a spherical pendulum"
    return None


METHOD = ExactPendulum()
