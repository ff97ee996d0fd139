"""A point on a line under polynomial and periodic forces, by Taylor series kept at round-off
(kernels/taylor_oscillator.c).
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import UnsupportedError
from refdem.kernels import load, pointer
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver


class TaylorOscillator(Solver):
    """Springs with a square and a cube, a dashpot of van der Pol's, any number of periodic
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

    def unsupported(self, problem: Motion) -> str | None:
        """None for forces that are polynomials of place and velocity, and not merely harmonic."""
        reason = _line.unsupported(problem)
        if reason:
            return reason
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if spring.exponent not in (1, 3):
            return "the force of the spring is no polynomial"
        if spring.quadratic and not spring.length:
            return "the square of a stretch that is never negative is no polynomial of the place"
        if single.is_linear(spring) and not {"dashpot", "force"} & scene.features:
            return "the motion is harmonic"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and the work done against damping and drives at the samples."""
        begun = perf_counter()
        line = _line.line_of(request)
        t = request.problem.times
        kernel = load("taylor_oscillator")
        out = np.empty((len(t), 3))
        spring = line.spring
        powers = {"linear": 0.0, "quadratic": spring.quadratic, "cubic": spring.cubic}
        if spring.exponent == 1:
            own_power = "linear"
        else:
            own_power = "cubic"
        powers[own_power] += spring.stiffness
        drives = pointer("taylor_oscillator", line.drives)
        given = {
            "mass": line.mass,
            **powers,
            "damping": line.damping,
            "van_der_pol": line.van_der_pol,
            "offset": line.offset,
            "weight": line.weight,
            "drives": len(line.drives),
            "drive": drives,
        }
        struct = kernel.ffi.new("refdem_oscillator *", given)
        samples = pointer("taylor_oscillator", t)
        rows = pointer("taylor_oscillator", out, output=True)
        started = perf_counter()
        failed = kernel.lib.refdem_taylor_oscillator(
            struct, line.place, line.speed, t[0], len(t), samples, rows
        )
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        if failed:
            raise UnsupportedError(
                f"taylor-oscillator: the motion goes to infinity before sample {failed - 1}"
            )
        channels = {}
        if not request.problem.scene.is_conservative():
            channels["dissipated_work"] = out[:, 2].copy()
        return line.trajectory(t, out[:, 0], out[:, 1], channels=channels), cost


METHOD = TaylorOscillator()
