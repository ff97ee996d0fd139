"""Free rigid bodies by the classical Runge-Kutta method on the quaternion and the body's angular momentum (Kutta 1901)."""

from time import perf_counter

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.kernels import load, pointer
from refdem.solvers._free_bodies import Array, FreeBodies, first_state


class Rk4FreeBody(FreeBodies):
    """Order 4, neither symplectic nor reversible: there to be measured."""

    claims = Method(
        name="rk4-free-body",
        summary="classical Runge-Kutta on the quaternion and the angular momentum in body axes",
        control="step",
        order=4,
        conserves=frozenset({"momentum"}),
        backward=True,
        cost_rank=30,
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
        lib.refdem_rigid_body_rk4(*state, request.signed_step, len(request.problem.times), request.stride, *out)
        return perf_counter() - started


METHOD = Rk4FreeBody()
