"""Quaternion algebra by complex matrices 2 x 2 in ball arithmetic: q stands for w 1 - i (x s1 + y
s2 + z s3).

Sums, products and conjugates are those of matrices; q is read back from the first column (w - i z,
y - i x).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import acb, acb_mat, arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.exact import vector
from refdem.truth.timeless import Timeless


def of_numbers(q: Sequence[Fraction]) -> acb_mat:
    """The matrix of (w, x, y, z); of (x, y, z) with w = 0."""
    w, x, y, z = (arb_of(number) for number in ((Fraction(0), *q) if len(q) == 3 else q))
    return acb_mat([[acb(w, -z), acb(-y, -x)], [acb(y, -x), acb(w, z)]])


def numbers_of(m: acb_mat) -> list[arb]:
    """The quaternion (w, x, y, z) of a complex 2 x 2 matrix."""
    return [m[0, 0].real, -m[1, 0].imag, m[1, 0].real, -m[0, 0].imag]


def conjugated(m: acb_mat) -> acb_mat:
    """The conjugate: of such a matrix, the conjugate transpose."""
    return acb_mat([[m[j, i].conjugate() for j in range(2)] for i in range(2)])


def absolute(m: acb_mat) -> arb:
    """|q|: the root of the determinant."""
    return (m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]).real.sqrt()


def turned(u: acb_mat, v: acb_mat) -> list[arb]:
    """The vector v rotated by the quaternion u: u v u*."""
    return numbers_of(u * v * conjugated(u))[1:]


def euler(u: acb_mat) -> list[arb]:
    """phi, theta, psi: psi + phi and psi - phi are twice the phases of (w + i z) and of (x + i y),
    theta twice that of their sizes.
    """
    w, x, y, z = numbers_of(u)
    total = acb(w, z)
    apart = acb(x, y)
    theta = 2 * acb(abs(total), abs(apart)).arg()
    return [wrapped(total.arg() + apart.arg()), theta, wrapped(total.arg() - apart.arg())]


def wrapped(angle: arb) -> arb:
    """The angle in (-pi, pi]; UndecidedError if a ball lies on both sides of the end."""
    if angle > arb.pi():
        return angle - 2 * arb.pi()
    if angle < -arb.pi():
        return angle + 2 * arb.pi()
    if angle < arb.pi() and angle > -arb.pi():
        return angle
    raise UndecidedError("an Euler angle at the end of its range")


def values(p: Parameters) -> dict[str, list[arb]]:
    """The value of every row of the case."""
    b = of_numbers(vector(p, "q"))
    size = absolute(b)
    u = b / acb(size)
    matrices = products(p, b, size) | rates(p, u)
    return {name: numbers_of(m) for name, m in matrices.items()} | turns(p, b, size, u)


def products(p: Parameters, b: acb_mat, size: arb) -> dict[str, acb_mat]:
    """Products, sums, conjugates, the inverse and the unit quaternion of p, q and r; `b` is q and
    `size` is |q|.
    """
    a = of_numbers(vector(p, "p"))
    c = of_numbers(vector(p, "r"))
    return {
        "p-q": a * b,
        "q-p": b * a,
        "commutator": a * b - b * a,
        "q-r": b * c,
        "left": a * b * c,
        "right": a * b * c,
        "conjugate-of-product": conjugated(b) * conjugated(a),
        "sum": a + b,
        "conjugate-of-sum": conjugated(a) + conjugated(b),
        # q* / |q|^2
        "inverse": conjugated(b) / acb(size * size),
        "one": of_numbers((Fraction(1),) + (Fraction(0),) * 3),
        "u": b / acb(size),
        "real-product": a * b,
        "complex-product": a * b,
    }


def rates(p: Parameters, u: acb_mat) -> dict[str, acb_mat]:
    """What the unit quaternion u gives, and its rates under omega in space: u' = omega u/2."""
    omega = of_numbers(vector(p, "omega"))
    rise = of_numbers(vector(p, "rise"))
    half = acb(1) / 2
    rate = omega * u * half
    if numbers_of(u)[0] < 0:
        sign = acb(-1)
    else:
        sign = acb(1)
    return {
        "-u": -u,
        "back": u * sign,
        "turned-twice": u * u,
        "rate": rate,
        # u'' = (omega' u + omega^2 u/2)/2
        "second-rate": (rise * u + omega * omega * u * half) * half,
        "rate-conjugate": conjugated(rate),
        "u-conjugate": conjugated(u),
        "u-rate": u * conjugated(rate),
        "rate-u": rate * conjugated(u),
        "anticommute": omega - omega,
    }


def turns(p: Parameters, b: acb_mat, size: arb, u: acb_mat) -> dict[str, list[arb]]:
    """Vectors turned by u, its matrix and Euler's angles; omega in space and in the body."""
    v = of_numbers(vector(p, "vector"))
    omega = of_numbers(vector(p, "omega"))
    w, *imaginary = numbers_of(b)
    basis = [of_numbers([Fraction(int(i == k)) for i in range(3)]) for k in range(3)]
    columns = [turned(u, e) for e in basis]
    once = turned(u, v)
    return {
        "absolute": [size],
        "complex-eigenvalue": [w, sum((x * x for x in imaginary), arb(0)).sqrt()],
        "rotated": once,
        "rotated-by-minus-u": once,
        "matrix": [columns[k][i] for i in range(3) for k in range(3)],
        "euler": euler(u),
        "rotated-twice": turned(u, of_balls(once)),
        "orthogonal": [arb(0)],
        "omega-back": numbers_of(omega)[1:],
        "omega-body": turned(conjugated(u), omega),
    }


def of_balls(v: Sequence[arb]) -> acb_mat:
    """The matrix of a vector of balls."""
    x, y, z = v
    return acb_mat([[acb(0, -z), acb(-y, -x)], [acb(y, -x), acb(0, z)]])


def listed(found: Mapping[str, Sequence[arb]]) -> dict[str, arb]:
    """Rows as quantities: `name`, or `name.0`, `name.1` ... where there are several numbers."""
    return {
        (name if len(numbers) == 1 else f"{name}.{i}"): number
        for name, numbers in found.items()
        for i, number in enumerate(numbers)
    }


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters p, q, r, vector, omega, rise."""
    return Timeless(
        scale, lambda: listed(values(p)), witness="Hamilton's products in rational arithmetic"
    )
