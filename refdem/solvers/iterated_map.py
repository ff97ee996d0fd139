"""Maps applied again and again in C (kernels/maps.c): logistic map and equation, billiards in a
rectangle and in a stadium.
"""

from time import perf_counter

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
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.solvers.solver import Solver

FUNCTIONS: dict[type[Map], str] = {
    Logistic: "refdem_logistic",
    LogisticFlow: "refdem_logistic_flow",
    RectangleBilliard: "refdem_rectangle",
    StadiumBilliard: "refdem_stadium",
}


class IteratedMap(Solver):
    """Each iterate from the one before, or from the start where that is possible."""

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
        """None for the maps that it has."""
        if type(problem.map) in FUNCTIONS:
            return None
        return f"no map {problem.map.kind}"

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The iterates asked for: `x` (T,), or `position` [m] and `direction` (T, 2)."""
        begun = perf_counter()
        problem = request.problem
        assert isinstance(problem, Iteration)
        counts = problem.times
        start = np.ascontiguousarray(problem.start, float)
        asked = problem.map
        out = np.empty((len(counts), asked.dimension))
        lib = load("maps").lib
        n = pointer("maps", counts)
        rows = pointer("maps", out, output=True)
        function = getattr(lib, FUNCTIONS[type(asked)])
        started = perf_counter()
        if isinstance(asked, Billiard):
            function(asked.width, asked.height, pointer("maps", start), len(counts), n, rows)
            values = {"position": out[:, :2].copy(), "direction": out[:, 2:].copy()}
        else:
            assert isinstance(asked, Logistic)
            function(asked.eta, start[0], len(counts), n, rows)
            values = {"x": out[:, 0]}
        cost = Cost(seconds=perf_counter() - started, setup=started - begun, steps=problem.n)
        return Trajectory.of_values(counts, values), cost


METHOD = IteratedMap()
