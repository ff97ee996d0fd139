"""The operations of the case rotations, and the magnitudes of their results.

A row is (name of the result, operation of core/algebra.py, operands); an operand is numbers or the
name of an earlier result.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from refdem.cases import _koenig, _nine_entries, _turned_body
from refdem.cases._algebra import Row, X, Y, Z
from refdem.core.parameters import Parameters

PRODUCTS: tuple[tuple[str, str, str], ...] = (
    ("z-then-x", "x+90", "z+90"),
    ("x-then-z", "z+90", "x+90"),
    ("globe", "x-90", "y-90"),
    ("two-halves", "x+180", "y+180"),
    ("x-y", "x+90", "y+90"),
    ("x-y-back", "x-y", "x-90"),
)
"""Matrix products: the name of the result, and those of its factors.

The factor on the right is applied first: "z-then-x" is Rx(90) Rz(90), in degrees.
"""

FACTORS: Mapping[str, float] = MappingProxyType(
    {
        **{name: 2.0 for name, _, _ in PRODUCTS},
        "x-y-back": 3.0,
        "globe-x": 2.0,
        "globe-angle": 2.0,
        "globe-determinant": 2.0,
        "euler-matrix": 3.0,
        "turn-phi-theta": 2.0,
        "euler-by-turns": 3.0,
        "turn-psi-theta-back": 2.0,
        "euler-inverse": 3.0,
        "euler-transposed": 3.0,
        "small-x-y": 2.0,
        "small-y-x": 2.0,
        "turn-commutator": 4.0,
        "beyond-leading": 4.0,
        "loop-back": 2.0,
        "loop": 4.0,
        "loop-angle": 4.0,
    }
)
"""The number of rotations that are multiplied or subtracted for a result, by its name.

