"""A point on a spring whose force is a power of its stretch, in closed form
(kernels/power_oscillator.c).
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers.solver import Solver


class ExactPower(Solver):
    """m x'' + k |x|^n sgn x = 0, n > 1, through any number of zero crossings."""

    claims = Method(
        name="exact-power",
        summary="power-law oscillator in closed form: inverse incomplete beta functions",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=1,
    )
    kernels = ("power_oscillator",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one power-law spring of natural length 0 and nothing else."""
        reason = _line.unsupported(problem)
        if reason:
            return reason
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if len(scene.elements) > 1:
            return "more than a spring acts"
        if (
            spring.length
            or spring.quadratic
            or spring.cubic
            or not (spring.exponent > 1 and spring.stiffness > 0)
        ):
            return (
                "the spring does not pull with one power above 1 of its stretch from natural"
                " length 0"
            )
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position and velocity at the samples."""
        begun = perf_counter()
        line = _line.line_of(request)
        t = request.problem.times
        out = np.empty((len(t), 2))
        lib = load("power_oscillator").lib
        samples = pointer("power_oscillator", t)
        rows = pointer("power_oscillator", out, output=True)
        given = (line.mass, line.spring.stiffness, line.spring.exponent, line.place, line.speed)
        started = perf_counter()
        lib.refdem_power_oscillator(*given, t[0], len(t), samples, rows)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        return line.trajectory(t, out[:, 0], out[:, 1]), cost


METHOD = ExactPower()
