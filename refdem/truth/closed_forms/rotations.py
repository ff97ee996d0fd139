"""Rotations of vectors and planes: whole numbers for quarter turns, sines and cosines written out
for the others.
"""

from collections.abc import Mapping

from flint import acb, arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.quaternions import listed
from refdem.truth.exact import number, vector
from refdem.truth.timeless import Timeless

TURNS = {
    "x+90": (1, 0, 0, 0, 0, -1, 0, 1, 0),
    "x-90": (1, 0, 0, 0, 0, 1, 0, -1, 0),
    "x+180": (1, 0, 0, 0, -1, 0, 0, 0, -1),
    "y+90": (0, 0, 1, 0, 1, 0, -1, 0, 0),
    "y-90": (0, 0, -1, 0, 1, 0, 1, 0, 0),
    "y+180": (-1, 0, 0, 0, 1, 0, 0, 0, -1),
    "z+90": (0, -1, 0, 1, 0, 0, 0, 0, 1),
    "z-90": (0, 1, 0, -1, 0, 0, 0, 0, 1),
    "z+180": (-1, 0, 0, 0, -1, 0, 0, 0, 1),
    "z-then-x": (0, -1, 0, 0, 0, -1, 1, 0, 0),
    "x-then-z": (0, 0, 1, 1, 0, 0, 0, 1, 0),
    "globe": (0, 0, -1, 1, 0, 0, 0, -1, 0),
    "two-halves": (-1, 0, 0, 0, -1, 0, 0, 0, 1),
    "x-y": (0, 0, 1, 1, 0, 0, 0, 1, 0),
    "x-y-back": (0, -1, 0, 1, 0, 0, 0, 0, 1),
    "globe-x": (0, 1, 0),
    "globe-determinant": (1,),
    "plane-determinant": (1,),
    "mirror-determinant": (-1,),
}
"""Matrices row by row. x-y-back, Rx(90) Ry(90) Rx(-90), and two-halves, Rx(180) Ry(180), are turns
about z.
"""


def rates(phi: arb, theta: arb, omega: tuple[arb, arb, arb]) -> list[arb]:
    """phi', theta', psi' (1.39) to (1.41) in space axes."""
    x, y, z = omega
    across = x * phi.sin() - y * phi.cos()
    return [
        z - across * theta.cos() / theta.sin(),
        x * phi.cos() + y * phi.sin(),
        across / theta.sin(),
    ]


def quaternion(phi: arb, theta: arb, psi: arb) -> list[arb]:
    """The quaternion (w, x, y, z) of Euler angles, by (1.76) to (1.79)."""
    c = (theta / 2).cos()
    s = (theta / 2).sin()
    total = (phi + psi) / 2
    apart = (phi - psi) / 2
    return [c * total.cos(), s * apart.cos(), s * apart.sin(), c * total.sin()]


def euler_matrix(phi: arb, theta: arb, psi: arb) -> list[arb]:
    """The transpose of (1.21), row by row."""
    sf, cf = phi.sin_cos()
    st, ct = theta.sin_cos()
    sp, cp = psi.sin_cos()
    first = [cf * cp - sf * ct * sp, -cf * sp - sf * ct * cp, sf * st]
    second = [sf * cp + cf * ct * sp, -sf * sp + cf * ct * cp, -cf * st]
    third = [st * sp, st * cp, ct]
    return [*first, *second, *third]


def values(p: Parameters) -> dict[str, list[arb]]:
    """The value of every row of the case."""
    frequency = arb_of(number(p, "frequency"))
    whole = {name: [arb(n) for n in entries] for name, entries in TURNS.items()}
    # Energy per moment of inertia, omega^2/2 with omega = 2 pi f.
    energies = {
        "energy": [2 * (arb.pi() * frequency) ** 2],
        "frequency-energy": [frequency * frequency / 2],
        "energy-ratio": [4 * arb.pi() ** 2],
    }
    return whole | in_the_plane(p) | by_euler(p) | energies


def in_the_plane(p: Parameters) -> dict[str, list[arb]]:
    """A turn of the plane by an angle, and the mirror at the line at that angle."""
    angle = arb_of(number(p, "angle"))
    v = acb(*(arb_of(x) for x in vector(p, "vector")))
    # exp(i a) v, and exp(2 i a) conj(v).
    turned = acb(angle.cos(), angle.sin()) * v
    mirrored = acb((2 * angle).cos(), (2 * angle).sin()) * v.conjugate()
    return {
        "plane-turn": [turned.real, turned.imag],
        "complex-turn": [turned.real, turned.imag],
        "plane-eigenvalue": [angle.cos(), abs(angle.sin())],
        "mirror": [mirrored.real, mirrored.imag],
        "globe-angle": [2 * arb.pi() / 3],
    }


def by_euler(p: Parameters) -> dict[str, list[arb]]:
    """Euler's angles, with their rates, also next to their singularity."""
    near = arb_of(number(p, "near"))
    phi, theta, psi = (arb_of(x) for x in vector(p, "euler"))
    x, y, z = (arb_of(w) for w in vector(p, "omega"))
    q0, q1, q2, q3 = tilted = quaternion(phi, near, psi)
    # omega q, of which q' is half.
    rising = [
        -x * q1 - y * q2 - z * q3,
        x * q0 + y * q3 - z * q2,
        y * q0 + z * q1 - x * q3,
        z * q0 + x * q2 - y * q1,
    ]
    return {
        "euler-matrix": euler_matrix(phi, theta, psi),
        "euler-back": [phi, theta, psi],
        "euler-quaternion": quaternion(phi, theta, psi),
        "euler-rates": rates(phi, theta, (x, y, z)),
        "near-rates": rates(phi, near, (x, y, z)),
        "near-quaternion": tilted,
        "near-quaternion-rate": [each / 2 for each in rising],
    }


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters angle, vector, euler, omega, near, frequency."""
    return Timeless(
        scale, lambda: listed(values(p)), witness="products of matrices of sines and cosines"
    )
