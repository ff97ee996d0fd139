"""Certified heavy top: validated integration of Euler's angles with L_z and w3 kept; nutation and
its period by an elliptic integral.

With u = cos theta, b = L_z/J1, a = J3 w3/J1, beta = 2 m g l/J1, alpha = theta'^2 + phi'^2 sin^2
theta + beta u at the start: u'^2 = f(u) = (alpha - beta u)(1 - u^2) - (b - a u)^2 with roots u1 <=
u2 <= 1 <= u3, between the first two of which it moves in the time 4 K(m)/sqrt(beta (u3 - u1)), m =
(u2 - u1)/(u3 - u1), there and back (Whittaker, Analytical Dynamics, section 71).
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
from refdem.truth.exact import numbers, vector
from refdem.truth.refiner import FIRST_BITS, Size
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import Reading, ValidatedFlow

UPRIGHT = 0.995
"""cos of the least tilt at which Euler's angles are integrated."""
LEAST_TILT = Fraction(1, 100)
"""[rad]: nearer to a vertical a motion that comes near both of them is not followed."""
LEAST_TOLD = Fraction(1, 10**12)
"""[rad]: the same where axis and L are integrated; on the vertical itself there are no angles."""
DOUBLINGS = 6
"""Of the working precision, until the ends of the nutation are told apart."""
SEEN = ("theta", "phi", "psi", "thetadot")
STATE = (*SEEN, "lz", "w3")
CARTESIAN = ("n.x", "n.y", "n.z", "L.x", "L.y", "L.z", "psi+phi")


WITNESS = (
    "multiprecision integration of q' = q omega/2 and Euler's equations with the torque of the"
    " weight; Jacobi's functions for the tilt"
)


class Nutation:
    """Between which tilts the axis moves, and in what time; proved to stay off the verticals by
    `closest` [rad], or not.
    """

    def __init__(self, p: Mapping[str, Fraction], closest: Fraction = LEAST_TILT) -> None:
        self.p = p
        self.closest = closest

    def vertical(self) -> arb:
        """The vertical angular momentum L_z, which is conserved."""
        p = self.p
        sine, cosine = arb_of(p["theta0"]).sin_cos()
        return arb_of(p["j1"] * p["phidot0"]) * sine * sine + arb_of(p["j3"] * p["spin"]) * cosine

    @cached_property
    def touches(self) -> bool:
        """Whether it is not proved that the axis stays off the verticals."""
        limit = self.closest
        with self.parted_roots() as (low, high, _):
            return not (high < arb_of(limit).cos() and low > -arb_of(limit).cos())

    def refuse_touching(self, flow: ValidatedFlow) -> None:
        """Raises NotCertifiedError where it is not proved that the axis stays off the verticals."""
        if not self.touches:
            return
        start = flow.at_start(Fraction(1))
        near = f"{float(self.closest):g} rad"
        told = (
            f"vertical: the axis may come within {near} of a vertical, where its angles say"
            " nothing; move the start"
        )
        raise NotCertifiedError(
            told,
            code="vertical",
            time=0.0,
            state={name: start[name] for name in SEEN if name in start},
        )

    def poles(self) -> list[int]:
        """Which of the verticals the axis comes near to: 1 up, -1 down."""
        found = []
        with self.parted_roots() as (low, high, _):
            if not high < UPRIGHT:
                found.append(1)
            if not low > -UPRIGHT:
                found.append(-1)
        return found

    @contextmanager
    def parted_roots(self) -> Iterator[list[arb]]:
        """The roots at the first precision at which they are told apart, which is then the working
        precision; NotCertifiedError if none.
        """
        for bits in (FIRST_BITS << doubling for doubling in range(DOUBLINGS)):
            with precision(bits):
                try:
                    found = self.roots()
                except ValueError:
                    continue
                yield found
                return
        raise NotCertifiedError(
            "separatrix: the ends of the nutation are not told apart; move the start",
            code="separatrix",
            time=0.0,
        )

    def roots(self) -> list[arb]:
        """u1 <= u2 <= u3; where the tilt starts at one of its ends, that one is known."""
        p = self.p
        sine, u = arb_of(p["theta0"]).sin_cos()
        beta = arb_of(2 * p["mass"] * p["gravity"] * p["length"] / p["j1"])
        a = arb_of(p["j3"] * p["spin"] / p["j1"])
        b = self.vertical() / arb_of(p["j1"])
        alpha = arb_of(p["thetadot0"] ** 2) + arb_of(p["phidot0"] ** 2) * sine * sine + beta * u
        cubic = [alpha - b * b, 2 * a * b - beta, -(alpha + a * a), beta]
        if p["thetadot0"] == 0:
            linear = cubic[2] + beta * u
            rest = cubic[1] + linear * u
            spread = (linear * linear - 4 * beta * rest).sqrt()
            other = 2 * rest / (spread - linear)
            beyond = (spread - linear) / (2 * beta)
            return [u.min(other), u.max(other), beyond]
        # A tolerance is absolute and u3 may be large: a third of the bits is for its size.
        # ValueError: more precision is tried.
        tolerance = arb(2) ** (-2 * ctx.prec // 3)
        roots: Any = acb_poly([acb(c) for c in cubic]).roots(tol=tolerance)
        found = [root.real for root in roots if root.imag.contains(0)]
        if len(found) != 3:
            raise UndecidedError("ends of the nutation that are not apart")
        return sorted(found, key=lambda root: float(root.mid()))

    def ends(self, flow: ValidatedFlow) -> dict[str, arb]:
        """The scalars: the least and the largest tilt [rad], and the time there and back [s]."""
        low, high, beyond = self.roots()
        # 4 K(m)/sqrt(beta (u3 - u1)), m = (u2 - u1)/(u3 - u1).
        beta = arb_of(2 * self.p["mass"] * self.p["gravity"] * self.p["length"] / self.p["j1"])
        m = (high - low) / (beyond - low)
        period = 4 * acb(m).elliptic_k().real / (beta * (beyond - low)).sqrt()
        return {"nutation_min": high.acos(), "nutation_max": low.acos(), "period": period}


def by_angles(
    p: Mapping[str, Fraction], scale: Mapping[str, Size], nutation: Nutation
) -> ValidatedFlow:
    """theta, phi, psi (continuous) and thetadot, from Euler's angles.

    L_z and w3 are states that stay, so that S knows of their errors.
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
        told=SEEN,
        door=nutation.refuse_touching,
    )


def by_axis(p: Mapping[str, Fraction], scale: Mapping[str, Size], side: int) -> ValidatedFlow:
    """The same where Euler's angles run away: axis n, L and psi + side phi are integrated; phi lies
    in (-pi, pi].

    n' = L x n/J1, L' = m g l n x (-z), (psi + side phi)' = L.n/J3 + side (L_z - L.n n_z)/(J1 (1 +
    side n_z)).
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
        told=SEEN,
        door=nutation.refuse_touching,
    )


