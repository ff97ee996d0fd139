"""A point on a linear spring and a linear dashpot, driven or not, along a line, in closed form
(kernels/linear_oscillator.c).
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver


class ExactLinear(Solver):
    """Under-damped, critically damped and over-damped, with periodic forces, also at resonance."""

    claims = Method(
        name="exact-linear",
        summary="damped and driven linear oscillator in closed form, its phases in double-double",
        control="exact",
        backward=True,
        cost_rank=1,
    )
    kernels = ("linear_oscillator",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for a linear spring that pulls, and a dashpot or a force; without these the motion
        is harmonic.
        """
        reason = _line.unsupported(problem)
        if reason:
            return reason
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear"
        if any(dashpot.van_der_pol for dashpot in scene.all(Dashpot)):
            return "the dashpot is not linear"
        if not {"dashpot", "force"} & scene.features:
            return "nothing damps or drives: the motion is harmonic"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position and velocity at the samples."""
        begun = perf_counter()
        line = _line.line_of(request)
        t = request.problem.times
        kernel = load("linear_oscillator")
        out = np.empty((len(t), 2))
        drives = pointer("linear_oscillator", line.drives)
        given = {
            "mass": line.mass,
            "linear": line.spring.stiffness,
            "damping": line.damping,
            "weight": line.weight,
            "drives": len(line.drives),
            "drive": drives,
        }
        struct = kernel.ffi.new("refdem_linear *", given)
        samples = pointer("linear_oscillator", t)
        rows = pointer("linear_oscillator", out, output=True)
        started = perf_counter()
        kernel.lib.refdem_linear_oscillator(
            struct, line.place, line.speed, t[0], len(t), samples, rows
        )
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        return line.trajectory(t, out[:, 0], out[:, 1]), cost


METHOD = ExactLinear()
