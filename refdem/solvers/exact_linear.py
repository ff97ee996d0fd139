"""A point on a linear spring and a linear dashpot along a line, driven or not, in closed form
(kernels/linear_oscillator.c).

m x'' + c x' + k x = weight + sum f_i cos(w_i t + phase_i).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct, samples_from_start
from refdem.solvers._line_trial import unsupported_times


class ExactLinear(KernelSolver):
    """Under-damped, critically damped and over-damped motion, with periodic forces, also at
    resonance.
    """

    claims = Method(
        name="exact-linear",
        summary="damped and driven linear oscillator in closed form, its phases in double-double",
        control="exact",
        backward=True,
        cost_rank=1,
    )
    kernels = ("linear_oscillator", "taylor_oscillator")

    pattern = _line.PATTERN

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a linear restoring spring with a linear dashpot or a force, else the reason;
        without these the motion is harmonic.
        """
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear"
        if any(dashpot.van_der_pol for dashpot in scene.all(Dashpot)):
            return "the dashpot is not linear"
        if not {"dashpot", "force"} & scene.features:
            return "nothing damps or drives: the motion is harmonic"
        return _line.askew(scene)

    def unsupported_times(self, problem: Motion) -> str | None:
        """None if the point stays on its side of the spring's anchor, else the reason."""
        if not problem.scene.all(Spring)[0].length > 0:
            return None  # the force is linear on both sides
        return unsupported_times(problem)

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line; rows for x and v."""
        # m x'' + d x' + k x = weight + sum of F cos(w t + phase), with x = 0 where the spring is
        # relaxed.
        line = _line.line_of(request.problem.scene)
        law = {
            "mass": line.mass,
            "linear": line.spring.stiffness,
            "damping": line.damping,
            "weight": line.weight,
            "drives": len(line.drives),
            "drive": line.drives,
        }
        t = request.problem.times
        return KernelCall(
            function="refdem_linear_oscillator",
            inputs=(Struct("linear_oscillator", "refdem_linear", law), line.x0, line.v0),
            clock=samples_from_start(t),
            outputs=(np.empty((len(t), 2)),),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position and velocity at the samples."""
        x, v = call.outputs[0].T
        line = _line.line_of(request.problem.scene)
        return line.trajectory(request.problem.times, x, v)


METHOD = ExactLinear()