def axis_and_momentum(p: Mapping[str, Fraction], k: int) -> arb:
    """Coordinate k of n and L at the start."""
    sine, cosine = arb_of(p["theta0"]).sin_cos()
    across = arb_of(p["j1"] * p["phidot0"]) * sine
    own = arb_of(p["j3"] * p["spin"])
    along = [
        arb_of(p["j1"] * p["thetadot0"]),
        across * cosine - own * sine,
        across * sine + own * cosine,
    ]
    return [arb(0), -sine, cosine, *along][k]


class AxisReading(Reading):
    """The angles of the axis n = (sin theta sin phi, -sin theta cos phi, cos theta), and thetadot,
    from n, L and psi + side phi.
    """

    def __init__(self, j1: Fraction, side: int) -> None:
        self.j1 = j1
        self.side = side

    def values(self, y: Sequence[arb]) -> dict[str, arb]:
        x, y_, z, lx, ly, _, turned = y
        sine = (x * x + y_ * y_).sqrt()
        phi = arb.atan2(x, -y_)
        rate = (ly * x - lx * y_) / (arb_of(self.j1) * sine)
        angles = {
            "theta": arb.atan2(sine, z),
            "phi": phi,
            "psi": turned - self.side * phi,
            "thetadot": rate,
        }
        return angles | dict(zip(CARTESIAN, y, strict=True))

    def slopes(self, y: Sequence[arb]) -> Mapping[str, Sequence[arb]]:
        """Derivatives of the readings: 1 for n, L, psi + side phi; the chain rule for angles."""
        x, y_, z, lx, ly, _, _ = y
        square = x * x + y_ * y_
        sine = square.sqrt()
        lever = arb_of(self.j1) * sine
        none = arb(0)
        # theta' = (L_y x - L_x y)/(J1 sin theta)
        rate = (ly * x - lx * y_) / lever
        tilt = [z * x / sine, z * y_ / sine, -sine, none, none, none, none]
        phi = [-y_ / square, x / square, none, none, none, none, none]
        psi = [*(-self.side * value for value in phi[:6]), arb(1)]
        speed = [
            ly / lever - rate * x / square,
            -lx / lever - rate * y_ / square,
            none,
            -y_ / lever,
            x / lever,
            none,
            none,
        ]
        own = {
            name: [arb(int(i == j)) for j in range(len(CARTESIAN))]
            for i, name in enumerate(CARTESIAN)
        }
        return own | {"theta": tilt, "phi": phi, "psi": psi, "thetadot": speed}


def cartesian(p: Mapping[str, Fraction], side: int) -> Field:
    """The rates of n, L and psi + side phi."""
    weight = p["mass"] * p["gravity"] * p["length"]
    j1 = p["j1"]
    j3 = p["j3"]

    def rates(s: Sequence[Any]) -> Sequence[Any]:
        x, y, z, lx, ly, lz, _ = s
        own = lx * x + ly * y + lz * z
        moved = [(ly * z - lz * y) / j1, (lz * x - lx * z) / j1, (lx * y - ly * x) / j1]
        return (
            *moved,
            y * -weight,
            x * weight,
            x * 0,
            own / j3 + (lz - own * z) * side / ((z * side + 1) * j1),
        )

    return rates


def field(p: Mapping[str, Fraction]) -> Field:
    """The rates of theta, phi, psi, thetadot, L_z and w3."""
    weight = p["mass"] * p["gravity"] * p["length"] / p["j1"]

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        theta, _, _, rate, vertical, spin = y
        sine = theta.sin()
        cosine = theta.cos()
        own = spin * (p["j3"] / p["j1"])
        precession = (vertical / p["j1"] - own * cosine) / (sine * sine)
        return (
            rate,
            precession,
            spin - precession * cosine,
            ((precession * cosine - own) * precession + weight) * sine,
            0,
            0,
        )

    return rates


def truth(p: Parameters, scale: Mapping[str, float], rate: float) -> Truth:
    """The truth at these parameters (those of the case, all).

    `rate` [rad/s] is the scale of w3, and with J1 of L_z.
    """
    j1, j3 = vector(p, "inertia")
    exact = numbers(p, "mass", "length", "gravity", "theta0", "phidot0", "thetadot0", "spin") | {
        "j1": j1,
        "j3": j3,
    }
    sizes = {**scale, "lz": float(j1) * rate, "w3": rate}
    nutation = Nutation(exact)
    poles = nutation.poles()
    if len(poles) == 1:
        return by_axis(exact, sizes, poles[0])
    return by_angles(exact, sizes, nutation)
