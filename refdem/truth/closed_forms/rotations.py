"""Rotations of vectors and planes: whole numbers for quarter turns, sines and cosines written out
for the others.

Euler's angles are z-x-z: the rotation is R = R_z(phi) R_x(theta) R_z(psi), from body axes to space
axes. Quaternions are (w, x, y, z). Numbers in parentheses, as (1.39), are equations of Matuttis and
Chen 2014.
"""

from collections.abc import Mapping

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms import koenig, nine_entries, turned_body
from refdem.truth.closed_forms.quaternions import listed
from refdem.truth.complex_balls import Complex
from refdem.truth.exact import number, vector
from refdem.truth.refiner import Refiner
from refdem.truth.rotation import times
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
    """The rates phi', theta', psi' [rad/s] of Euler's angles, from omega [rad/s] in space axes.

    (1.39) to (1.41), with c = omega_x sin phi - omega_y cos phi:

        phi' = omega_z - c cot theta,  theta' = omega_x cos phi + omega_y sin phi,
        psi' = c/sin theta.
    """
    omega_x, omega_y, omega_z = omega
    c = omega_x * phi.sin() - omega_y * phi.cos()
    phi_rate = omega_z - c * theta.cos() / theta.sin()
    theta_rate = omega_x * phi.cos() + omega_y * phi.sin()
    psi_rate = c / theta.sin()
    return [phi_rate, theta_rate, psi_rate]


def quaternion(phi: arb, theta: arb, psi: arb) -> list[arb]:
    """The quaternion (w, x, y, z) of Euler's angles [rad], by (1.76) to (1.79).

    With c = cos(theta/2) and s = sin(theta/2),

        w + i z = c exp(i (phi + psi)/2),  x + i y = s exp(i (phi - psi)/2).
    """
    c = (theta / 2).cos()
    s = (theta / 2).sin()
    half_sum = (phi + psi) / 2
    half_difference = (phi - psi) / 2
    w = c * half_sum.cos()
    x = s * half_difference.cos()
    y = s * half_difference.sin()
    z = c * half_sum.sin()
    return [w, x, y, z]


def euler_matrix(phi: arb, theta: arb, psi: arb) -> list[arb]:
    """The matrix R = R_z(phi) R_x(theta) R_z(psi) (body to space), row by row.

    It is the transpose of (1.21), which leads from space to the body.
    """
    sin_phi, cos_phi = phi.sin_cos()
    sin_theta, cos_theta = theta.sin_cos()
    sin_psi, cos_psi = psi.sin_cos()
    row_x = [
        cos_phi * cos_psi - sin_phi * cos_theta * sin_psi,
        -cos_phi * sin_psi - sin_phi * cos_theta * cos_psi,
        sin_phi * sin_theta,
    ]
    row_y = [
        sin_phi * cos_psi + cos_phi * cos_theta * sin_psi,
        -sin_phi * sin_psi + cos_phi * cos_theta * cos_psi,
        -cos_phi * sin_theta,
    ]
    row_z = [sin_theta * sin_psi, sin_theta * cos_psi, cos_theta]
    return [*row_x, *row_y, *row_z]


def rate_rows(phi: arb, theta: arb) -> dict[str, list[arb]]:
    """The matrix that takes rates of Euler's angles to omega in space axes, and its inverse, which
    is (1.39) to (1.41), row by row.
    """
    sine, cosine = phi.sin_cos()
    zero = arb(0)
    one = arb(1)
    cotangent = theta.cos() / theta.sin()
    # The columns are the axes of the three rotations: z, the line of nodes, the body's third axis.
    matrix_rows = [
        [zero, cosine, sine * theta.sin()],
        [zero, sine, -cosine * theta.sin()],
        [one, zero, theta.cos()],
    ]
    # phi', theta' and psi' for omega = e_x, e_y and e_z in the columns.
    inverse_rows = [
        [-sine * cotangent, cosine * cotangent, one],
        [cosine, sine, zero],
        [sine / theta.sin(), -cosine / theta.sin(), zero],
    ]
    return {
        "rate-matrix": [entry for row in matrix_rows for entry in row],
        "rate-inverse": [entry for row in inverse_rows for entry in row],
        "rate-one": [one, zero, zero, zero, one, zero, zero, zero, one],
    }


