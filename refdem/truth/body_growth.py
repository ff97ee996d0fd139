"""How errors of a free rigid body grow: its turn in space and its angular velocity, by Euler's and the quaternion equation.

Coordinates of an error, at every time: psi, a small turn, and the change of omega, both in body axes; each vector is measured by Euclid,
psi in the scale of an attitude. J omega' = J omega x omega and q' = q omega/2 with any tensor J of rationals, principal axes or not.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import count
from math import floor, log2
from typing import Any

from flint import arb, arb_mat, ctx

from refdem.truth import rotation
from refdem.truth.balls import arb_of
from refdem.truth.growth import Grows, Growth, InProportion, Norm, Stretch, smooth
from refdem.truth.reals import Number
from refdem.truth.traced_field import Field
from refdem.truth.validated_ivp.integration import Integration, Piece

Tensor = Sequence[Sequence[Number]]
SPIN, ATTITUDE = range(3), range(3, 7)
TURNED = 256.0
"""Radians [rad] over which the errors of a body are followed: 40 revolutions. A cell is kept for each part of a radian."""
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Products of two components of omega."""
PARTS = (3, 3)
ROWS = (3, 1, 1, 1, 1, 1, 1)
"""Read are: the turn, and each component of omega in body axes and in space."""


def body_growth(tensor: Tensor, omega: Sequence[Number], turn: Fraction, spin: Fraction, attitude: Callable[[arb], Sequence[arb]]) -> Grows:
    """S of a body that starts with `omega` in body axes; `turn` and `spin` are scales of an attitude and of an angular velocity.

    `attitude(t)` is its quaternion, of either sign. A body is followed over TURNED radians; what comes after is extrapolated.
    """
    start = [*omega, Fraction(1), *[Fraction(0)] * 3]
    flow = Integration(field(tensor), lambda: [arb_of(value) for value in start], ctx.prec)
    ratio = arb_of(turn / spin)

    def readings(t: arb) -> arb_mat:
        """Turn, omega in body axes and in space, whose change is R (change of omega - omega x psi)."""
        matrix = rotation.matrix(attitude(t))
        x, y, z = flow.at(t)[:3]
        none = arb(0)
        crossed = [[none, z, -y], [-z, none, x], [y, -x, none]]
        by_turn = [[ratio * value for value in row] for row in rotation.product(matrix, crossed)]
        own = [[arb(int(i == j)) for j in range(6)] for i in range(6)]
        return arb_mat([*own, *(a + b for a, b in zip(by_turn, matrix, strict=True))])

    followed = Growth(stretches(flow, ratio), Norm(PARTS, ROWS), readings)
    fastest = max(abs(float(rate)) for rate in omega)
    if fastest == 0.0:
        return followed
    # A dyadic time, so that the enclosure of what has turned by then is as sharp as elsewhere.
    known = Fraction(2) ** floor(log2(TURNED / fastest))
    return InProportion(followed, known)


def stretches(flow: Integration, ratio: arb) -> Iterator[Stretch]:
    """The pieces of the integration, made as they are asked for."""
    for number in count():
        while number >= len(flow.pieces):
            flow.advance()
        piece = flow.pieces[number]
        told = partial(moved, flow, piece, ratio)
        yield smooth(arb_of(piece.begin), arb_of(piece.length), told, joins=True, quickness=partial(quickness, flow, piece, ratio))


def quickness(flow: Integration, piece: Piece, ratio: arb, since: arb) -> float:
    """Bound of the logarithmic norms, both ways in time, of psi' = change of omega - omega x psi and of Euler's equations, in scales.

    The turn -omega x psi changes no length and does not count.
    """
    state = piece.at(since)
    slopes, count = flow.slopes.run(state), len(state)
    euler = sum((slopes[i * count + j] * slopes[i * count + j] for i in SPIN for j in SPIN), arb(0))
    return max(float((1 / ratio).upper()), float(arb(euler.abs_upper()).sqrt().upper()))


