"""A point on one spring along a line by Verlet's method on a lattice, exactly reversible
(kernels/lattice.c).
"""

from math import ceil, frexp, ldexp, log2, sqrt
from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer, timed
from refdem.solvers import _line
from refdem.solvers._line import Line
from refdem.solvers.solver import Solver

FAMILY = "lattice"
ROOM = 1.7
"""By which the potential at the ends of the lattice exceeds the energy: a start and its return then
choose the same units.
"""
WIDEST = 64
"""Doublings of the start's size after which a motion counts as unbound."""


class LatticeVerlet(Solver):
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

    def unsupported(self, problem: Motion) -> str | None:
        """None for a conservative oscillator on a line whose motion has ends."""
        reason = _line.unsupported(problem)
        if reason:
            return reason
        line = _line.line_of(Request(problem=problem, method=self.claims.name))
        if line.damping or line.van_der_pol or len(line.drives):
            return "more than a spring and gravity acts on the point"
        if line.spring.length:
            return "the spring has a length: its force turns round at the anchor"
        if line.spring.quadratic:
            return "the square of the stretch turns round at the anchor"
        if _reach(line):
            return None
        return "the motion has no bound, or is rest"

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Places and velocities after each `stride` steps; the first row is the start as given."""
        begun = perf_counter()
        t = request.problem.times
        line = _line.line_of(request)
        out = np.empty((len(t), 2))
        place, speed = (ldexp(size, -self.bits) for size in _reach(line) or (1.0, 1.0))
        spring = line.spring
        law = {
            "mass": line.mass,
            "stiffness": spring.stiffness,
            "exponent": spring.exponent,
            "cubic": spring.cubic,
            "weight": line.weight,
            "place": place,
            "speed": speed,
        }
        told = load(FAMILY).ffi.new("refdem_lattice *", law)
        rows = pointer(FAMILY, out, output=True)
        step = (line.place, line.speed, request.signed_step, len(t), request.stride)
        started = perf_counter()
        seconds = timed(load(FAMILY).lib.refdem_lattice_verlet, told, *step, rows)
        cost = Cost(seconds=seconds, setup=started - begun, steps=request.stride * (len(t) - 1))
        return line.trajectory(t, out[:, 0].copy(), out[:, 1].copy()), cost


def _reach(line: Line) -> tuple[float, float] | None:
    """Powers of two [m], [m/s] beyond which the motion does not go; None if there are none."""
    spring = line.spring

    def potential(x: float) -> float:
        power = spring.stiffness * abs(x) ** (spring.exponent + 1) / (spring.exponent + 1)
        energy: float = power + spring.cubic * x**4 / 4 - line.weight * x
        return energy

    energy = potential(line.place) + line.mass * line.speed**2 / 2
    size = ldexp(1.0, frexp(abs(line.place) or abs(line.speed) or 1.0)[1] - 2)
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