Errors dA and dB of the factors change the product A B by dA B + A dB. Rotations preserve lengths,
so that the errors of the factors add up.
"""


def rows(p: Parameters) -> list[Row]:
    """All operations: rotations in the plane, products of rotations, Euler angles, energies, what
    commutes, and a step in nine entries and in four.
    """
    rotations: list[Row] = []
    for axis, unit in (("x", X), ("y", Y), ("z", Z)):
        for degrees in (90, -90, 180):
            radians = float(np.radians(degrees))
            rotations.append((f"{axis}{degrees:+d}", "turn-about", [unit, [radians]]))
    products: list[Row] = [
        (name, "matrix-product", [first, second]) for name, first, second in PRODUCTS
    ]
    globe: list[Row] = [
        ("globe-x", "matrix-vector", ["globe", X]),
        ("globe-angle", "turn-angle", ["globe"]),
        ("globe-determinant", "determinant", ["globe"]),
    ]
    known = _plane_rows(p) + rotations + products + globe + _euler_rows(p) + _energy_rows(p)
    of_bodies = _koenig.rows(p) + _turned_body.rows(p)
    return known + of_bodies + _commuting_rows(p) + _nine_entries.rows(p)


def _plane_rows(p: Parameters) -> list[Row]:
    """Rotation and reflection of a vector in the plane, and cosines of multiples of the angle."""
    angle = [p.angle]
    opposite = [-p.angle]
    v = p.vector.tolist()
    # R(a) = ((cos a, -sin a), (sin a, cos a)) for a = `angle` (1.9), R(-a) = R(a)^T = R(a)^-1.
    turns: list[Row] = [
        ("plane-turn", "plane-turn", [angle, v]),
        ("plane-clockwise", "plane-turn", [opposite, v]),
        ("plane-turned-back", "plane-turn", [opposite, "plane-turn"]),
    ]
    # R(a) multiplies x + i y by exp(i a), and has the eigenvalues cos a +- i |sin a| and the
    # determinant 1.
    as_complex: list[Row] = [
        ("complex-turn", "complex-turn", [angle, v]),
        ("plane-eigenvalue", "plane-eigenvalue", [angle]),
        ("plane-determinant", "plane-determinant", [angle]),
    ]
    # The reflection at the line with the angle a to x takes x + i y to exp(2 i a) (x - i y), and
    # has the determinant -1.
    mirrored: list[Row] = [
        ("mirror", "mirror", [angle, v]),
        ("mirror-determinant", "mirror-determinant", [angle]),
    ]
    return turns + as_complex + mirrored + _cosine_rows(p)


def _cosine_rows(p: Parameters) -> list[Row]:
    """Cosines of multiples of the angle, and the product of its cosine and that of phi."""
    angle = [p.angle]
    other_angle = [float(p.euler[0])]
    # cos(n a) = Re (cos a + i sin a)^n, and by the recurrence cos((k + 1) a) = 2 cos a cos(k a)
    # - cos((k - 1) a).
    of_multiples: list[Row] = [
        ("cosine-3", "cosine-by-powers", [angle, [3.0]]),
        ("cosine-4", "cosine-by-powers", [angle, [4.0]]),
        ("cosine-by-powers", "cosine-by-powers", [angle, [p.multiple]]),
        ("cosine-by-recurrence", "cosine-by-recurrence", [angle, [p.multiple]]),
    ]
    # cos a cos b = (cos(a - b) + cos(a + b))/2.
    of_products: list[Row] = [
        ("cosine-product", "cosine-product", [angle, other_angle]),
        ("cosines-mixed", "cosines-mixed", [angle, other_angle]),
    ]
    return of_multiples + of_products


def _commuting_rows(p: Parameters) -> list[Row]:
    """Two translations of a point in both orders, and two rotations by a small angle h in both
    orders: their commutator, its difference from the leading term h^2 [e_z], and the loop Rx(h)
    Ry(h) Rx(-h) Ry(-h).
    """
    shifts = p.shifts.tolist()
    first = shifts[:3]
    second = shifts[3:]
    translations: list[Row] = [
        ("shifted-first", "vector-sum", [X, first]),
        ("shifted-first-second", "vector-sum", ["shifted-first", second]),
        ("shifted-second", "vector-sum", [X, second]),
        ("shifted-second-first", "vector-sum", ["shifted-second", first]),
        ("shift-commutator", "vector-difference", ["shifted-first-second", "shifted-second-first"]),
    ]
    # Rx(h) Ry(h) - Ry(h) Rx(h) = h^2 [e_z] + O(h^3), with [e_z] r = e_z x r.
    h = p.small
    leading = [0.0, -h * h, 0.0, h * h, 0.0, 0.0, 0.0, 0.0, 0.0]
    both_orders: list[Row] = [
        ("small-x", "turn-about", [X, [h]]),
        ("small-y", "turn-about", [Y, [h]]),
        ("small-x-y", "matrix-product", ["small-x", "small-y"]),
        ("small-y-x", "matrix-product", ["small-y", "small-x"]),
        ("turn-commutator", "matrix-difference", ["small-x-y", "small-y-x"]),
        ("beyond-leading", "matrix-difference", ["turn-commutator", leading]),
    ]
    # Rx(h) Ry(h) Rx(-h) Ry(-h) is a rotation by h^2 about z, to leading order.
    loop: list[Row] = [
        ("small-x-back", "turn-about", [X, [-h]]),
        ("small-y-back", "turn-about", [Y, [-h]]),
        ("loop-back", "matrix-product", ["small-x-back", "small-y-back"]),
        ("loop", "matrix-product", ["small-x-y", "loop-back"]),
        ("loop-angle", "turn-angle", ["loop"]),
    ]
    return translations + both_orders + loop


def _euler_rows(p: Parameters) -> list[Row]:
    """Euler angles to a matrix and back, and their rates beside those of the quaternion."""
    euler = p.euler.tolist()
    omega = p.omega.tolist()
    # R = Rz(phi) Rx(theta) Rz(psi), body to space.
    angles: list[Row] = [
        ("euler-matrix", "matrix-of-euler", [euler]),
        ("euler-back", "euler-of-matrix", ["euler-matrix"]),
        ("euler-quaternion", "quaternion-of-euler", [euler]),
    ]
    # The same angles close to theta = 0, where their rates diverge.
    near = [euler[0], p.near, euler[2]]
    # phi', theta' and psi' by (1.39) to (1.41), and for the quaternion q' = (0, omega) q/2 (1.67).
    rates: list[Row] = [
        ("euler-rates", "euler-rates", [euler, omega]),
        ("near-rates", "euler-rates", [near, omega]),
        ("near-quaternion", "quaternion-of-euler", [near]),
        ("near-quaternion-rate", "rate", ["near-quaternion", omega]),
    ]
    # B in omega = B (phi', theta', psi'), B^-1, and B^-1 B = 1.
    matrices: list[Row] = [
        ("rate-matrix", "euler-rate-matrix", [euler]),
        ("rate-inverse", "euler-rate-inverse", [euler]),
        ("rate-one", "matrix-product", ["rate-inverse", "rate-matrix"]),
    ]
    return angles + rates + matrices + _euler_by_turns(p)


def _euler_by_turns(p: Parameters) -> list[Row]:
    """The matrix of Euler angles as a product of three rotations, its inverse as the product of the
    opposite rotations in the opposite order, its transpose; and a point rotated there and back.
    """
    phi, theta, psi = p.euler.tolist()
    # R = Rz(phi) Rx(theta) Rz(psi).
    there: list[Row] = [
        ("turn-phi", "turn-about", [Z, [phi]]),
        ("turn-theta", "turn-about", [X, [theta]]),
        ("turn-psi", "turn-about", [Z, [psi]]),
        ("turn-phi-theta", "matrix-product", ["turn-phi", "turn-theta"]),
        ("euler-by-turns", "matrix-product", ["turn-phi-theta", "turn-psi"]),
    ]
    # R^-1 = Rz(-psi) Rx(-theta) Rz(-phi) = R^T.
    back: list[Row] = [
        ("turn-phi-back", "turn-about", [Z, [-phi]]),
        ("turn-theta-back", "turn-about", [X, [-theta]]),
        ("turn-psi-back", "turn-about", [Z, [-psi]]),
        ("turn-psi-theta-back", "matrix-product", ["turn-psi-back", "turn-theta-back"]),
        ("euler-inverse", "matrix-product", ["turn-psi-theta-back", "turn-phi-back"]),
        ("euler-transposed", "transpose", ["euler-by-turns"]),
    ]
    point = p.shifts.tolist()[:3]
    # R^T (R r) = r.
    carried: list[Row] = [
        ("euler-carried", "matrix-vector", ["euler-by-turns", point]),
        ("euler-carried-back", "matrix-vector", ["euler-transposed", "euler-carried"]),
    ]
    return there + back + carried


def _energy_rows(p: Parameters) -> list[Row]:
    """Rotational energies of a unit inertia for omega = 2 pi f and for omega = f, and the square of
    the velocity omega x r of a point of a body at r, the first of the shifts, in three ways.
    """
    unit_inertia = [1.0]
    omega = p.omega.tolist()
    arm = p.shifts.tolist()[:3]
    # J omega^2/2 with omega = 2 pi f, and with f in its place: the ratio is (2 pi)^2.
    energies: list[Row] = [
        ("energy", "rotation-energy", [unit_inertia, [2 * np.pi * p.frequency]]),
        ("frequency-energy", "rotation-energy", [unit_inertia, [p.frequency]]),
        ("energy-ratio", "quotient", ["energy", "frequency-energy"]),
    ]
    # |omega x r|^2 = omega^2 r^2 - (omega . r)^2.
    squares: list[Row] = [
        ("swept", "cross", [omega, arm]),
        ("swept-square", "vector-dot", ["swept", "swept"]),
        ("swept-by-products", "cross-square", [omega, arm]),
    ]
    # r x (omega x r) = (r^2 1 - r r^T) omega, whose product with omega is |omega x r|^2.
    by_triple_product: list[Row] = [
        ("swept-twice", "cross", [arm, "swept"]),
        ("swept-by-triple", "vector-dot", [omega, "swept-twice"]),
    ]
    return energies + squares + by_triple_product


def sizes(p: Parameters) -> dict[str, float]:
    """The magnitudes of vectors, rates and energies by name of their row; the others have 1."""
    omega = float(np.linalg.norm(p.omega))
    v = float(np.linalg.norm(p.vector))
    # Euler angles change faster than the attitude by the factor 1/sin theta.
    steep = 1 / abs(np.sin(p.euler[1]))
    steep_near = 1 / np.sin(p.near)
    # J (2 pi f)^2/2 for J = 1.
    energy = 2 * (np.pi * p.frequency) ** 2
    # The rates contain omega cot theta and omega/sin theta, whose derivatives by theta are at most
    # omega/sin^2 theta.
    rates = {
        "euler-rates": omega * steep**2,
        "near-rates": omega * steep_near**2,
        "near-quaternion-rate": omega,
        "rate-inverse": steep**2,
        # Roundings of the angles count twice, in both factors.
        "rate-one": 2 * steep**2,
    }
    arm = float(np.linalg.norm(p.shifts[:3]))
    swept = {"swept": omega * arm}
    squares = ("swept-square", "swept-by-products", "swept-by-triple")
    swept |= dict.fromkeys(squares, 2 * (omega * arm) ** 2)
    swept["swept-twice"] = omega * arm**2
    # Three rotations there, and three back.
    carried = {"euler-carried": 3 * arm, "euler-carried-back": 6 * arm}
    energies = {"energy": energy, "frequency-energy": energy, "energy-ratio": 40.0}
    return {
        "plane-turn": v,
        "plane-clockwise": v,
        "plane-turned-back": v,
        "complex-turn": v,
        "mirror": v,
        **rates,
        **energies,
        **swept,
        **carried,
        "euler-back": np.pi * steep,
        **FACTORS,
        # The iteration of a solver for general matrices adds about ten roundings.
        "plane-eigenvalue": 4.0,
        **_sizes_of_cosines(p),
        **_sizes_of_shifts(p),
        **_koenig.sizes(p),
        **_turned_body.sizes(p),
        **_nine_entries.sizes(p),
    }


def _sizes_of_cosines(p: Parameters) -> dict[str, float]:
    """Sizes of the terms from which cosines of a multiple and products of cosines are computed."""
    sine = abs(np.sin(p.angle))
    cosine = abs(np.cos(p.angle))
    # The sum of the absolute terms of (cos + i sin)^n is at most (|cos| + |sin|)^n, and each power
    # has n roundings.
    n = max(1.0, p.multiple)
    terms = float(sine + cosine)
    # The recurrence multiplies a rounding error of cos(k a), with the angle a, by sin((n - k + 1)
    # a)/sin(a), which is at most n - k + 1 and at most 1/|sin(a)|.
    growth = min(n, 1 / max(float(sine), 1e-100))
    # Roundings of both angles, and of their sum and difference.
    mixed = 1 + abs(p.angle) + abs(float(p.euler[0]))
    return {
        "cosine-3": 3 * terms**3,
        "cosine-4": 4 * terms**4,
        "cosine-by-powers": n * terms**n,
        "cosine-by-recurrence": n * growth,
        "cosine-product": mixed,
        "cosines-mixed": mixed,
    }


def _sizes_of_shifts(p: Parameters) -> dict[str, float]:
    """The distances over which the point e_x is moved."""
    length = 1 + float(np.abs(p.shifts).sum())
    names = (
        "shifted-first",
        "shifted-first-second",
        "shifted-second",
        "shifted-second-first",
        "shift-commutator",
    )
    return dict.fromkeys(names, length)
