"""Iterated maps (kernels/maps.c): the logistic map x -> eta x (1 - x), the flow of x' = eta x (1 -
x) over unit times, and billiards in a rectangle and in a stadium.
"""

from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.maps import (
    Billiard,
    Logistic,
    LogisticFlow,
    Map,
    RectangleBilliard,
    StadiumBilliard,
)
from refdem.core.problem import Iteration, Request
from refdem.core.trajectory import Trajectory
from refdem.solvers._kernel_solver import KernelCall, KernelRun, samples

FUNCTIONS: dict[type[Map], str] = {
    Logistic: "refdem_logistic",
    LogisticFlow: "refdem_logistic_flow",
    RectangleBilliard: "refdem_rectangle",
    StadiumBilliard: "refdem_stadium",
}


class IteratedMap(KernelRun):
    """Each iterate is computed from the previous one, or from the start where a closed form
    exists.
    """

    claims = Method(
        name="iterated-map",
        summary=(
            "maps iterated in C: a few roundings an iterate, which the motion may amplify;"
            " rectangles by unfolding"
        ),
        control="exact",
        cost_rank=0,
    )
    answers = Iteration
    kernels = ("maps",)

    def unsupported(self, problem: Iteration) -> str | None:
        """None for the maps in FUNCTIONS, else the reason."""
        if type(problem.map) in FUNCTIONS:
            return None
        return f"no map {problem.map.kind}"

    def prepare(self, request: Request) -> KernelCall:
        """The map and its start; rows for the requested iterates."""
        problem = request.problem
        assert isinstance(problem, Iteration)
        mapping = problem.map
        start = np.ascontiguousarray(problem.start, float)
        inputs: tuple[Any, ...]
        if isinstance(mapping, Billiard):
            inputs = (mapping.width, mapping.height, start)
        else:
            assert isinstance(mapping, Logistic)
            inputs = (mapping.eta, start[0])
        return KernelCall(
            function=FUNCTIONS[type(mapping)],
            inputs=inputs,
            clock=samples(problem.times),
            outputs=(np.empty((len(problem.times), mapping.dimension)),),
            steps=problem.n,
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """The iterates: `x` (T,), or `position` [m] and `direction` (T, 2)."""
        problem = request.problem
        assert isinstance(problem, Iteration)
        (rows,) = call.outputs
        if isinstance(problem.map, Billiard):
            values = {"position": rows[:, :2].copy(), "direction": rows[:, 2:].copy()}
        else:
            values = {"x": rows[:, 0]}
        return Trajectory.of_values(problem.times, values)


METHOD = IteratedMap()
