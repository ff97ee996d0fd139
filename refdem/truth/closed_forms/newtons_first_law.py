"""Motion without force: straight lines at constant speed, steady spin about a principal axis,
bodies that stay.

r = r0 + v t, omega constant, q(t) = (cos |omega| t/2, sin(|omega| t/2) omega/|omega|) q0 (Newton
1687, law I; qdot = 1/2 omega q).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.core.truth import Ball, Truth
from refdem.errors import UsageError
from refdem.truth.balls import Guarded, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.dual import Derivatives
from refdem.truth.growth import Grows, Told
from refdem.truth.refiner import Refiner

POSITION = ("x", "y", "z")
VELOCITY = ("vx", "vy", "vz")
SPIN = ("omega.x", "omega.y", "omega.z")
ATTITUDE = ("attitude.w", "attitude.x", "attitude.y", "attitude.z")
Numbers = Sequence[Fraction | int]


@dataclass(frozen=True)
class Uniform(ClosedForm):
    """One body that nothing acts on; quantities x, y, z, vx, vy, vz, omega.x/y/z (space axes),
    attitude.w/x/y/z.

    `start` has the numbers of `state` at t = 0.

    `attitude` is the unit quaternion at t = 0 (exactly of norm 1: rationals such as 1,0,0,0 or
    3/5,4/5,0,0); its sign is kept continuous in time. `omega` [rad/s] must lie along a principal
    axis of the body as it stands, one of largest or smallest inertia: there neighbouring spins stay
    near, and S(t), which holds omega constant, is its growth.
    """

    method = "straight line and steady turn"
    witness = "Taylor series of qdot = omega q/2 in rational arithmetic"
    state = (*POSITION, *VELOCITY, *SPIN)

    start: tuple[Fraction, ...]
    attitude: tuple[Fraction, ...]

    displaced = displaced_tuple("start")

    def __post_init__(self) -> None:
        """Raises UsageError for an attitude that is not exactly of norm 1."""
        if sum(part**2 for part in self.attitude) != 1:
            raise UsageError(
                f"attitude is {tuple(map(str, self.attitude))}; expected exact numbers whose"
                " squares add up to 1"
            )

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Every quantity of the uniform motion at time t."""
        start = [arb_of(x) for x in self.start]
        # r0 + v t.
        position = [x + v * t for x, v in zip(start[:3], start[3:6], strict=True)]
        velocity_and_omega = start[3:]
        values = position + velocity_and_omega + self._turned(t)
        return dict(zip((*self.state, *ATTITUDE), values, strict=True))

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: the formula of `grown`."""
        return Told(self.grown)

    def grown(self, t: arb) -> arb:
        """The growth S of an error after the time t: the earliest error has grown most.

        A position moves by t times the error of the velocity. An attitude stays off by its own
        error and changes by that of omega: with the unit vector n of omega, |dq/d omega_j|^2 =
        (t/2)^2 n_j^2 + (sin(|omega| t/2)/|omega|)^2 (1 - n_j^2). The sine is bounded by 1, and
        sin(|omega| t/2)/|omega| by t/2.
        """
        # t V/X for each axis, with the scales X of the position and V of the velocity.
        drifts = [
            t * arb_of(self.scale[v] / self.scale[x])
            for x, v in zip(POSITION, VELOCITY, strict=True)
        ]
        omega = self.start[6:]
        omega_square = sum((x * x for x in omega), Fraction(0))
        # A bound of |sin(|omega| t/2)|/|omega|: the smaller one of t/2 and 1/|omega|.
        across = t / 2
        if omega_square:
            across = across.min(1 / arb_of(omega_square).sqrt())
        attitude_change = arb(0)
        for component, name in zip(omega, SPIN, strict=True):
            # n_j^2
            if omega_square:
                share = component * component / omega_square
            else:
                share = Fraction(0)
            # |dq/d omega_j|, with |sin|/|omega| replaced by its bound.
            change = (t * t / 4 * arb_of(share) + across * across * arb_of(1 - share)).sqrt()
            attitude_change += change * arb_of(self.scale[name])
        turns = [attitude_change / arb_of(self.scale[name]) for name in ATTITUDE]
        largest_turn = max(turns, key=lambda size: float(size.upper()))
        return 1 + max([*drifts, largest_turn], key=lambda size: float(size.upper()))

    def _turned(self, t: arb) -> list[arb]:
        """The attitude q(t) = (cos(|omega| t/2), sin(|omega| t/2) omega/|omega|) q0."""
        omega_square = sum(x * x for x in self.start[6:])
        half_rate = arb_of(omega_square).sqrt() / 2
        if omega_square:
            # sin(|omega| t/2)/|omega|, which tends to t/2.
            sine_over_omega = (half_rate * t).sin() / (2 * half_rate)
        else:
            sine_over_omega = t / 2
        w = (half_rate * t).cos()
        x, y, z = (arb_of(component) * sine_over_omega for component in self.start[6:])
        # Hamilton's product with q0 = (a, b, c, d).
        a, b, c, d = (arb_of(component) for component in self.attitude)
        turned_w = w * a - x * b - y * c - z * d
        turned_x = w * b + x * a + y * d - z * c
        turned_y = w * c + y * a + z * b - x * d
        turned_z = w * d + z * a + x * c - y * b
        return [turned_w, turned_x, turned_y, turned_z]


@dataclass(frozen=True)
class Still(Guarded, Truth):
    """Bodies at rest: every quantity is exactly 0 at all times, and S = 1."""

    method = "equilibrium"
    witness = "balance of forces"

    quantities: tuple[str, ...]

    def at(self, t: Fraction) -> dict[str, Ball]:
        """The value zero, with radius zero, for every quantity."""
        return {name: Ball(Fraction(0), Fraction(0)) for name in self.quantities}

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """0 by every parameter: the bodies are at rest for neighbouring parameters too."""
        return {name: (Ball(Fraction(0), Fraction(0)),) * count for name in self.quantities}

    def sensitivity(self, t: Fraction) -> float:
        """1: an error of the start is constant."""
        return 1.0


def free(
    scale: Mapping[str, float],
    *,
    position: Numbers,
    velocity: Numbers,
    omega: Numbers,
    attitude: Numbers = (1, 0, 0, 0),
) -> Truth:
    """The member `free`: see Uniform; arguments are exact numbers (p["..."] of a vector parameter
    as it is).
    """
    names = (*Uniform.state, *ATTITUDE)
    refiner = Refiner.of({name: scale.get(name) or 1.0 for name in names})
    start = tuple(exactly(x) for x in (*position, *velocity, *omega))
    return Uniform(refiner, start, tuple(exactly(x) for x in attitude))


def exactly(number: Fraction | int) -> Fraction:
    """The number as a Fraction; one that is one stays, with the derivatives that it may carry."""
    if isinstance(number, Fraction):
        return number
    return Fraction(number)


def resting(bodies: int) -> Truth:
    """The members that rest: r1.x .. rN.z, the displacement from the start [m], and v1.x .. vN.z
    [m/s] of each body, all 0.
    """
    names = (f"{kind}{i}.{axis}" for i in range(1, bodies + 1) for kind in "rv" for axis in "xyz")
    return Still(tuple(names))