def swept(p: Parameters) -> dict[str, list[arb]]:
    """omega x r of the point r, and its square, in rational numbers."""
    a, b, c = vector(p, "omega")
    x, y, z = vector(p, "shifts")[:3]
    # |omega x r|^2 = |omega|^2 r^2 - (omega . r)^2, computed as the square of the vector.
    crossed = [b * z - c * y, c * x - a * z, a * y - b * x]
    square = sum(component * component for component in crossed)
    arm_square = x * x + y * y + z * z
    along = a * x + b * y + c * z
    return {
        "swept": [arb_of(component) for component in crossed],
        "swept-square": [arb_of(square)],
        "swept-by-products": [arb_of(square)],
        # r x (omega x r) = r^2 omega - (r . omega) r.
        "swept-twice": [
            arb_of(arm_square * turning - along * arm)
            for turning, arm in zip((a, b, c), (x, y, z), strict=True)
        ],
        "swept-by-triple": [arb_of(square)],
    }


def values(p: Parameters) -> dict[str, list[arb]]:
    """The numbers of every row of the case, by the row's name."""
    frequency = arb_of(number(p, "frequency"))
    quarter_turns = {name: [arb(n) for n in entries] for name, entries in TURNS.items()}
    energies = {
        # Energy per moment of inertia: omega^2/2 with omega = 2 pi f.
        "energy": [2 * (arb.pi() * frequency) ** 2],
        # The same with f by mistake in the place of omega: too small by 4 pi^2.
        "frequency-energy": [frequency * frequency / 2],
        "energy-ratio": [4 * arb.pi() ** 2],
    }
    euler = [arb_of(angle) for angle in vector(p, "euler")]
    step = nine_entries.values(p, euler_matrix(*euler), quaternion(*euler))
    angles = in_the_plane(p) | of_multiples(p) | by_euler(p) | rate_rows(*euler[:2]) | swept(p)
    angles |= euler_by_turns(p)
    commuting = shifted(p) | by_small_turns(p)
    bodies = koenig.values(p) | turned_body.values(p, euler_matrix(*euler))
    return quarter_turns | angles | energies | bodies | commuting | step


def euler_by_turns(p: Parameters) -> dict[str, list[arb]]:
    """The three turns of Euler's angles, R_z(phi) R_x(theta) R_z(psi), their inverse, and the first
    of the shifts r as R r and R^T (R r) = r.

    A turn by the opposite angle has -s for its sine s.
    """
    phi, theta, psi = (arb_of(angle) for angle in vector(p, "euler"))
    s_phi, c_phi = phi.sin_cos()
    s_theta, c_theta = theta.sin_cos()
    s_psi, c_psi = psi.sin_cos()
    # R = Rz(phi) Rx(theta) Rz(psi), from the left.
    whole = euler_matrix(phi, theta, psi)
    there = {
        "turn-phi": about_z(s_phi, c_phi),
        "turn-theta": about_x(s_theta, c_theta),
        "turn-psi": about_z(s_psi, c_psi),
        "turn-phi-theta": about_z_after_x(s_phi, c_phi, s_theta, c_theta),
        "euler-by-turns": whole,
    }
    # R^-1 = Rz(-psi) Rx(-theta) Rz(-phi) = R^T.
    transposed = [whole[3 * j + i] for i in range(3) for j in range(3)]
    back = {
        "turn-phi-back": about_z(-s_phi, c_phi),
        "turn-theta-back": about_x(-s_theta, c_theta),
        "turn-psi-back": about_z(-s_psi, c_psi),
        "turn-psi-theta-back": about_z_after_x(-s_psi, c_psi, -s_theta, c_theta),
        "euler-inverse": transposed,
        "euler-transposed": transposed,
    }
    # (R r)_i = sum_j R_ij r_j, and R^T (R r) = r.
    arm = [arb_of(x) for x in vector(p, "shifts")[:3]]
    carried = [sum((whole[3 * i + j] * arm[j] for j in range(3)), arb(0)) for i in range(3)]
    return there | back | {"euler-carried": carried, "euler-carried-back": arm}


