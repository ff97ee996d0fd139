"""SciPy's DOP853 and LSODA (Hairer, Norsett and Wanner 1993;
Petzold 1983), the right-hand side in Python.
"""

import math
from time import perf_counter

import numpy as np

from refdem.bench.peers._peer import Peer
from refdem.core.engine import Method
from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory

LEAST = 2.3e-14
"""The smallest relative tolerance that DOP853 takes: 100 units of round-off."""
MOST_STEPS = 10_000_000
"""Steps that LSODA may take between two samples; its default of 500 is reached by tolerances near
round-off, and no run of the bench comes near this.
"""


class SciPy(Peer):
    """DOP853 with dense output at the samples; LSODA in its compiled loop."""

    name = "scipy"
    title = "SciPy"
    licence = "BSD-3-Clause"
    methods = (
        Method(
            name="dop853", summary="Runge-Kutta of order 8 with step control", control="tolerance"
        ),
        Method(name="lsoda", summary="Adams and BDF of variable order", control="tolerance"),
    )

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Absolute and relative tolerance the same; steps are the calls of the right-hand side."""
        from scipy.integrate import odeint, solve_ivp

        system = self.supported_equations(request.problem, request.method)
        t = request.problem.times
        tolerance = max(request.tolerance or 0.0, LEAST)

        def rates(time: float, y: np.ndarray) -> list[float]:
            return system.rates(y.tolist(), math.sin)

        started = perf_counter()
        if request.method == "lsoda":
            states, statistics = odeint(
                rates,
                system.start,
                t,
                rtol=tolerance,
                atol=tolerance,
                mxstep=MOST_STEPS,
                full_output=True,
                tfirst=True,
            )
            seconds = perf_counter() - started
            calls = int(statistics["nfe"][-1])
        else:
            solution = solve_ivp(
                rates, (t[0], t[-1]), system.start, "DOP853", t, rtol=tolerance, atol=tolerance
            )
            seconds = perf_counter() - started
            calls = int(solution.nfev)
            states = solution.y.T
        return system.trajectory(t, np.ascontiguousarray(states)), Cost(
            seconds=seconds, steps=calls
        )


PEER = SciPy()
