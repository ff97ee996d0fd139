"""Free rigid bodies by exact rotations about the principal axes: half 1, half 2, whole 3, half 2, half 1 (Touma and Wisdom 1994)."""

from time import perf_counter

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.kernels import load, pointer
from refdem.solvers._free_bodies import Array, FreeBodies, first_state


class SplittingFreeBody(FreeBodies):
    """Symmetric Strang splitting of the kinetic energy (McLachlan 1993; Reich 1994); L in space is kept to round-off."""

    claims = Method(
        name="splitting-free-body",
        summary="symmetric splitting of the free rigid body into exact rotations about its principal axes",
        control="step",
        order=2,
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=20,
    )
    kernels = ("rigid_body",)

    def refusal(self, problem: Motion) -> str | None:
        """None if nothing acts on any body and some body turns."""
        idle = None if "rotation" in problem.scene.features else "nothing turns; uniform motion needs no steps"
        return super().refusal(problem) or idle

    def turn(self, request: Request, number: int, attitude: Array, omega: Array) -> float:
        """Attitude (T, 4) and omega (T, 3) after every `stride` steps."""
        state = [pointer("rigid_body", column) for column in first_state(request.problem.scene.bodies, number)]
        out = [pointer("rigid_body", column, output=True) for column in (attitude, omega)]
        lib = load("rigid_body").lib
        started = perf_counter()
        lib.refdem_rigid_body_splitting(*state, request.signed_step, len(request.problem.times), request.stride, *out)
        return perf_counter() - started


METHOD = SplittingFreeBody()
