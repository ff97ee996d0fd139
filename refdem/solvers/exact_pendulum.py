"""A point on a rod to the world in uniform gravity, in closed form (kernels/pendulum.c)."""

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
"""Part of the speed that may point out of the plane or along the rod: round-off of a scene turned
into some other plane.
"""


class ExactPendulum(KernelSolver):
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

    pattern = ScenePattern(elements={Rod: ONE, UniformGravity: ANY}, bodies=ONE, only_points=True)

    def unfit(self, problem: Motion) -> str | None:
        """None for a point that moves on the rod in a plane with gravity."""
        return _astray(problem.scene)

    def prepare(self, request: Request) -> KernelCall:
        """Mass, rod, gravity and start, and columns for position, velocity and rod force."""
        scene = request.problem.scene
        t = request.problem.times
        rod = scene.all(Rod)[0]
        bodies = scene.bodies
        hung = (bodies.mass[0], rod.length, single.gravity(scene), single.anchor(rod))
        shapes = ((len(t), 1, 3), (len(t), 1, 3), (len(t), 1))
        return KernelCall(
            function="refdem_pendulum",
            inputs=(*hung, bodies.position[0], bodies.velocity[0]),
            clock=samples_from_start(t),
            # Filled, not only allocated: the first touch of memory is set-up.
            outputs=tuple(np.full(shape, np.nan) for shape in shapes),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and rod force [N] at the samples."""
        position, velocity, force = call.outputs
        channels = {"rod_force": force}
        return Trajectory.of_points(request.problem.times, position, velocity, channels=channels)


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
