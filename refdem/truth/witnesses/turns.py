"""Products of rotations and of quaternions, and the rows of the case rotations on commutation, on
steps with nine entries or four, and on multiples of an angle, for its witness.

Quaternions are (w, x, y, z); matrices map from the body to space. The rotation nearest to a matrix
M is M (M^T M)^(-1/2); the angle of a rotation M is 2 asin(|M - 1|/sqrt 8), Frobenius norm.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import acb, arb, arb_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector

Point = Sequence[Any]


def hamilton(a: Point, b: Point) -> list[Any]:
    """Hamilton's product of two quaternions."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    return [w, x, y, z]


def about(axis: str, angle: arb) -> arb_mat:
    """The matrix of a turn by `angle` [rad] about the coordinate axis "x", "y" or "z"."""
    i = "xyz".index(axis)
    j = (i + 1) % 3
    k = (i + 2) % 3
    sine, cosine = angle.sin_cos()
    # The axis i is kept, e_j -> cos e_j + sin e_k, e_k -> -sin e_j + cos e_k.
    entries = {(i, i): arb(1), (j, j): cosine, (k, k): cosine, (j, k): -sine, (k, j): sine}
    return arb_mat([[entries.get((m, n), arb(0)) for n in range(3)] for m in range(3)])


def row_by_row(m: arb_mat) -> list[arb]:
    """The entries of a matrix."""
    return [x for row in m.table() for x in row]


def identity() -> arb_mat:
    """The matrix 1 of three dimensions."""
    return arb_mat([[int(i == j) for j in range(3)] for i in range(3)])


def angle_of(turn: arb_mat) -> arb:
    """The angle [rad] in [0, pi] of a turn: the sum of squares of M - 1 is 8 sin^2(angle/2)."""
    missing = turn - identity()
    squares = sum((x * x for x in row_by_row(missing)), arb(0))
    return 2 * (squares / 8).sqrt().asin()


