"""A free body with internal damping, by Taylor series in angular momentum and attitude
(kernels/dissipating_body.c).

In principal axes, with w = J^-1 L and W = w + c L x w (Bloch, Krishnaprasad, Marsden and Ratiu
1996):

    L' = L x W,   q' = q W/2.
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene.elements.internal_damping import InternalDamping
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples
from refdem.solvers._scene_pattern import ONE, ScenePattern


class DissipatingBody(KernelSolver):
    """Angular momentum in principal axes and attitude by Taylor series; the centre moves
    uniformly.
    """

    claims = Method(
        name="dissipating-body",
        summary="a body that loses energy inside: Taylor series of order 20, steps to round-off",
        control="exact",
        derived={
            "attitude": (
                "the attitude is divided by its length when it is handed out, so that it is"
                " always 1"
            ),
            "dissipated_work": (
                "it is reported as the loss of energy, so that the balance always holds"
            ),
        },
        conserves=frozenset({"momentum", "angular-momentum"}),
        backward=True,
        cost_rank=2,
    )
    kernels = ("dissipating_body",)

    pattern = ScenePattern(elements={InternalDamping: ONE}, bodies=ONE, has_inertia=True)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None: every body with inertia and internal damping is supported."""
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Moments of inertia, damping, and rows of 7: angular momentum in principal axes [kg
        m^2/s], attitude.
        """
        scene = request.problem.scene
        t = request.problem.times
        bodies = scene.bodies
        inertia = bodies.inertia[0]
        attitude = bodies.attitude[0]
        # L = J R^T omega in principal axes.
        momentum = inertia * rotated(conjugate(attitude), bodies.omega[0])
        states = np.empty((len(t), 7))
        states[0] = np.concatenate([momentum, attitude])
        return KernelCall(
            function="refdem_dissipating_body",
            inputs=(inertia, scene.all(InternalDamping)[0].coefficient),
            clock=samples(t),
            outputs=(states,),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States and dissipated work at the samples; raises EngineError if the kernel stopped
        early.
        """
        t = request.problem.times
        if status:
            raise EngineError(
                f"dissipating-body: no step leads to t = {t[status - 1]:.6g} s; take a smaller"
                " damping or duration"
            )
        bodies = request.problem.scene.bodies
        inertia = bodies.inertia[0]
        (states,) = call.outputs
        momentum = states[:, :3]
        attitude = states[:, 3:] / np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
        # omega = R J^-1 L in space axes.
        omega = rotated(attitude, momentum / inertia)
        omega[0] = bodies.omega[0]
        # T = sum L_k^2/(2 J_k). The dissipated work is T(0) - T(t).
        energy = 0.5 * np.sum(momentum**2 / inertia, axis=1)
        displacement = (t - t[0])[:, None, None] * bodies.velocity
        return Trajectory(
            t=t,
            position=bodies.position + displacement,
            velocity=np.broadcast_to(bodies.velocity, displacement.shape).copy(),
            attitude=attitude[:, None],
            omega=omega[:, None],
            channels={"dissipated_work": energy[0] - energy},
        )


METHOD = DissipatingBody()
