"""A point on a line under polynomial and periodic forces, by Taylor series to round-off
(kernels/taylor_oscillator.c).

    m x'' = -(k x + q x^2 + c x^3) - (d + e (x + offset)^2) x' + weight + sum f_i cos(w_i t +
    phase_i).
"""

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver
from refdem.solvers._line_trial import series_call, unsupported_times


class TaylorOscillator(KernelSolver):
    """Springs with a quadratic and a cubic term, a van der Pol dashpot, and any number of periodic
    forces.
    """

    claims = Method(
        name="taylor-oscillator",
        summary="Taylor series of order 24, the step such that they end at round-off",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=5,
    )
    kernels = ("taylor_oscillator",)

    pattern = _line.PATTERN

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for forces that are polynomials in x and v and not merely harmonic, else the
        reason.
        """
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if spring.exponent not in (1, 3):
            return "the force of the spring is no polynomial"
        if spring.quadratic and not spring.length:
            return "the square of a stretch that is never negative is no polynomial of the place"
        if single.is_linear(spring) and not {"dashpot", "force"} & scene.features:
            return "the motion is harmonic"
        return _line.askew(scene)

    def unsupported_times(self, problem: Motion) -> str | None:
        """None if the motion stays finite and on its side of the spring's anchor, else the
        reason.
        """
        return unsupported_times(problem)

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line; rows for x, v and work."""
        return series_call(_line.line_of(request.problem.scene), request.problem.times)

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and the work done against damping and drives at the samples."""
        scene = request.problem.scene
        x, v, work = call.outputs[0].T
        channels = {}
        if not scene.is_conservative():
            channels["dissipated_work"] = work.copy()
        line = _line.line_of(scene)
        return line.trajectory(request.problem.times, x, v, channels=channels)


METHOD = TaylorOscillator()