def moved(flow: Integration, piece: Piece, ratio: arb, since: arb) -> arb_mat:
    """What (psi, change of omega) at the begin of a piece has become, in scales.

    A turn psi changes q by q psi/2; back: psi is twice the vector of q* times the change of q.
    """
    table = flow.moved_by(piece, since).table()
    before, now = piece.at(arb(0))[3:], rotation.conjugate(piece.at(since)[3:])
    half = arb(1) / 2
    columns: list[list[arb]] = []
    for axis in range(3):
        unit = [arb(0), *(half if i == axis else arb(0) for i in range(3))]
        turned = rotation.times(before, unit)
        change = [sum((table[i][j] * x for j, x in zip(ATTITUDE, turned, strict=True)), arb(0)) for i in ATTITUDE]
        columns.append([2 * x for x in rotation.times(now, change)[1:]] + [arb(0)] * 3)
    for axis in SPIN:
        turned = rotation.times(now, [table[i][axis] for i in ATTITUDE])[1:]
        columns.append([2 * x / ratio for x in turned] + [table[i][axis] for i in SPIN])
    return arb_mat([[column[i] for column in columns] for i in range(6)])


def field(tensor: Tensor) -> Field:
    """The rates of omega and the attitude."""
    products = euler_products(tensor)

    def rates(y: Sequence[Any]) -> list[Any]:
        omega, (w, a, b, c) = y[:3], y[3:]
        x, v, z = omega
        spinning = [sum_of(terms.values(), [omega[i] * omega[j] for i, j in terms]) for terms in products]
        turning = [-a * x - b * v - c * z, w * x + b * z - c * v, w * v + c * x - a * z, w * z + a * v - b * x]
        return [*spinning, *(rate / 2 for rate in turning)]

    return rates


def euler_products(tensor: Tensor) -> list[dict[tuple[int, int], Number]]:
    """For each component of omega, what its rate has of omega_i omega_j, i <= j: omega' = J^-1 (J omega x omega).

    Collected exactly: of a needle, J2 - J3 over a small J1 is a number of ordinary size, while neither term alone is.
    """
    back = inverse(tensor)
    found: list[dict[tuple[int, int], Number]] = [{pair: Fraction(0) for pair in PAIRS} for _ in SPIN]
    for axis in SPIN:
        after, last = (axis + 1) % 3, (axis + 2) % 3
        for j in SPIN:
            # The torque about `axis` is (J omega)_after omega_last - (J omega)_last omega_after.
            for row in SPIN:
                found[row][ordered(j, last)] += back[row][axis] * tensor[after][j]
                found[row][ordered(j, after)] -= back[row][axis] * tensor[last][j]
    return found


def ordered(i: int, j: int) -> tuple[int, int]:
    """The two numbers, the smaller one first."""
    return (i, j) if i <= j else (j, i)


def sum_of(row: Iterable[Number], values: Sequence[Any]) -> Any:
    """The sum of a row times some values."""
    return sum((value * weight for weight, value in zip(row, values, strict=True)), values[0] * 0)


def inverse(tensor: Tensor) -> list[list[Number]]:
    """The inverse of a symmetric tensor, by its cofactors."""
    cofactors = [
        [
            tensor[(i + 1) % 3][(j + 1) % 3] * tensor[(i + 2) % 3][(j + 2) % 3]
            - tensor[(i + 1) % 3][(j + 2) % 3] * tensor[(i + 2) % 3][(j + 1) % 3]
            for j in range(3)
        ]
        for i in range(3)
    ]
    size = sum((a * b for a, b in zip(tensor[0], cofactors[0], strict=True)), Fraction(0))
    return [[value / size for value in row] for row in cofactors]


def diagonal(moments: Sequence[Number]) -> Tensor:
    """The tensor of a body in its principal axes."""
    return [[moments[i] if i == j else Fraction(0) for j in range(3)] for i in range(3)]