def commuting(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """Two translations in both orders, and two small turns in both orders and as a loop."""
    entries = vector(p, "shifts")
    first = entries[:3]
    second = entries[3:]
    start = (Fraction(1), Fraction(0), Fraction(0))
    after_first = [x + y for x, y in zip(start, first, strict=True)]
    after_second = [x + y for x, y in zip(start, second, strict=True)]
    both = [x + y + z for x, y, z in zip(start, first, second, strict=True)]
    small = arb_of(number(p, "small"))
    x_turn = about("x", small)
    y_turn = about("y", small)
    x_y = x_turn * y_turn
    y_x = y_turn * x_turn
    loop_back = about("x", -small) * about("y", -small)
    # The leading term h^2 [e_z] of the commutator.
    square = small * small
    leading = arb_mat([[0, -square, 0], [square, 0, 0], [0, 0, 0]])
    loop = x_y * loop_back
    turns = {
        "small-x": x_turn,
        "small-y": y_turn,
        "small-x-y": x_y,
        "small-y-x": y_x,
        "turn-commutator": x_y - y_x,
        "beyond-leading": x_y - y_x - leading,
        "small-x-back": about("x", -small),
        "small-y-back": about("y", -small),
        "loop-back": loop_back,
        "loop": loop,
    }
    return {
        "shifted-first": after_first,
        "shifted-first-second": both,
        "shifted-second": after_second,
        "shifted-second-first": both,
        "shift-commutator": [arb(0)] * 3,
        **{name: row_by_row(turn) for name, turn in turns.items()},
        "loop-angle": [angle_of(loop)],
    }


def rate_matrices(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """The matrix from the rates of Euler's angles to omega, and its inverse by elimination.

    Its columns are the axes of the three rotations in space: e_z, R_phi e_x and R_phi R_theta e_z.
    """
    phi, theta, _ = (arb_of(x) for x in vector(p, "euler"))
    first = about("z", phi)
    second = first * about("x", theta)
    matrix = arb_mat([[int(i == 2), first[i, 0], second[i, 2]] for i in range(3)])
    return {
        "rate-matrix": row_by_row(matrix),
        "rate-inverse": row_by_row(matrix.inv()),
        "rate-one": row_by_row(identity()),
    }


def swept(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """omega x r as the vector part of (0, omega)(0, r), and related products.

    Lagrange's identity: |omega x r|^2 = omega^2 r^2 - (omega . r)^2.
    """
    omega = vector(p, "omega")
    arm = vector(p, "shifts")[:3]
    zero = Fraction(0)
    along, *crossed = hamilton([zero, *omega], [zero, *arm])
    squares = [sum((x * x for x in v), zero) for v in (omega, arm)]
    # |omega x r|^2 = omega^2 r^2 - (omega . r)^2; `along` is -omega . r.
    square = squares[0] * squares[1] - along * along
    _, *twice = hamilton([zero, *arm], [zero, *crossed])
    return {
        "swept": crossed,
        "swept-square": [square],
        "swept-by-products": [square],
        "swept-twice": twice,
        "swept-by-triple": [sum((x * y for x, y in zip(omega, twice, strict=True)), zero)],
    }


def euler_by_turns(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """The turns of Euler's angles, their products, the inverse by elimination, and the first of the
    shifts as it is carried there and back.
    """
    phi, theta, psi = (arb_of(x) for x in vector(p, "euler"))
    turns = {
        "turn-phi": about("z", phi),
        "turn-theta": about("x", theta),
        "turn-psi": about("z", psi),
        "turn-phi-back": about("z", -phi),
        "turn-theta-back": about("x", -theta),
        "turn-psi-back": about("z", -psi),
    }
    turns["turn-phi-theta"] = turns["turn-phi"] * turns["turn-theta"]
    turns["turn-psi-theta-back"] = turns["turn-psi-back"] * turns["turn-theta-back"]
    whole = turns["turn-phi-theta"] * turns["turn-psi"]
    turns["euler-by-turns"] = whole
    turns["euler-inverse"] = whole.inv()
    turns["euler-transposed"] = whole.transpose()
    arm = arb_mat([[arb_of(x)] for x in vector(p, "shifts")[:3]])
    carried = whole * arm
    return {
        **{name: row_by_row(turn) for name, turn in turns.items()},
        "euler-carried": row_by_row(carried),
        "euler-carried-back": row_by_row(whole.transpose() * carried),
    }


def of_multiples(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """Cosines of multiples of the angle: the entry xx of powers of its matrix about z."""
    turn = about("z", arb_of(number(p, "angle")))
    cosines = [arb(1)]
    power = identity()
    multiple = int(number(p, "multiple"))
    angle = arb_of(number(p, "angle"))
    other_angle = arb_of(vector(p, "euler")[0])
    # cos a cos b = (cos(a + b) + cos(a - b))/2, each cosine being the entry xx of a turn about z.
    both = (about("z", angle + other_angle) + about("z", angle - other_angle))[0, 0] / 2
    for _ in range(max(multiple, 4)):
        power = power * turn
        cosines.append(power[0, 0])
    return {
        "cosine-3": [cosines[3]],
        "cosine-4": [cosines[4]],
        "cosine-by-powers": [cosines[multiple]],
        "cosine-by-recurrence": [cosines[multiple]],
        "cosine-product": [both],
        "cosines-mixed": [both],
    }


def of_a_step(
    p: Mapping[str, Exact], rotation: arb_mat, q: Sequence[arb]
) -> dict[str, Sequence[Any]]:
    """One step by Euler's method of the nine entries of `rotation` and of its quaternion q."""
    step = number(p, "step")
    turn = [arb_of(step * x) for x in vector(p, "omega")]
    square = sum((x * x for x in turn), arb(0))
    x, y, z = turn
    # R_1 = (1 + [v]x) R with v = h omega, and the nearest rotation R_1 (R_1^T R_1)^(-1/2), which
    # is (1 - [v]x^2)^(-1/2) R_1.
    cross = arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    nine = (identity() + cross) * rotation
    gram = nine.transpose() * nine
    # (1 - [v]^2)^(-1/2) = 1 + [v]^2 (1 - (1 + |v|^2)^(-1/2))/|v|^2, as [v]^4 = -|v|^2 [v]^2; the
    # quotient is 1/(s (1 + s)) with s = sqrt(1 + |v|^2).
    s = (1 + square).sqrt()
    inverse_root = identity() + cross * cross * (1 / (s * (1 + s)))
    nine_back = inverse_root * nine
    # q + h omega q/2, and its normalisation.
    rate = [component / 2 for component in hamilton([arb(0), *turn], q)]
    four = [component + change for component, change in zip(q, rate, strict=True)]
    length = sum((component * component for component in four), arb(0)).sqrt()
    four_back = [component / length for component in four]
    # exp(v/2) = (cos(|v|/2), sin(|v|/2) v/|v|), from exp(i |v|/2).
    angle = square.sqrt()
    half_turn = acb(0, angle / 2).exp()
    rows: dict[str, Sequence[Any]] = {
        "whole-quaternion": [half_turn.real, *(half_turn.imag * v / angle for v in turn)],
        "nine-entries": row_by_row(nine),
        "nine-entries-defect": row_by_row(gram - identity()),
        "nine-entries-determinant": [nine.det()],
        "nine-entries-back": row_by_row(nine_back),
        "four-entries-rate": rate,
        "four-entries": four,
        "four-entries-length": [length],
        "four-entries-back": four_back,
        "four-entries-matrix": row_by_row(matrix_of(four_back)),
    }
    return rows | lags(cross, rotation, {"nine": nine_back, "four": matrix_of(four_back)})


def lags(
    cross: arb_mat, rotation: arb_mat, found: Mapping[str, arb_mat]
) -> dict[str, Sequence[Any]]:
    """The whole turn exp [v], and what is between it and the rotations that were found."""
    whole_turn = cross.exp()
    whole = whole_turn * rotation
    rows: dict[str, Sequence[Any]] = {
        "whole-turn": row_by_row(whole_turn),
        "whole": row_by_row(whole),
        "whole-back": row_by_row(whole.transpose()),
    }
    for name, matrix in found.items():
        between = whole.transpose() * matrix
        rows[f"{name}-entries-between"] = row_by_row(between)
        rows[f"{name}-entries-lag"] = [angle_of(between)]
    return rows


def matrix_of(q: Sequence[arb]) -> arb_mat:
    """The matrix of a unit quaternion; its columns are the images q e q* of the unit vectors."""
    back = [q[0], -q[1], -q[2], -q[3]]
    columns = []
    for axis in range(3):
        unit = [arb(0), *(arb(int(i == axis)) for i in range(3))]
        columns.append(hamilton(hamilton(q, unit), back)[1:])
    return arb_mat(columns).transpose()
