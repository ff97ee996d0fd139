"""One step of R' = [omega] R in nine entries, and of q' = omega q/2 in four, by Euler's method: how
far the results are from rotations, and the rotations nearest to them.

With v = h omega and its axis n, the step makes (1 + [v]) R of the rotation R. In the plane across n
that is a turn by atan |v| and a stretch by sqrt(1 + |v|^2); along n nothing changes. The quaternion
becomes (1, v/2) q, a turn by 2 atan(|v|/2) of length sqrt(1 + |v|^2/4).
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.exact import number, vector
from refdem.truth.rotation import Matrix, applied, product, times, transposed


def values(p: Parameters, matrix: Sequence[arb], q: Sequence[arb]) -> dict[str, list[arb]]:
    """The rows of the step, by name, for the rotation `matrix` (row by row) and its quaternion."""
    turn = turned_in_a_step(p)
    square = arb_of(sum((x * x for x in turn), Fraction(0)))
    angle = square.sqrt()
    rotation = [matrix[k : k + 3] for k in (0, 3, 6)]
    axis = axis_of(turn)
    body_axis = applied(transposed(rotation), axis)
    return (
        of_nine(rotation, turn, axis, body_axis)
        | of_four(rotation, q, turn, axis)
        | lags(rotation, angle, axis, body_axis)
    )


def turned_in_a_step(p: Parameters) -> list[Fraction]:
    """The exact rotation vector v = h omega [rad] of the step."""
    step = number(p, "step")
    return [step * x for x in vector(p, "omega")]


def axis_of(turn: Sequence[Fraction]) -> list[arb]:
    """The unit vector along a rotation vector."""
    length = arb_of(sum((x * x for x in turn), Fraction(0))).sqrt()
    return [arb_of(x) / length for x in turn]


def of_nine(
    rotation: Matrix, turn: Sequence[Fraction], axis: Sequence[arb], body_axis: Sequence[arb]
) -> dict[str, list[arb]]:
    """The nine entries M after the step, M^T M - 1, their determinant, and the nearest rotation."""
    x, y, z = (arb_of(component) for component in turn)
    square = x * x + y * y + z * z
    one = arb(1)
    # M = (1 + [v]) R, with [v] r = v x r.
    first_order = [[one, -z, y], [z, one, -x], [-y, x, one]]
    stretch = (1 + square).sqrt()
    # 1 + [v] turns the plane across v by the angle a = atan |v|: sin a = |v|/sqrt(1 + |v|^2) and
    # cos a = 1/sqrt(1 + |v|^2).
    nearest = turn_about(axis, square.sqrt() / stretch, 1 / stretch)
    # M^T M - 1 = R^T [v]^T [v] R = R^T (|v|^2 1 - v v^T) R = |v|^2 (1 - b b^T), with the axis b =
    # R^T v/|v| in the body.
    defect = [
        square * (int(i == j) - body_axis[i] * body_axis[j]) for i in range(3) for j in range(3)
    ]
    return {
        # Six conditions on the rates of nine numbers leave three independent rotations.
        "nine-entries-freedom": [arb(3)],
        "nine-entries": row_by_row(product(first_order, rotation)),
        "nine-entries-defect": defect,
        # det (1 + [v]) = 1 + |v|^2.
        "nine-entries-determinant": [1 + square],
        "nine-entries-back": row_by_row(product(nearest, rotation)),
    }


def of_four(
    rotation: Matrix, q: Sequence[arb], turn: Sequence[Fraction], axis: Sequence[arb]
) -> dict[str, list[arb]]:
    """The quaternion after the step, its length, and the unit quaternion with its matrix."""
    half = [arb_of(component) / 2 for component in turn]
    half_square = sum((component * component for component in half), arb(0))
    # (0, v) q/2, and q + (0, v) q/2 = (1, v/2) q, of the length sqrt(1 + |v|^2/4).
    rate = times([arb(0), *half], q)
    stepped = [component + change for component, change in zip(q, rate, strict=True)]
    length = (1 + half_square).sqrt()
    # t = |v|/2 is the tangent of half the angle: sin = 2 t/(1 + t^2), cos = (1 - t^2)/(1 + t^2).
    sine = 2 * half_square.sqrt() / (1 + half_square)
    cosine = (1 - half_square) / (1 + half_square)
    return {
        "four-entries-rate": rate,
        "four-entries": stepped,
        "four-entries-length": [length],
        "four-entries-back": [component / length for component in stepped],
        "four-entries-matrix": row_by_row(product(turn_about(axis, sine, cosine), rotation)),
    }


def lags(
    rotation: Matrix, angle: arb, axis: Sequence[arb], body_axis: Sequence[arb]
) -> dict[str, list[arb]]:
    """The exact rotation by |v|, and the angles by which the two results lag behind it: |v| - atan
    |v| with nine entries, |v| - 2 atan(|v|/2) with four.
    """
    nine_lag = angle - angle.atan()
    four_lag = angle - 2 * (angle / 2).atan()
    whole_turn = turn_about(axis, angle.sin(), angle.cos())
    whole = product(whole_turn, rotation)
    # With the exact rotation W = T(|v|) R, and T(a) the rotation by a about the axis n in space:
    # W^T T(a) R = R^T T(a - |v|) R, which is the rotation by a - |v| about R^T n.
    nine_between = turn_about(body_axis, -nine_lag.sin(), nine_lag.cos())
    four_between = turn_about(body_axis, -four_lag.sin(), four_lag.cos())
    return {
        "whole-turn": row_by_row(whole_turn),
        "whole-quaternion": [(angle / 2).cos(), *((angle / 2).sin() * n for n in axis)],
        "whole": row_by_row(whole),
        "whole-back": row_by_row(transposed(whole)),
        "nine-entries-between": row_by_row(nine_between),
        "nine-entries-lag": [folded(nine_lag)],
        "four-entries-between": row_by_row(four_between),
        "four-entries-lag": [folded(four_lag)],
    }


def folded(angle: arb) -> arb:
    """The angle in [0, pi] of a turn by any angle [rad] >= 0; UndecidedError near an odd multiple
    of pi.
    """
    turns = round(float(angle.mid() / (2 * arb.pi())))
    rest = abs(angle - 2 * turns * arb.pi())
    if not rest < arb.pi():
        raise UndecidedError("the angle of a half turn")
    return rest


def turn_about(axis: Sequence[arb], sine: arb, cosine: arb) -> list[list[arb]]:
    """The matrix cos 1 + sin [n] + (1 - cos) n n^T of a turn about the unit vector n."""
    x, y, z = axis
    cross = [[arb(0), -z, y], [z, arb(0), -x], [-y, x, arb(0)]]
    return [
        [
            cosine * int(i == j) + sine * cross[i][j] + (1 - cosine) * axis[i] * axis[j]
            for j in range(3)
        ]
        for i in range(3)
    ]


def row_by_row(m: Matrix) -> list[arb]:
    """The entries of a matrix."""
    return [entry for row in m for entry in row]
