"""A point on one spring along a line, by Verlet's method on a lattice of numbers, exactly
reversible (kernels/lattice.c).

Positions x and velocities v are whole multiples of two powers of two. With [] the rounding to such
a multiple, a step is

    v += [h/2 a(x)],   x += [h v],   v += [h/2 a(x)],   a = (weight - k |x|^n sgn x - c x^3)/m.

A step with -h subtracts the same increments, bit by bit (Levesque and Verlet 1993).
"""

from math import ceil, frexp, ldexp, log2, sqrt

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.solvers import _line
from refdem.solvers._kernel_solver import (
    KernelCall,
    KernelSolver,
    Struct,
    steps_of,
    steps_to_samples,
)
from refdem.solvers._line import Line

FAMILY = "lattice"
POTENTIAL_MARGIN = 1.7
"""Factor by which the potential at the ends of the lattice exceeds the energy, so that a run and
its reversed run choose the same units.
"""
WIDEST = 64
"""Doublings of the initial size after which a motion counts as unbounded."""


class LatticeVerlet(KernelSolver):
    """Verlet's method in 53-bit integers: a reversed run ends at its start, bit by bit.

    An initial state that is not on the lattice is rounded to it, by at most 2^-54 of the powers of
    two that bound position and velocity.
    """

    claims = Method(
        name="lattice-verlet",
        summary=(
            "Verlet's method in whole numbers of 53 bits: the way back is the way there, bit by bit"
        ),
        control="step",
        order=2,
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=32,
    )
    kernels = (FAMILY,)
    bits = 53

    pattern = _line.PATTERN

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a conservative oscillator on a line whose motion is bounded, else the
        reason.
        """
        scene = problem.scene
        line = _line.line_of(scene)
        if line.damping or line.van_der_pol or len(line.drives):
            return "more than a spring and gravity acts on the point"
        if line.spring.length:
            return "the spring has a length: its force turns round at the anchor"
        if line.spring.quadratic:
            return "the square of the stretch turns round at the anchor"
        reason = _line.askew(scene)
        if reason:
            return reason
        if _reach(line):
            return None
        return "the motion has no bound, or is rest"

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line, and the units of the lattice."""
        line = _line.line_of(request.problem.scene)
        spring = line.spring
        bounds = _reach(line) or (1.0, 1.0)
        position_unit, velocity_unit = (ldexp(bound, -self.bits) for bound in bounds)
        law = {
            "mass": line.mass,
            "stiffness": spring.stiffness,
            "exponent": spring.exponent,
            "cubic": spring.cubic,
            "weight": line.weight,
            "place": position_unit,
            "speed": velocity_unit,
        }
        return KernelCall(
            function="refdem_lattice_verlet",
            inputs=(Struct(FAMILY, "refdem_lattice", law), line.x0, line.v0),
            clock=steps_to_samples(request),
            outputs=(np.empty((len(request.problem.times), 2)),),
            steps=steps_of(request),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Positions and velocities at the samples; row 0 is the given start."""
        x, v = call.outputs[0].T
        line = _line.line_of(request.problem.scene)
        return line.trajectory(request.problem.times, x.copy(), v.copy())


def _reach(line: Line) -> tuple[float, float] | None:
    """Powers of two [m] and [m/s] that bound position and velocity of the motion; None if it is
    unbounded.

    The motion stays in |x| < size if the potential at both ends exceeds POTENTIAL_MARGIN times its
    energy, both above the lowest potential; then m v^2/2 is at most that energy.
    """
    spring = line.spring

    def potential(x: float) -> float:
        """V(x) = k |x|^(n + 1)/(n + 1) + cubic x^4/4 - weight x [J]."""
        spring_energy = spring.stiffness * abs(x) ** (spring.exponent + 1) / (spring.exponent + 1)
        energy: float = spring_energy + spring.cubic * x**4 / 4 - line.weight * x
        return energy

    energy = potential(line.x0) + line.mass * line.v0**2 / 2
    half_width = ldexp(1.0, frexp(abs(line.x0) or abs(line.v0) or 1.0)[1] - 2)
    for _ in range(WIDEST):
        lowest = min(potential(half_width * sixteenth / 16) for sixteenth in range(-16, 17))
        # barrier = V(ends) - V_min, needed = POTENTIAL_MARGIN (E - V_min).
        barrier = min(potential(half_width), potential(-half_width)) - lowest
        needed = POTENTIAL_MARGIN * (energy - lowest)
        if barrier >= needed > 0:
            # m v^2/2 <= POTENTIAL_MARGIN (E - V_min).
            fastest = sqrt(2 * POTENTIAL_MARGIN * (energy - lowest) / line.mass)
            return half_width, ldexp(1.0, ceil(log2(fastest)))
        half_width *= 2
    return None


METHOD = LatticeVerlet()
