"""Certified heavy top: validated integration of its motion; nutation and its period by an elliptic
integral.

The symmetric top of mass m turns about its fixed tip; its centre of mass lies at the distance l
from the tip along the axis n, which is tilted by theta from the vertical. J1 is the moment of
inertia across the axis, J3 about it, both about the tip. Conserved are the energy, the vertical
angular momentum L_z and the spin w3 = omega . n.

Nutation: with u = cos theta and

    b = L_z/J1,  a = J3 w3/J1,  beta = 2 m g l/J1,
    alpha = theta'^2 + phi'^2 sin^2 theta + beta u    at the start,

the conservation laws give u'^2 = f(u) = (alpha - beta u)(1 - u^2) - (b - a u)^2. Its roots are u1
<= u2 <= 1 <= u3; u moves between u1 and u2, there and back in the time 4 K(m)/sqrt(beta (u3 - u1)),
m = (u2 - u1)/(u3 - u1) (Whittaker, Analytical Dynamics, section 71).

Motion: Euler's angles z-x-z where the axis stays off the verticals (`by_angles`); where it comes
near one of them, the axis n and the angular momentum L as vectors in space (`by_axis`).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from flint import acb, acb_poly, arb, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.dual import atan2
from refdem.truth.exact import numbers, vector
from refdem.truth.refiner import FIRST_BITS, Size
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import Reading, ValidatedFlow

UPRIGHT = 0.995
"""Where |cos theta| may reach this value, `by_axis` is used in place of `by_angles`."""
LEAST_TILT = Fraction(1, 100)
"""Least tilt [rad] from a vertical of a motion that is integrated in Euler's angles."""
LEAST_TOLD = Fraction(1, 10**12)
"""The same [rad] where n and L are integrated. These are regular on the vertical, but the reported
angles phi and psi are not defined there.
"""
DOUBLINGS = 6
"""How many times the working precision is doubled in the attempt to separate the roots of f."""
SEEN = ("theta", "phi", "psi", "thetadot")
STATE = (*SEEN, "lz", "w3")
CARTESIAN = ("n.x", "n.y", "n.z", "L.x", "L.y", "L.z", "psi+phi")
"""The state of `by_axis`. The last is psi + side phi: on the upper vertical (side = 1) only the sum
of the two angles is defined, on the lower one (side = -1) only their difference.
"""

WITNESS = (
    "multiprecision integration of q' = q omega/2 and Euler's equations with the torque of the"
    " weight; Jacobi's functions for the tilt"
)


