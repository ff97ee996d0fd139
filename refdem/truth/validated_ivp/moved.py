"""The set in which the solution lies, moved by the flow: Lohner's frame against wrapping, and the flow Jacobian from the start.

Theorem (mean value): if y = c + e with c, y in a convex set, then Phi(y) = Phi(c) + V e for some V in an enclosure of the flow Jacobian
over the set. So e = A r with |r_j| <= length_j, and Phi(c) = c' + u, give e' = Q (Q^-1 V A r + Q^-1 u): any regular Q is allowed, and
the Q of a QR decomposition of V A with its longest edge first wraps least (Lohner 1987).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_poly, arb_series, ctx

from refdem.truth.balls import arb_of, precision
from refdem.truth.validated_ivp.enclosure import Disc, jacobian_remainder
from refdem.truth.validated_ivp.field import Program, largest, sum_of
from refdem.truth.validated_ivp.recurrences import taylor

BITS = 128
"""Of Jacobians and of the lengths of the set."""


@dataclass(frozen=True)
class Spread:
    """Errors {A r: |r_j| <= lengths_j}, and the flow Jacobian since the start, which lies in `growth` + A `slack`."""

    frame: arb_mat
    lengths: list[arb]
    growth: arb_mat
    slack: arb_mat

    def radii(self) -> list[arb]:
        """Bound of each coordinate of an error."""
        with precision(BITS):
            return products(self.frame, self.lengths)

    def jacobian(self) -> arb_mat:
        """Enclosure of the flow Jacobian since the start."""
        return self.growth + self.frame * self.slack


def identity(size: int) -> arb_mat:
    """The unit matrix."""
    return arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])


def at_start(radii: Sequence[arb]) -> Spread:
    """The box of those radii before anything moved."""
    size = len(radii)
    return Spread(identity(size), [outward(radius) for radius in radii], identity(size), arb_mat(size, size))


def outward(value: arb) -> arb:
    """An exact number that |value| does not exceed."""
    return arb(value.abs_upper())


def products(matrix: arb_mat, lengths: Sequence[arb]) -> list[arb]:
    """Bounds of |M r| for |r_j| <= lengths_j."""
    return [outward(sum_of([abs(x) * length for x, length in zip(row, lengths, strict=True)])) for row in matrix.table()]


def hull(centre: Sequence[arb], radii: Sequence[arb]) -> list[arb]:
    """The box about an exact centre."""
    return [value + arb(0, radius) for value, radius in zip(centre, radii, strict=True)]


def flow_jacobian(field: Program, jacobian: Program, box: Sequence[arb], found: Disc, step: arb, order: int) -> arb_mat:
    """Enclosure of the derivative of y(h) by y(0) for every start in the box: (n+1) V_(n+1) = sum J_i V_(n-i), and the remainder."""
    size = len(box)
    with precision(BITS):
        slopes = jacobian_series(jacobian, taylor(field, box, order), order)
        terms = [identity(size)]
        for n in range(order):
            term = arb_mat(size, size)
            for i in range(n + 1):
                term += slopes[i] * terms[n - i]
            terms.append(term / arb(n + 1))
        total = terms[-1]
        for term in terms[-2::-1]:
            total = total * step + term
        rest = arb(0, jacobian_remainder(found, outward(step), order))
        return total + arb_mat(size, size, [rest] * size**2)


def jacobian_series(jacobian: Program, solution: Sequence[arb_poly], order: int) -> list[arb_mat]:
    """J_0 .. J_(order-1): the Taylor coefficients of J(y(t))."""
    size, before = len(solution), ctx.cap
    try:
        ctx.cap = order
        series = [arb_series(one.coeffs()[:order], prec=order) for one in solution]
        entries = [arb_poly(entry.coeffs()) for entry in jacobian.run(series, lambda c: arb_series([arb_of(c)], prec=order))]
    finally:
        ctx.cap = before
    return [arb_mat(size, size, [entry[k] for entry in entries]) for k in range(order)]


def moved(spread: Spread, jacobian: arb_mat, local: Sequence[arb]) -> Spread:
    """The set after a step with that flow Jacobian and those bounds of |u|."""
    with precision(BITS):
        edges = jacobian * spread.frame
        frame = orthogonal(edges, spread.lengths)
        back = frame.inv()
        turned = back * edges
        carried, added = products(turned, spread.lengths), products(back, local)
        lengths = [outward(a + b) for a, b in zip(carried, added, strict=True)]
        whole = jacobian * spread.growth
        growth = whole.mid()
        return Spread(frame, lengths, growth, turned * spread.slack + back * (whole - growth))


def orthogonal(edges: arb_mat, lengths: Sequence[arb]) -> arb_mat:
    """An exact matrix, orthogonal to rounding, whose first axes are along the longest edges."""
    longest = largest(lengths)
    share = np.array([float(length / longest) if longest > 0 else 1.0 for length in lengths])
    columns = np.array([[float(x.mid()) for x in row] for row in edges.table()])
    order = np.argsort(-np.linalg.norm(columns, axis=0) * share, kind="stable")
    axes, _ = np.linalg.qr(columns[:, order])
    return arb_mat(len(lengths), len(lengths), [float(x) for x in axes.flatten()])