def about_x(s: arb, c: arb) -> list[arb]:
    """The matrix Rx of a turn about x, row by row, from sine and cosine of its angle."""
    zero = arb(0)
    return [arb(1), zero, zero, zero, c, -s, zero, s, c]


def about_z(s: arb, c: arb) -> list[arb]:
    """The matrix Rz of a turn about z, row by row, from sine and cosine of its angle."""
    zero = arb(0)
    return [c, -s, zero, s, c, zero, zero, zero, arb(1)]


def about_z_after_x(s_z: arb, c_z: arb, s_x: arb, c_x: arb) -> list[arb]:
    """The product Rz Rx, row by row, from sines and cosines of both angles."""
    row_x = [c_z, -s_z * c_x, s_z * s_x]
    row_y = [s_z, c_z * c_x, -c_z * s_x]
    row_z = [arb(0), s_x, c_x]
    return [*row_x, *row_y, *row_z]


def of_multiples(p: Parameters) -> dict[str, list[arb]]:
    """Cosines of 3, 4 and n times the angle, and the product of its cosine and that of phi."""
    angle = arb_of(number(p, "angle"))
    other_angle = arb_of(vector(p, "euler")[0])
    product = angle.cos() * other_angle.cos()
    cosine = (angle * arb_of(number(p, "multiple"))).cos()
    return {
        "cosine-3": [(3 * angle).cos()],
        "cosine-4": [(4 * angle).cos()],
        "cosine-by-powers": [cosine],
        "cosine-by-recurrence": [cosine],
        "cosine-product": [product],
        "cosines-mixed": [product],
    }


def shifted(p: Parameters) -> dict[str, list[arb]]:
    """The point e_x after two translations, in both orders: the same place."""
    shifts = vector(p, "shifts")
    first = shifts[:3]
    second = shifts[3:]
    start = (1, 0, 0)
    both = [x + y + z for x, y, z in zip(start, first, second, strict=True)]
    return {
        "shifted-first": [arb_of(x + y) for x, y in zip(start, first, strict=True)],
        "shifted-first-second": [arb_of(x) for x in both],
        "shifted-second": [arb_of(x + y) for x, y in zip(start, second, strict=True)],
        "shifted-second-first": [arb_of(x) for x in both],
        "shift-commutator": [arb(0)] * 3,
    }


def by_small_turns(p: Parameters) -> dict[str, list[arb]]:
    """Turns by the angle h about x and y, with s = sin h and c = cos h.

    Their commutator has s^2 in the plane x-y, the leading term h^2 [e_z], and s (1 - c), of third
    order, beside it. The loop Rx(h) Ry(h) Rx(-h) Ry(-h) has the scalar 1 - 2 sin^4(h/2) of its
    quaternion: it turns by 4 asin(sin^2(h/2)), which is h^2 to leading order.
    """
    h = arb_of(number(p, "small"))
    s, c = h.sin_cos()
    zero = arb(0)
    one = arb(1)
    small_x = about_x(s, c)
    small_y = [c, zero, s, zero, one, zero, -s, zero, c]
    # Rx(h) Ry(h) and Ry(h) Rx(h).
    x_after_y = [c, zero, s, s * s, c, -s * c, -s * c, s, c * c]
    y_after_x = [c, s * s, s * c, zero, c, -s, -s, s * c, c * c]
    # Both orders differ by s^2 in the plane, and by s (1 - c) in the entries beside it.
    third = s * (1 - c)
    beside = [third, third, third, zero]
    commutator = [zero, -s * s, third, s * s, zero, *beside]
    # The commutator less h^2 [e_z].
    beyond = s * s - h * h
    beyond_leading = [zero, -beyond, third, beyond, zero, *beside]
    # Turns by -h have -s for s.
    small_x_back = about_x(-s, c)
    small_y_back = [c, zero, -s, zero, one, zero, s, zero, c]
    both_back = [c, zero, -s, s * s, c, s * c, s * c, -s, c * c]
    # cos(angle/2) = 1 - 2 sin^4(h/2), so that sin(angle/4) = sin^2(h/2).
    loop_angle = 4 * ((h / 2).sin() ** 2).asin()
    return {
        "small-x": small_x,
        "small-y": small_y,
        "small-x-y": x_after_y,
        "small-y-x": y_after_x,
        "turn-commutator": commutator,
        "beyond-leading": beyond_leading,
        "small-x-back": small_x_back,
        "small-y-back": small_y_back,
        "loop-back": both_back,
        "loop": loop(s, c),
        "loop-angle": [loop_angle],
    }


