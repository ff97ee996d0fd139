"""The operations of the case rotations about a body and about a triangle: the energy of a turn by
angular momentum, principal moments of a turned tensor, and a height by vector rejection.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.cases._algebra import Row
from refdem.core.parameters import Parameters


def moments(p: Parameters) -> NDArray[np.float64]:
    """The principal moments (3,) of a body whose three masses lie on its axes, at the distance 1:
    that about an axis is the sum of the two masses on the others.
    """
    first, second, third = p.masses
    return np.array([second + third, first + third, first + second])


def rows(p: Parameters) -> list[Row]:
    """Energy and angular momentum of a turn about the third axis of the body, its tensor turned by
    Euler's angles, and a triangle.
    """
    return _spin_rows(p) + _tensor_rows(p) + _triangle_rows(p)


def _spin_rows(p: Parameters) -> list[Row]:
    """A turn about a principal axis: the energy by J omega^2/2, and by L^2/(2 J) with L = J
    omega.
    """
    inertia = [float(moments(p)[2])]
    omega = [2 * np.pi * p.frequency]
    return [
        ("spin-energy", "rotation-energy", [inertia, omega]),
        ("spin-momentum", "spin-momentum", [inertia, omega]),
        ("momentum-energy", "momentum-energy", ["spin-momentum", inertia]),
    ]


def _tensor_rows(p: Parameters) -> list[Row]:
    """The tensor R J R^T of the body in space (1.30), whose eigenvalues are the principal moments,
    and the angular momentum by it.
    """
    diagonal = np.diag(moments(p)).ravel().tolist()
    return [
        ("half-turned-tensor", "matrix-product", ["euler-by-turns", diagonal]),
        ("turned-tensor", "matrix-product", ["half-turned-tensor", "euler-transposed"]),
        ("principal-moments", "principal-moments", ["turned-tensor"]),
        ("turned-momentum", "matrix-vector", ["turned-tensor", p.omega.tolist()]),
    ]


def _triangle_rows(p: Parameters) -> list[Row]:
    """The height of the triangle with the corners 0, a and b over the side b, for the two shifts a
    and b: by vector rejection, and as twice the area over the base.
    """
    shifts = p.shifts.tolist()
    corner = shifts[:3]
    base = shifts[3:]
    return [
        ("rejection", "rejection", [corner, base]),
        ("height", "length", ["rejection"]),
        ("corner-by-base", "cross", [corner, base]),
        ("twice-area", "length", ["corner-by-base"]),
        ("base", "length", [base]),
        ("height-by-area", "quotient", ["twice-area", "base"]),
    ]


def sizes(p: Parameters) -> dict[str, float]:
    """The magnitudes of the results by name, times the number of their factors that are rounded."""
    largest = float(moments(p).max())
    spin = 2 * np.pi * p.frequency
    inertia = float(moments(p)[2])
    energy = inertia * spin**2 / 2
    tensor = 7 * largest
    corner = float(np.linalg.norm(p.shifts[:3]))
    base = float(np.linalg.norm(p.shifts[3:]))
    return {
        # J = m1 + m2 is rounded twice, omega = 2 pi f three times, their product once; omega and L
        # count twice in a square.
        "spin-energy": 3 * energy,
        "spin-momentum": 2 * inertia * spin,
        "momentum-energy": 4 * energy,
        # Three turns on each side of J.
        "half-turned-tensor": 4 * largest,
        "turned-tensor": tensor,
        # An error of the tensor moves eigenvalues by no more than its norm, up to 3 entries'.
        "principal-moments": 3 * tensor,
        "turned-momentum": 2 * tensor * float(np.linalg.norm(p.omega)),
        # The direction of the base is rounded in both places where it stands.
        **dict.fromkeys(("rejection", "height", "height-by-area"), 3 * corner),
        **dict.fromkeys(("corner-by-base", "twice-area"), 2 * corner * base),
        "base": base,
    }
