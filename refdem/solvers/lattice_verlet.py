"""A point on one spring along a line by Verlet's method on a lattice, exactly reversible
(kernels/lattice.c).
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
ROOM = 1.7
"""By which the potential at the ends of the lattice exceeds the energy: a start and its return then
choose the same units.
"""
WIDEST = 64
"""Doublings of the start's size after which a motion counts as unbound."""


class LatticeVerlet(KernelSolver):
    """Places and velocities are whole multiples of powers of two, which binary64 holds: a run back
    ends in the very bits of its start.

    A start that is finer than the lattice is rounded to it first, by at most 2^-54 of the powers of
    two above place and velocity.
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

    def unfit(self, problem: Motion) -> str | None:
        """None for a conservative oscillator on a line whose motion has ends."""
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
        reach = _reach(line) or (1.0, 1.0)
        place, speed = (ldexp(size, -self.bits) for size in reach)
        law = {
            "mass": line.mass,
            "stiffness": spring.stiffness,
            "exponent": spring.exponent,
            "cubic": spring.cubic,
            "weight": line.weight,
            "place": place,
            "speed": speed,
        }
        return KernelCall(
            function="refdem_lattice_verlet",
            inputs=(Struct(FAMILY, "refdem_lattice", law), line.x0, line.v0),
            clock=steps_to_samples(request),
            outputs=(np.empty((len(request.problem.times), 2)),),
            steps=steps_of(request),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Places and velocities after each `stride` steps; the first row is the start as given."""
        place, speed = call.outputs[0].T
        line = _line.line_of(request.problem.scene)
        return line.trajectory(request.problem.times, place.copy(), speed.copy())


def _reach(line: Line) -> tuple[float, float] | None:
    """Powers of two [m], [m/s] beyond which the motion does not go; None if there are none."""
    spring = line.spring

    def potential(x: float) -> float:
        power = spring.stiffness * abs(x) ** (spring.exponent + 1) / (spring.exponent + 1)
        energy: float = power + spring.cubic * x**4 / 4 - line.weight * x
        return energy

    energy = potential(line.x0) + line.mass * line.v0**2 / 2
    size = ldexp(1.0, frexp(abs(line.x0) or abs(line.v0) or 1.0)[1] - 2)
    for _ in range(WIDEST):
        lowest = min(potential(size * part / 16) for part in range(-16, 17))
        # The barrier, and what the motion has of it, with room.
        barrier = min(potential(size), potential(-size)) - lowest
        needed = ROOM * (energy - lowest)
        if barrier >= needed > 0:
            fastest = sqrt(2 * ROOM * (energy - lowest) / line.mass)
            return size, ldexp(1.0, ceil(log2(fastest)))
        size *= 2
    return None


METHOD = LatticeVerlet()
