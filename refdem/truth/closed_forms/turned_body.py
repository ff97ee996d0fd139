"""A body of three point masses on its axes: its rotation about a principal axis, its inertia tensor
in space and angular momentum; and the height of a triangle, in rational numbers up to one root.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.koenig import cross
from refdem.truth.exact import number, vector


def values(p: Parameters, rotation: Sequence[arb]) -> dict[str, list[arb]]:
    """The rows of the body and of the triangle, by name; `rotation` is R row by row, from the body
    to space.
    """
    return spin(p) | tensor(p, rotation) | triangle(p)


def moments(p: Parameters) -> list[Fraction]:
    """The principal moments of the body: the sum of the two masses off each axis, at distance 1."""
    first, second, third = vector(p, "masses")
    # J_i = sum over the masses off axis i of m_j.
    return [second + third, first + third, first + second]


def spin(p: Parameters) -> dict[str, list[arb]]:
    """Energy J omega^2/2 and angular momentum J omega about the third axis, omega = 2 pi f."""
    # J omega^2/2 = 2 J (pi f)^2
    inertia = arb_of(moments(p)[2])
    frequency = arb_of(number(p, "frequency"))
    energy = 2 * inertia * (arb.pi() * frequency) ** 2
    return {
        "spin-energy": [energy],
        "spin-momentum": [2 * arb.pi() * frequency * inertia],
        # L^2/(2 J) = J omega^2/2.
        "momentum-energy": [energy],
    }


def tensor(p: Parameters, rotation: Sequence[arb]) -> dict[str, list[arb]]:
    """R J, R J R^T, its eigenvalues, which are those of J, and R J R^T omega."""
    exact = moments(p)
    inertia = [arb_of(moment) for moment in exact]
    omega = [arb_of(x) for x in vector(p, "omega")]
    axes = range(3)
    # (R J)_ij = R_ij J_j, as J is diagonal.
    half = [rotation[3 * i + j] * inertia[j] for i in axes for j in axes]
    whole = []
    for i in axes:
        for j in axes:
            # (R J R^T)_ij = sum_k (R J)_ik R_jk.
            entries = (half[3 * i + k] * rotation[3 * j + k] for k in axes)
            whole.append(sum(entries, arb(0)))
    # L = R J R^T omega.
    momentum = [sum((whole[3 * i + j] * omega[j] for j in axes), arb(0)) for i in axes]
    return {
        "half-turned-tensor": half,
        "turned-tensor": whole,
        "principal-moments": [arb_of(moment) for moment in sorted(exact)],
        "turned-momentum": momentum,
    }


def triangle(p: Parameters) -> dict[str, list[arb]]:
    """The height over the base b of the corner a: the length of a - (a . b) b/b^2."""
    shifts = vector(p, "shifts")
    corner = shifts[:3]
    base = shifts[3:]
    zero = Fraction(0)
    along = sum((x * y for x, y in zip(corner, base, strict=True)), zero)
    base_square = sum((x * x for x in base), zero)
    # a - (a . b) b/b^2.
    rejection = [x - along * y / base_square for x, y in zip(corner, base, strict=True)]
    crossed = cross(corner, base)
    height = arb_of(sum((x * x for x in rejection), zero)).sqrt()
    return {
        "rejection": [arb_of(x) for x in rejection],
        "height": [height],
        "corner-by-base": [arb_of(x) for x in crossed],
        "twice-area": [arb_of(sum((x * x for x in crossed), zero)).sqrt()],
        "base": [arb_of(base_square).sqrt()],
        # |a x b|/|b|, twice the area over the base, equals the height.
        "height-by-area": [height],
    }
