"""Gear's predictor-corrector (kernels/gear.h): its coefficients, and the methods of orders 4 to 6
that share them.

Nordsieck's state has the rows r_i = h^i x^(i)/i!, i = 0 to p. A step of x'' = f(x, x') predicts
and then corrects them once:

    r_i <- sum over j >= i of binomial(j, i) r_j,
    r_i <- r_i + c_i d,   d = h^2/2 f - r_2,   f at the predicted rows.

Positions and velocities have order p. Where f does not depend on x', the order of positions is
higher by up to one. Coefficients c_i: Gear 1971; Allen and Tildesley, Computer Simulation of
Liquids, appendix E.
"""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.kernels import load
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _particles
from refdem.solvers._free_bodies import SteppedFreeBodies, spinning
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, steps_of, steps_to_samples
from refdem.solvers._scene_pattern import ANY, ScenePattern

Array = NDArray[np.float64]


def _fractions(text: str) -> tuple[Fraction, ...]:
    """The numbers in a text, separated by spaces, as exact fractions."""
    return tuple(Fraction(number) for number in text.split())


CORRECTORS: Mapping[int, tuple[Fraction, ...]] = {
    4: _fractions("19/120 3/4 1 1/2 1/12"),
    5: _fractions("3/20 251/360 1 11/18 1/6 1/60"),
    6: _fractions("863/6048 95/144 1 25/36 35/144 1/24 1/360"),
}
"""Coefficients c_0 to c_p by the order p, for forces that do not depend on velocities."""
WITH_VELOCITIES: Mapping[int, Fraction] = {
    4: Fraction(19, 90),
    5: Fraction(3, 16),
    6: Fraction(863, 5040),
}
"""The coefficient c_0 by order, for forces that depend on velocities; the second derivative of a
quaternion depends on its first derivative in this way.
"""


def corrector(order: int, *, with_velocities: bool = False) -> Array:
    """The coefficients c_0 to c_p (order + 1,) of the corrector as doubles."""
    first, *rest = CORRECTORS[order]
    if with_velocities:
        first = WITH_VELOCITIES[order]
    return np.array([first, *rest], float)


class GearPoints(KernelSolver):
    """Points under springs, gravity and a central field, without contacts."""

    kernels = ("particles",)
    pattern = ScenePattern(
        elements={Spring: ANY, UniformGravity: ANY, CentralField: ANY}, may_be_fixed=True
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None if nothing turns and the kernel supports the springs, which must be smooth at their
        natural length, else the reason.
        """
        if np.any(problem.scene.bodies.omega):
            return "a body turns; here places alone are integrated"
        if any(spring.exponent % 2 != 1 for spring in problem.scene.all(Spring)):
            return "a spring whose force is not smooth where it changes sign"
        return _particles.unsupported_values(problem)

    def prepare(self, request: Request) -> KernelCall:
        """The scene, the coefficients and the steps, and arrays for work space and states."""
        scene = request.problem.scene
        packed = _particles.Packed(scene, _particles.ORIGIN)
        lib = load("particles").lib
        length = lib.refdem_particles_size(packed.struct.address)
        states = np.zeros((len(request.problem.times), length))
        states[0] = packed.start(scene, length)
        coefficients = corrector(self.claims.order)
        work_space = np.zeros(lib.refdem_particles_gear_work(packed.struct.address))
        return KernelCall(
            function="refdem_particles_gear",
            inputs=(packed.struct, len(coefficients), coefficients),
            clock=steps_to_samples(request),
            outputs=(work_space, states),
            steps=steps_of(request),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Positions and velocities at the samples; attitudes stay constant."""
        times = request.problem.times
        bodies = request.problem.scene.bodies
        # A row: the positions of all bodies (3 N), then their velocities (3 N).
        _, states = call.outputs
        shape = (len(times), len(bodies), 3)
        coordinates = 3 * len(bodies)
        return Trajectory(
            t=times,
            position=states[:, :coordinates].reshape(shape).copy(),
            velocity=states[:, coordinates : 2 * coordinates].reshape(shape).copy(),
            omega=np.zeros(shape),
            attitude=np.repeat(bodies.attitude[None], len(times), axis=0),
        )


class GearFreeBody(SteppedFreeBodies):
    """Free bodies by an equation of second order for the quaternion.

    q'' = q' w/2 + q J^-1 (J w x w)/2,   w = 2 q^-1 q' in body axes.

    It is the derivative of q' = q w/2 with Euler's equations J w' = J w x w. The product q' w
    includes the scalar part of w = 2 q^-1 q', which is zero up to errors of the method; with it
    the equation implies w' = J^-1 (J w x w) for any |q|. The quaternion is not normalised during
    the integration: its length drifts with the error of the method, and attitudes in the output
    are divided by it.
    """

    function = "refdem_rigid_body_gear"

    def unsupported_values(self, problem: Motion) -> str | None:
        """None if a body turns, and those that do have inertia about all axes, else the reason."""
        bodies = problem.scene.bodies
        if not np.all(bodies.inertia[spinning(bodies)] > 0):
            return "a body that turns without inertia about one of its axes"
        return super().unsupported_values(problem)

    def turn(self, request: Request, body: int) -> KernelCall:
        """Attitude (T, 4) and omega (T, 3) after every `stride` steps."""
        call = super().turn(request, body)
        coefficients = corrector(self.claims.order, with_velocities=True)
        return KernelCall(
            function=self.function,
            inputs=(*call.inputs, len(coefficients), coefficients),
            clock=call.clock,
            outputs=call.outputs,
            steps=call.steps,
        )


def of_points(order: int) -> Method:
    """The claims of the method of the given order for points."""
    return Method(
        name=f"gear-{order}",
        summary=(
            f"Gear's predictor-corrector of order {order}, one correction a step; it starts from"
            " derivatives of the motion"
        ),
        control="step",
        order=order,
        conserves=frozenset({"momentum"}),
        backward=True,
        complete_state=False,
        cost_rank=50 + order,
    )


def of_free_body(order: int, *, constant: float = 1.0, constant_reason: str = "") -> Method:
    """The claims of the method of the given order for free bodies; `constant` is C of its error."""
    return Method(
        name=f"gear-{order}-free-body",
        summary=(
            f"Gear's predictor-corrector of order {order} on the second derivative of the"
            " quaternion, one correction a step"
        ),
        control="step",
        order=order,
        constant=constant,
        constant_reason=constant_reason,
        derived={
            "attitude": (
                "the attitude is divided by its length when it is handed out, so that it is"
                " always 1"
            )
        },
        conserves=frozenset({"momentum"}),
        backward=True,
        complete_state=False,
        cost_rank=50 + order,
    )
