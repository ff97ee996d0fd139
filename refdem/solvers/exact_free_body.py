"""Free bodies in closed form: Euler's equations by Jacobi functions, attitude by one theta function
(kernels/free_body.c).
"""

from refdem.core.engine import Method
from refdem.core.problem import Request
from refdem.kernels import load, pointer, prepared, timed
from refdem.solvers._free_bodies import Array, FreeBodies, first_state


class ExactFreeBody(FreeBodies):
    """Any number of free bodies, each at any time at once."""

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

    def turn(self, request: Request, number: int, attitude: Array, omega: Array) -> float:
        """Attitude (T, 4) and omega (T, 3) at the samples; errors of a few ulp."""
        t = request.problem.times
        state = [
            pointer("free_body", column)
            for column in first_state(request.problem.scene.bodies, number)
        ]
        out = [pointer("free_body", column, output=True) for column in (attitude, omega)]
        lib = load("free_body").lib
        motion = prepared("free_body")
        lib.refdem_free_body_prepare(*state, t[0], len(t), pointer("free_body", t), *out, motion)
        return timed(lib.refdem_free_body_run, motion)


METHOD = ExactFreeBody()