class Nutation:
    """The nutation of a top: its largest and least tilt and its period, from the roots of f.

    `p` has the exact parameters mass, length, gravity, theta0, phidot0, thetadot0, spin, j1, j3.
    `closest` [rad] is the tilt from either vertical that the axis must be proved not to go below.
    """

    def __init__(self, p: Mapping[str, Fraction], closest: Fraction = LEAST_TILT) -> None:
        self.p = p
        self.closest = closest

    def vertical(self) -> arb:
        """The conserved vertical angular momentum L_z [kg m^2/s]."""
        # L_z = J1 phi' sin^2 theta + J3 w3 cos theta
        p = self.p
        sine, cosine = arb_of(p["theta0"]).sin_cos()
        of_precession = arb_of(p["j1"] * p["phidot0"]) * sine * sine
        of_spin = arb_of(p["j3"] * p["spin"]) * cosine
        return of_precession + of_spin

    @cached_property
    def touches(self) -> bool:
        """True if it is not proved that the axis stays `closest` away from both verticals."""
        # theta stays in (closest, pi - closest) if u2 < cos(closest) and u1 > -cos(closest).
        with self.parted_roots() as (u1, u2, _):
            limit = arb_of(self.closest).cos()
            is_proved_off = u2 < limit and u1 > -limit
            return not is_proved_off

    def refuse_touching(self, flow: ValidatedFlow) -> None:
        """Raises NotCertifiedError where it is not proved that the axis stays off the verticals."""
        if not self.touches:
            return
        start = flow.at_start(Fraction(1))
        closest = f"{float(self.closest):g} rad"
        message = (
            f"vertical: the axis may come within {closest} of a vertical, where its angles say"
            " nothing; move the start"
        )
        raise NotCertifiedError(
            message,
            code="vertical",
            time=0.0,
            state={name: start[name] for name in SEEN if name in start},
        )

    def poles(self) -> list[int]:
        """The verticals that the axis may approach beyond UPRIGHT: 1 up, -1 down, both, or none."""
        near_poles = []
        with self.parted_roots() as (u1, u2, _):
            if not u2 < UPRIGHT:
                near_poles.append(1)
            if not u1 > -UPRIGHT:
                near_poles.append(-1)
        return near_poles

    @contextmanager
    def parted_roots(self) -> Iterator[list[arb]]:
        """The roots u1 <= u2 <= u3 at the first precision at which they are separated.

        That precision is the working precision inside the `with` statement. Raises
        NotCertifiedError if no precision up to DOUBLINGS doublings suffices.
        """
        for bits in (FIRST_BITS << doubling for doubling in range(DOUBLINGS)):
            with precision(bits):
                try:
                    roots = self.roots()
                except ValueError:
                    continue
                yield roots
                return
        raise NotCertifiedError(
            "separatrix: the ends of the nutation are not told apart; move the start",
            code="separatrix",
            time=0.0,
        )

    def roots(self) -> list[arb]:
        """The roots u1 <= u2 <= u3 of f at the current precision.

        Raises ValueError (UndecidedError is one) where this precision does not separate them.
        """
        p = self.p
        sine, u0 = arb_of(p["theta0"]).sin_cos()
        # beta = 2 m g l/J1,  a = J3 w3/J1,  b = L_z/J1,
        # alpha = theta'^2 + phi'^2 sin^2 theta + beta cos theta at the start
        beta = arb_of(2 * p["mass"] * p["gravity"] * p["length"] / p["j1"])
        a = arb_of(p["j3"] * p["spin"] / p["j1"])
        b = self.vertical() / arb_of(p["j1"])
        thetadot_square = arb_of(p["thetadot0"] ** 2)
        phidot_square = arb_of(p["phidot0"] ** 2)
        alpha = thetadot_square + phidot_square * sine * sine + beta * u0
        # f(u) = beta u^3 - (alpha + a^2) u^2 + (2 a b - beta) u + alpha - b^2.
        cubic = [alpha - b * b, 2 * a * b - beta, -(alpha + a * a), beta]
        if p["thetadot0"] == 0:
            return _other_roots(cubic, u0)
        # The tolerance is absolute and u3 may be large: a third of the bits is left for its size.
        # On a ValueError of the root finder the caller doubles the precision.
        tolerance = arb(2) ** (-2 * ctx.prec // 3)
        complex_roots: Any = acb_poly([acb(c) for c in cubic]).roots(tol=tolerance)
        real_roots = [root.real for root in complex_roots if root.imag.contains(0)]
        if len(real_roots) != 3:
            raise UndecidedError("ends of the nutation that are not apart")
        return sorted(real_roots, key=lambda root: float(root.mid()))

    def ends(self, flow: ValidatedFlow) -> dict[str, arb]:
        """The scalars: the least and the largest tilt [rad], and the time there and back [s]."""
        u1, u2, u3 = self.roots()
        # The period is 4 K(m)/sqrt(beta (u3 - u1)), m = (u2 - u1)/(u3 - u1).
        beta = arb_of(2 * self.p["mass"] * self.p["gravity"] * self.p["length"] / self.p["j1"])
        m = (u2 - u1) / (u3 - u1)
        period = 4 * acb(m).elliptic_k().real / (beta * (u3 - u1)).sqrt()
        return {"nutation_min": u2.acos(), "nutation_max": u1.acos(), "period": period}


def _other_roots(cubic: Sequence[arb], u0: arb) -> list[arb]:
    """The roots of the cubic in rising order, of which u0 is known to be u1 or u2.

    A top with theta' = 0 starts at an end of its nutation: f(u0) = 0. Division by (u - u0) leaves
    beta u^2 + linear u + constant, whose larger root is u3. The smaller one comes from the
    product of both, constant/beta, so that no digits cancel where it is small.
    """
    # Synthetic division of c3 u^3 + c2 u^2 + c1 u + c0 by (u - u0):
    #     linear = c2 + c3 u0,  constant = c1 + linear u0.
    # u3 = (sqrt(linear^2 - 4 beta constant) - linear)/(2 beta), the other root constant/(beta u3).
    beta = cubic[3]
    linear = cubic[2] + beta * u0
    constant = cubic[1] + linear * u0
    discriminant_root = (linear * linear - 4 * beta * constant).sqrt()
    smaller = 2 * constant / (discriminant_root - linear)
    u3 = (discriminant_root - linear) / (2 * beta)
    return [u0.min(smaller), u0.max(smaller), u3]


def by_angles(
    p: Mapping[str, Fraction], scale: Mapping[str, Size], nutation: Nutation
) -> ValidatedFlow:
    """The truth by validated integration of theta, phi, psi (continuous) and thetadot.

    L_z and w3 are state variables with the rate 0, so that S includes errors of them. `scale` has
    the size of every quantity and of `lz` and `w3`.
    """
    start: list[Fraction | Callable[[], arb]] = [
        p["theta0"],
        Fraction(0),
        Fraction(0),
        p["thetadot0"],
        nutation.vertical,
        p["spin"],
    ]
    return ValidatedFlow(
        field(p),
        start,
        lambda y: dict(zip(STATE, y, strict=True)),
        scale,
        state=STATE,
        moved=range(6),
        witness=WITNESS,
        constants=nutation.ends,
        reported=SEEN,
        door=nutation.refuse_touching,
    )


def by_axis(p: Mapping[str, Fraction], scale: Mapping[str, Size], side: int) -> ValidatedFlow:
    """The truth by validated integration of the axis n, L and psi + side phi.

    It is used where the axis approaches one vertical (`side` 1 for up, -1 for down), where phi' and
    psi' are large. The equations are those of `cartesian`; phi lies in (-pi, pi].
    """
    nutation = Nutation(p, LEAST_TOLD)
    sizes = {
        **scale,
        **dict.fromkeys(CARTESIAN[:3], 1.0),
        **dict.fromkeys(CARTESIAN[3:6], scale["lz"]),
        CARTESIAN[6]: 1.0,
    }
    start = [partial(axis_and_momentum, p, k) for k in range(6)]
    return ValidatedFlow(
        cartesian(p, side),
        [*start, Fraction(0)],
        AxisReading(p["j1"], side),
        sizes,
        state=CARTESIAN,
        moved=range(7),
        witness=WITNESS,
        constants=nutation.ends,
        reported=SEEN,
        door=nutation.refuse_touching,
    )


def axis_and_momentum(p: Mapping[str, Fraction], k: int) -> arb:
    """Coordinate k of (n, L) in space axes at the start, where phi = 0.

    There n = (0, -sin theta, cos theta) and L = J1 (theta' e_x + phi' sin theta e) + J3 w3 n, with
    e = (0, cos theta, sin theta) across the axis.
    """
    # across = J1 phi' sin theta, along = J3 w3:
    # L = (J1 theta', across cos theta - along sin theta, across sin theta + along cos theta)
    sine, cosine = arb_of(p["theta0"]).sin_cos()
    across = arb_of(p["j1"] * p["phidot0"]) * sine
    along = arb_of(p["j3"] * p["spin"])
    momentum = [
        arb_of(p["j1"] * p["thetadot0"]),
        across * cosine - along * sine,
        across * sine + along * cosine,
    ]
    return [arb(0), -sine, cosine, *momentum][k]


class AxisReading(Reading):
    """The angles and thetadot of a state (n, L, psi + side phi), and their derivatives.

    With n = (sin theta sin phi, -sin theta cos phi, cos theta) and s = sin theta = sqrt(n_x^2 +
    n_y^2):

        theta = atan2(s, n_z),  phi = atan2(n_x, -n_y),  psi = (psi + side phi) - side phi,
        theta' = (L_y n_x - L_x n_y)/(J1 s),    because n_z' = -s theta' and n' = L x n/J1.
    """

    def __init__(self, j1: Fraction, side: int) -> None:
        self.j1 = j1
        self.side = side

    def values(self, y: Sequence[arb]) -> dict[str, arb]:
        nx, ny, nz, lx, ly, _, psi_with_phi = y
        sine = (nx * nx + ny * ny).sqrt()
        phi = atan2(nx, -ny)
        thetadot = (ly * nx - lx * ny) / (arb_of(self.j1) * sine)
        angles = {
            "theta": atan2(sine, nz),
            "phi": phi,
            "psi": psi_with_phi - self.side * phi,
            "thetadot": thetadot,
        }
        return angles | dict(zip(CARTESIAN, y, strict=True))

    def slopes(self, y: Sequence[arb]) -> Mapping[str, Sequence[arb]]:
        """The derivatives of every quantity by the seven coordinates of the state.

        Those of the coordinates themselves are rows of the unit matrix. With s^2 = n_x^2 + n_y^2:

            d theta = (n_z n_x/s, n_z n_y/s, -s) . dn                     (s^2 + n_z^2 = 1)
            d phi = (-n_y, n_x)/s^2 . (dn_x, dn_y)
            d theta' = ((L_y, -L_x)/(J1 s) - theta' (n_x, n_y)/s^2) . (dn_x, dn_y)
                       + (-n_y, n_x)/(J1 s) . (dL_x, dL_y)
        """
        nx, ny, nz, lx, ly, _, _ = y
        sine_square = nx * nx + ny * ny
        sine = sine_square.sqrt()
        j1_sine = arb_of(self.j1) * sine
        zero = arb(0)
        thetadot = (ly * nx - lx * ny) / j1_sine
        d_theta = [nz * nx / sine, nz * ny / sine, -sine, zero, zero, zero, zero]
        d_phi = [-ny / sine_square, nx / sine_square, zero, zero, zero, zero, zero]
        d_psi = [*(-self.side * slope for slope in d_phi[:6]), arb(1)]
        d_thetadot = [
            ly / j1_sine - thetadot * nx / sine_square,
            -lx / j1_sine - thetadot * ny / sine_square,
            zero,
            -ny / j1_sine,
            nx / j1_sine,
            zero,
            zero,
        ]
        slopes = {}
        for i, name in enumerate(CARTESIAN):
            slopes[name] = [arb(int(i == j)) for j in range(len(CARTESIAN))]
        return slopes | {"theta": d_theta, "phi": d_phi, "psi": d_psi, "thetadot": d_thetadot}


def cartesian(p: Mapping[str, Fraction], side: int) -> Field:
    """The field of the state (n, L, psi + side phi), for numbers of any kind.

        n' = L x n/J1                          because omega = L/J1 + (1/J3 - 1/J1) (L . n) n
        L' = l n x (-m g e_z)                  the torque of the weight
        (psi + side phi)' = (L . n)/J3 + side (L_z - (L . n) n_z)/(J1 (1 + side n_z))

    The last line is psi' + side phi' with psi' = w3 - phi' n_z and phi' = (L_z - (L . n) n_z)/(J1
    (1 - n_z^2)): the factor that vanishes on the vertical of `side` cancels.
    """
    weight = p["mass"] * p["gravity"] * p["length"]
    j1 = p["j1"]
    j3 = p["j3"]

    def rates(s: Sequence[Any]) -> Sequence[Any]:
        # n' = L x n/J1,  L' = l n x (-m g e_z) = m g l (-n_y, n_x, 0)
        nx, ny, nz, lx, ly, lz, _ = s
        along_axis = lx * nx + ly * ny + lz * nz
        axis_rate = [
            (ly * nz - lz * ny) / j1,
            (lz * nx - lx * nz) / j1,
            (lx * ny - ly * nx) / j1,
        ]
        torque = [ny * -weight, nx * weight, nx * 0]
        # w3 + side (L_z - (L . n) n_z)/(J1 (1 + side n_z)),  w3 = (L . n)/J3
        of_spin = along_axis / j3
        of_precession = (lz - along_axis * nz) * side / ((nz * side + 1) * j1)
        return (*axis_rate, *torque, of_spin + of_precession)

    return rates


def field(p: Mapping[str, Fraction]) -> Field:
    """The field of the state (theta, phi, psi, thetadot, L_z, w3), for numbers of any kind.

    With a = J3 w3/J1 (Whittaker, section 71; L_z and w3 do not change):

        phi' = (L_z/J1 - a cos theta)/sin^2 theta,    psi' = w3 - phi' cos theta,
        theta'' = (phi'^2 cos theta - a phi' + m g l/J1) sin theta.
    """
    weight = p["mass"] * p["gravity"] * p["length"] / p["j1"]

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        theta, _, _, thetadot, lz, w3 = y
        sine = theta.sin()
        cosine = theta.cos()
        # phi' = (L_z/J1 - a cos theta)/sin^2 theta,  psi' = w3 - phi' cos theta,  a = J3 w3/J1
        a = w3 * (p["j3"] / p["j1"])
        phi_rate = (lz / p["j1"] - a * cosine) / (sine * sine)
        psi_rate = w3 - phi_rate * cosine
        # theta'' = ((phi' cos theta - a) phi' + m g l/J1) sin theta
        theta_acceleration = ((phi_rate * cosine - a) * phi_rate + weight) * sine
        return (thetadot, phi_rate, psi_rate, theta_acceleration, 0, 0)

    return rates


def truth(p: Parameters, scale: Mapping[str, float], rate: float) -> Truth:
    """The truth at all parameters of the case.

    `scale` has the size of each quantity against which its error counts; `rate` [rad/s] is the size
    of w3, and J1 rate that of L_z.
    """
    j1, j3 = vector(p, "inertia")
    exact = numbers(p, "mass", "length", "gravity", "theta0", "phidot0", "thetadot0", "spin") | {
        "j1": j1,
        "j3": j3,
    }
    sizes = {**scale, "lz": float(j1) * rate, "w3": rate}
    nutation = Nutation(exact)
    # psi + side phi is regular at one vertical only. A motion that approaches both verticals is
    # therefore integrated in angles, and refused if it comes within LEAST_TILT of one of them.
    poles = nutation.poles()
    if len(poles) == 1:
        return by_axis(exact, sizes, poles[0])
    return by_angles(exact, sizes, nutation)
