"""The set in which the solution lies, moved by the flow: Lohner's frame against wrapping, and the
flow Jacobian from the start.

Theorem (mean value): let Phi be the map of a step, c and y = c + e two points of a convex set, and
V an enclosure of the Jacobian of Phi over that set. Then Phi(y) is in Phi(c) + V e. So with e = A
r, |r_j| <= length_j, and with Phi(c) = c' + u, c' exact, the new error e' = Phi(y) - c' is

    e' = V A r + u = Q (Q^-1 V A r + Q^-1 u).

Any regular Q is allowed. That of a QR decomposition of V A with the columns in falling order of
their lengths wraps little (Lohner 1987).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul

import numpy as np
from flint import arb, arb_mat, arb_poly, arb_series

from refdem.truth.balls import largest, outward, precision, series_length, terms_of, unit_matrix
from refdem.truth.traced_field import Program
from refdem.truth.validated_ivp.enclosure import Disc

BITS = 128
"""The working precision of the lengths of the set and of its frame."""


@dataclass(frozen=True)
class Spread:
    """The set of errors {A r: |r_j| <= lengths_j}, and the flow Jacobian since the start.

    `frame` is A, whose columns are the axes of the set. The flow Jacobian lies in `growth` + A
    `slack`, where `growth` is exact: its uncertainty too is counted along the axes of the frame,
    against wrapping.
    """

    frame: arb_mat
    lengths: list[arb]
    growth: arb_mat
    slack: arb_mat

    def radii(self) -> list[arb]:
        """A bound of each coordinate of an error."""
        with precision(BITS):
            return products(self.frame, self.lengths)

    def around(self, centre: Sequence[arb]) -> list[arb]:
        """Balls of the states `centre` + e, for all errors e of the set."""
        return [value + arb(0, radius) for value, radius in zip(centre, self.radii(), strict=True)]

    def jacobian(self) -> arb_mat:
        """Enclosure of the flow Jacobian since the start."""
        return self.growth + self.frame * self.slack


def at_start(radii: Sequence[arb]) -> Spread:
    """The box of those radii at the start, in the unit frame."""
    size = len(radii)
    return Spread(
        unit_matrix(size),
        [outward(radius) for radius in radii],
        unit_matrix(size),
        arb_mat(size, size),
    )


def products(matrix: arb_mat, lengths: Sequence[arb]) -> list[arb]:
    """A bound of each |(M r)_i| for |r_j| <= lengths_j: the sum over j of |M_ij| lengths_j."""
    return [
        outward(sum((abs(x) * length for x, length in zip(row, lengths, strict=True)), arb(0)))
        for row in matrix.table()
    ]


def flow_series(
    jacobian: Program,
    polynomials: Sequence[arb_poly],
    proved: Disc,
    start: arb,
    order: int,
    steady: int = 0,
) -> list[arb_mat]:
    """The Taylor coefficients V_0 .. V_order of the flow Jacobian, for every start within the norm
    `start` of T(0).

    V' = J(y(t)) V: (n+1) V_(n+1) = sum over i <= n of J_i V_(n-i), J_i being the coefficients of
    J(y(t)). The rates of the last `steady` coordinates are constant: their rows of J are 0, those
    of V are those of the unit matrix, and only the rows above are computed.

    Theorem: on the disc, a solution y from the set and the solution y* from T(0) differ by at most
    exp(integral of L) start (Gronwall), and y and T by at most apart(R). So their coefficients of
    z^n differ by at most R^-n times these (Cauchy). The coefficients of T are those of y* for n <=
    N, and 0 for n > N.
    """
    size = len(polynomials)
    radius = proved.radius
    near = proved.gronwall(radius) * start
    far = proved.apart(radius, start)
    # Bounds w_i exp(integral of L) start R^-n, n <= N, and w_i apart(R) R^-n, n > N, of the
    # difference of coefficient n of coordinate i from that of T.
    margins = []
    for n in range(order):
        if n <= proved.order:
            difference = near
        else:
            difference = far
        margins.append(proved.sides(difference / radius**n))
    solution = []
    for i, polynomial in enumerate(polynomials):
        solution.append([polynomial[n] + arb(0, margins[n][i]) for n in range(order)])
    slopes = jacobian_series(jacobian, solution)
    moving = size - steady
    by_moving = [part(one, moving, 0, moving) for one in slopes]
    terms = [part(unit_matrix(size), moving, 0, size)]
    # (n+1) V_(n+1) = sum over i <= n of J_i V_(n-i). Rows of V of moving coordinates are computed;
    # rows of steady ones are 0 in V_1, V_2, ..., and part of the unit matrix in V_0, so that their
    # columns of J_n enter once, as the last columns of the sum.
    for n in range(order):
        products_of_order_n = map(mul, by_moving[: n + 1], terms[::-1])
        total = sum(products_of_order_n, arb_mat(moving, size))
        if steady:
            total = total + part(slopes[n], moving, moving, size, size)
        terms.append(total / (n + 1))
    if not steady:
        return terms
    still = unit_matrix(size).table()[moving:]
    whole = [arb_mat([*terms[0].table(), *still])]
    no_change = [[arb(0)] * size] * steady
    return whole + [arb_mat([*term.table(), *no_change]) for term in terms[1:]]


def part(matrix: arb_mat, rows: int, first: int, last: int, width: int = 0) -> arb_mat:
    """The first rows of a matrix, columns `first` to `last`, with columns of 0 before them up to a
    `width`.
    """
    before = [arb(0)] * max(0, width - (last - first))
    return arb_mat([before + row[first:last] for row in matrix.table()[:rows]])


def jacobian_series(jacobian: Program, solution: Sequence[Sequence[arb]]) -> list[arb_mat]:
    """The coefficients J_0, J_1, ... of the Jacobian J(y(t)), as many as there are of each y_i.

    `solution` has the coefficients of y_0, y_1, ...
    """
    size = len(solution)
    order = len(solution[0])
    with series_length(order):
        series = [arb_series(one, prec=order) for one in solution]
        entries = [
            terms_of(entry, order)
            for entry in jacobian.run(series, lambda ball: arb_series([ball], prec=order))
        ]
    return [arb_mat(size, size, [entry[k] for entry in entries]) for k in range(order)]


def flow_jacobian(terms: Sequence[arb_mat], proved: Disc, since: arb) -> arb_mat:
    """Enclosure of the derivative of y(since) by y(0): the series and its remainder.

    A matrix of norm r in the weighted norm has entries |V_ij| <= r w_i/w_j.
    """
    # Horner's rule.
    total = terms[-1]
    for term in terms[-2::-1]:
        total = total * since + term
    remainder_bound = proved.jacobian_remainder(outward(since), len(terms) - 1)
    weights = proved.weights
    remainder = [[arb(0, outward(remainder_bound * a / b)) for b in weights] for a in weights]
    return total + arb_mat(remainder)


def moved(spread: Spread, jacobian: arb_mat, local: Sequence[arb], bits: int = BITS) -> Spread:
    """The set after a step with the flow Jacobian V (`jacobian`), where `local` bounds |u|, the
    error of the step itself in each coordinate (theorem of the module).

        A' = Q,    lengths' = |Q^-1 V A| lengths + |Q^-1| local,
        growth' = mid(V growth),    slack' = Q^-1 V A slack + Q^-1 (V growth - growth').

    The second line splits V (growth + A slack) into growth' + Q slack'. The frame and `growth` have
    so many `bits`.
    """
    with precision(bits):
        # V A, and Q^-1 V A.
        edges = jacobian * spread.frame
        frame = orthogonal(edges, spread.lengths)
        back = frame.inv()
        turned = back * edges
        moved_lengths = products(turned, spread.lengths)
        local_lengths = products(back, local)
        lengths = [outward(a + b) for a, b in zip(moved_lengths, local_lengths, strict=True)]
        whole = jacobian * spread.growth
        growth = whole.mid()
        return Spread(frame, lengths, growth, turned * spread.slack + back * (whole - growth))


def orthogonal(edges: arb_mat, lengths: Sequence[arb]) -> arb_mat:
    """An exact matrix, orthogonal up to rounding, whose first axes are along the longest edges: the
    Q of a QR decomposition of the columns in falling order of their lengths.

    Column j of `edges` times lengths[j] is an edge of the set. Any regular matrix is allowed.
    """
    longest = largest(lengths)
    if longest > 0:
        shares = np.array([float(length / longest) for length in lengths])
    else:
        shares = np.ones(len(lengths))
    # An unstable motion's edges may be larger than any double.
    widest = largest([x for row in edges.table() for x in row])
    if widest > 0:
        scale = 1 / widest
    else:
        scale = arb(1)
    columns = np.array([[float((x * scale).mid()) for x in row] for row in edges.table()])
    edge_lengths = np.linalg.norm(columns, axis=0) * shares
    order = np.argsort(-edge_lengths, kind="stable")
    axes, _ = np.linalg.qr(columns[:, order])
    return arb_mat(len(lengths), len(lengths), [float(x) for x in axes.flatten()])