def loop(s: arb, c: arb) -> list[arb]:
    """Rx(h) Ry(h) Rx(-h) Ry(-h), row by row, with s = sin h and c = cos h."""
    row_x = [c * c + s * s * c, -s * s, s * c * (c - 1)]
    row_y = [s * s * c * (2 - c), c * c + s * s * c, s * c * c * (1 - c) - s**3]
    row_z = [s**3 - s * c * c * (1 - c), s * c * (1 - c), 2 * s * s * c + c**4]
    return [*row_x, *row_y, *row_z]


def in_the_plane(p: Parameters) -> dict[str, list[arb]]:
    """The plane vector v = x + i y turned by an angle a, and mirrored at the line at that angle.

    The turn is exp(i a) v; its matrix has the eigenvalues cos a +- i |sin a|. The mirror image is
    exp(2 i a) conj(v): turn the line onto the x axis, change the sign of y, turn back.
    """
    angle = arb_of(number(p, "angle"))
    x, y = (arb_of(component) for component in vector(p, "vector"))
    v = Complex(x, y)
    turned = Complex(angle.cos(), angle.sin()) * v
    clockwise = Complex(angle.cos(), -angle.sin()) * v
    mirrored = Complex((2 * angle).cos(), (2 * angle).sin()) * v.conjugate()
    return {
        "plane-turn": [turned.real, turned.imag],
        "complex-turn": [turned.real, turned.imag],
        "plane-clockwise": [clockwise.real, clockwise.imag],
        "plane-turned-back": [x, y],
        "plane-eigenvalue": [angle.cos(), abs(angle.sin())],
        "mirror": [mirrored.real, mirrored.imag],
        # Rx(-90) Ry(-90) (the row "globe") is one turn by 120 degrees.
        "globe-angle": [2 * arb.pi() / 3],
    }


def by_euler(p: Parameters) -> dict[str, list[arb]]:
    """Euler's angles with their matrix, quaternion and rates.

    The rows `near-...` have the small angle `near` [rad] in the place of theta, where the rates of
    Euler's angles diverge as 1/sin theta and those of the quaternion do not.
    """
    near = arb_of(number(p, "near"))
    phi, theta, psi = (arb_of(angle) for angle in vector(p, "euler"))
    omega_x, omega_y, omega_z = (arb_of(component) for component in vector(p, "omega"))
    omega = (omega_x, omega_y, omega_z)
    near_quaternion = quaternion(phi, near, psi)
    # q' = omega q/2 (1.67).
    omega_q = times([arb(0), *omega], near_quaternion)
    return {
        "euler-matrix": euler_matrix(phi, theta, psi),
        "euler-back": [phi, theta, psi],
        "euler-quaternion": quaternion(phi, theta, psi),
        "euler-rates": rates(phi, theta, omega),
        "near-rates": rates(phi, near, omega),
        "near-quaternion": near_quaternion,
        "near-quaternion-rate": [component / 2 for component in omega_q],
    }


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters angle [rad], vector, euler [rad], omega [rad/s], near [rad],
    frequency [Hz], shifts, small [rad], step [s], multiple.

    `scale` maps every quantity to the size against which its error counts.
    """
    return Timeless(
        Refiner.of(scale),
        lambda: listed(values(p)),
        witness="products of matrices of sines and cosines",
    )
