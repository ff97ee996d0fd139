"""A point on a line under polynomial and periodic forces, by Taylor series to round-off
(kernels/taylor_oscillator.c).
"""

from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import UnsupportedError
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct, samples_from_start


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

    def unfit(self, problem: Motion) -> str | None:
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

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line; rows for x, v and work."""
        line = _line.line_of(request.problem.scene)
        law = _powers(line.spring) | {
            "mass": line.mass,
            "damping": line.damping,
            "van_der_pol": line.van_der_pol,
            "offset": line.offset,
            "weight": line.weight,
            "drives": len(line.drives),
            "drive": line.drives,
        }
        t = request.problem.times
        return KernelCall(
            function="refdem_taylor_oscillator",
            inputs=(Struct("taylor_oscillator", "refdem_oscillator", law), line.x0, line.v0),
            clock=samples_from_start(t),
            outputs=(np.empty((len(t), 3)),),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and the work done against damping and drives at the samples.

        Raises UnsupportedError if the motion diverges in finite time.
        """
        if status:
            raise UnsupportedError(
                f"taylor-oscillator: the motion goes to infinity before sample {status - 1}"
            )
        scene = request.problem.scene
        x, v, work = call.outputs[0].T
        channels = {}
        if not scene.is_conservative():
            channels["dissipated_work"] = work.copy()
        line = _line.line_of(scene)
        return line.trajectory(request.problem.times, x, v, channels=channels)


def _powers(spring: Spring) -> dict[str, Any]:
    """Coefficients of the first, second and third power of the stretch in the spring's force."""
    powers = {"linear": 0.0, "quadratic": spring.quadratic, "cubic": spring.cubic}
    if spring.exponent == 1:
        powers["linear"] += spring.stiffness
    else:
        powers["cubic"] += spring.stiffness
    return powers


METHOD = TaylorOscillator()
