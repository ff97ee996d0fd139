"""Lorenz' three equations by Taylor series (kernels/lorenz.c).

    x' = sigma (y - x),   y' = x (rho - z) - y,   z' = x y - beta z

(Lorenz, J. Atmos. Sci. 20 (1963) 130).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.maps import LorenzFlow
from refdem.core.problem import Iteration, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.solvers._kernel_solver import KernelCall, KernelRun, Struct, samples


class Lorenz(KernelRun):
    """Taylor series whose last terms are below round-off; samples are evaluated from the series."""

    claims = Method(
        name="lorenz-taylor",
        summary="Lorenz' three equations by Taylor series of order 20, to round-off",
        control="exact",
        cost_rank=0,
    )
    answers = Iteration
    kernels = ("lorenz",)

    def unsupported(self, problem: Iteration) -> str | None:
        """None for the flow of Lorenz' equations, else the reason."""
        if isinstance(problem.map, LorenzFlow):
            return None
        return f"the map {problem.map.kind} is not the flow of Lorenz' equations"

    def prepare(self, request: Request) -> KernelCall:
        """The parameters of the equations; rows for the requested iterates, of which the first is
        the start.
        """
        problem = request.problem
        assert isinstance(problem, Iteration)
        assert isinstance(problem.map, LorenzFlow)
        flow = problem.map
        numbers = {
            "sigma": flow.sigma,
            "rho": flow.rho,
            "beta": flow.beta,
            "interval": flow.interval,
        }
        rows = np.empty((len(problem.times), flow.dimension))
        rows[0] = problem.start
        return KernelCall(
            function="refdem_lorenz",
            inputs=(Struct("lorenz", "refdem_lorenz_numbers", numbers),),
            clock=samples(problem.times),
            outputs=(rows,),
            steps=problem.n,
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """The states: `state` (T, 3)."""
        if status:
            iterate = request.problem.times[status - 1]
            raise EngineError(f"the series stops converging before iterate {iterate:.0f}")
        (rows,) = call.outputs
        return Trajectory.of_values(request.problem.times, {"state": rows})


METHOD = Lorenz()
