"""Free rigid bodies in closed form: Euler's equations by Jacobi functions, the attitude by theta
functions (kernels/free_body.c).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.solvers._free_bodies import FreeBodies, first_state
from refdem.solvers._kernel_solver import KernelCall, samples_from_start


class ExactFreeBody(FreeBodies):
    """Any number of free bodies, at any time without steps."""

    claims = Method(
        name="exact-free-body",
        summary=(
            "free rigid bodies in closed form: Jacobi functions for omega, a theta function for the"
            " attitude"
        ),
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum", "energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("free_body",)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None: every free body is supported, rotating or not."""
        return None

    def turn(self, request: Request, body: int) -> KernelCall:
        """The call that fills attitude (T, 4) and omega (T, 3) at the samples, with errors of a few
        ulp.
        """
        t = request.problem.times
        return KernelCall(
            function="refdem_free_body",
            inputs=first_state(request.problem.scene.bodies, body),
            clock=samples_from_start(t),
            outputs=(np.empty((len(t), 4)), np.empty((len(t), 3))),
        )


METHOD = ExactFreeBody()
