"""A mass on a spring with dry friction: m x'' + f Sgn(x') + k x = 0.

While it slides, x(t) = c + (X - c) cos(w (t - T)) from the turning point X at T, about c = -f/k
where v > 0 and f/k where v < 0; the next turning point is 2c - X, half a period pi/w later. The
mass stops at the first turning point with k|X| <= f (the set-valued Sgn(0) = [-1, 1] includes
equality). From a start at rest all turning points are rational. In the code `shift` is f/k and
`heading` the sign of v.

S(t) needs no differences. For two motions, d/dt (k dx^2 + m dv^2)/2 = -dv (f Sgn(v1) - f Sgn(v2))
<= 0, since Sgn is monotone: the flow is nonexpansive in the energy norm, also through turning
points and stops. With scales L and V the scaled Jacobian is D^-1 N D, |N| <= 1, D = diag(w L, V),
so that its largest row sum is at most sqrt(1 + max(w L/V, V/(w L))^2).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import ceil

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.dual import atan2
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Told
from refdem.truth.refiner import Refiner


@dataclass(frozen=True, kw_only=True)
class CoulombOscillator(ClosedForm):
    """x [m] and v [m/s] at t >= 0; scalars stop_time, stop_position and half_cycles (turning points
    after the start).
    """

    method = "half cycles about -+f/k; turning points in rationals from rest, else in balls"
    witness = (
        "Taylor series of each half cycle in rational arithmetic; energy lost = friction x path"
    )
    state = ("x", "v")

    mass: Fraction
    stiffness: Fraction
    friction_force: Fraction
    x0: Fraction
    v0: Fraction

    displaced = displaced_fields("x0", "v0")

    @property
    def shift(self) -> Fraction:
        """The stretch f/k that friction holds [m]."""
        return self.friction_force / self.stiffness

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: the constant bound of `grown`."""
        return Told(self.grown)

    def grown(self, t: arb) -> arb:
        """sqrt(1 + max(w L/V, V/(w L))^2) at all times: the flow is nonexpansive in the energy norm
        (see the module).
        """
        ratio = self.rate() * arb_of(self.scale["x"] / self.scale["v"])
        larger = ratio.max(1 / ratio)
        return (1 + larger * larger).sqrt()

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Position and velocity at t; the velocity is exactly 0 once it has stopped."""
        if t < 0:
            raise NotCertifiedError(
                "t < 0: a body that friction brought to rest may have come from anywhere"
            )
        if self.shift and t >= self.turning_time(self.halves()):
            return {"x": _ball(self.turning_point(self.halves())), "v": arb(0)}
        # Before the first turning point v has the sign of v0, after turning point X that of -X.
        if t < self.turning_time(0):
            number = 0
            heading = _sign(self.v0)
        else:
            number = self._halves_until(t)
            heading = -_sign(self.turning_point(number))
        # c = -heading f/k,  x = c + (X - c) cos(w (t - T)),  v = -(X - c) w sin(w (t - T))
        w = self.rate()
        turning_point = _ball(self.turning_point(number))
        centre = -heading * arb_of(self.shift)
        sine, cosine = (w * (t - self.turning_time(number))).sin_cos()
        x = centre + (turning_point - centre) * cosine
        v = -(turning_point - centre) * w * sine
        return {"x": x, "v": v}

    def constants(self) -> dict[str, arb]:
        """When and where it stops, and after how many half cycles; nothing without friction."""
        if not self.shift:
            return {}
        halves = self.halves()
        stop = {
            "stop_time": self.turning_time(halves),
            "stop_position": _ball(self.turning_point(halves)),
        }
        # The first turning point counts if it comes after the start, that is, for v0 != 0.
        return {**stop, "half_cycles": arb(halves + (self.v0 != 0))}

    def rate(self) -> arb:
        """The angular frequency w = sqrt(k/m) [rad/s]."""
        return arb_of(self.stiffness / self.mass).sqrt()

    @per_precision
    def opening(self) -> tuple[arb, Fraction | arb]:
        """The time [s] and the place [m] of the first turning point: the start, if at rest there.

        About c = -heading f/k the motion has the amplitude sqrt(a^2 + (v0/w)^2), a = x0 - c, and
        turns after the phase atan2(|v0|/w, heading a).
        """
        # X0 = c + heading sqrt(a^2 + (v0/w)^2),  w T0 = atan2(|v0|/w, heading a)
        if self.v0 == 0:
            return arb(0), self.x0
        if self.v0 > 0:
            heading = 1
        else:
            heading = -1
        a = arb_of(self.x0 + heading * self.shift)
        v_over_w = arb_of(self.v0) / self.rate()
        amplitude = (a * a + v_over_w * v_over_w).sqrt()
        turning_point = heading * (amplitude - arb_of(self.shift))
        return atan2(abs(v_over_w), heading * a) / self.rate(), turning_point

    def turning_time(self, number: int) -> arb:
        """The time [s] of turning point `number`, counted from 0."""
        first: arb = self.opening()[0]
        # T_n = T_0 + n pi/w.
        return first + number * arb.pi() / self.rate()

    def turning_point(self, number: int) -> Fraction | arb:
        """Turning point `number` n [m], from 0 on: (-1)^n (X0 - 2 n f/k sgn X0)."""
        first: Fraction | arb = self.opening()[1]
        if number:
            # X_n = (-1)^n (X0 - 2 n (f/k) sgn X0).
            loss = 2 * number * self.shift * _sign(first)
        else:
            loss = Fraction(0)
        if number % 2:
            side = -1
        else:
            side = 1
        if isinstance(first, Fraction):
            return side * (first - loss)
        return side * (first - arb_of(loss))

    @per_precision
    def halves(self) -> int:
        """The number of half cycles after the first turning point X0, until it stops.

        The least n >= 0 with |X0| - 2 n f/k <= f/k.
        """
        first: Fraction | arb = self.opening()[1]
        if isinstance(first, Fraction):
            # n >= (|X0| k/f - 1)/2.
            return max(0, ceil((abs(first) / self.shift - 1) / 2))
        least = ((abs(first) / arb_of(self.shift) - 1) / 2).ceil().unique_fmpz()
        if least is None:
            raise UndecidedError("whether it stops at a turning point")
        return max(0, int(least))

    def _halves_until(self, t: arb) -> int:
        """The number of completed half cycles at t; raises UndecidedError if it is not decided."""
        # floor(w (t - T0)/pi).
        number = ((t - self.turning_time(0)) * self.rate() / arb.pi()).floor().unique_fmpz()
        if number is None:
            raise UndecidedError("which half cycle it is in")
        return int(number)


def _ball(value: Fraction | arb) -> arb:
    """The number as an Arb ball."""
    if isinstance(value, arb):
        return value
    return arb_of(value)


def _sign(value: Fraction | arb) -> int:
    """The sign -1, 0 or 1; raises UndecidedError where the ball contains both signs."""
    if not (value > 0 or value < 0 or value == 0):
        raise UndecidedError("on which side it turns")
    if value > 0:
        return 1
    if value < 0:
        return -1
    return 0


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, friction_force, x0, v0; `scale` of x and v."""
    exact = numbers(p, "mass", "stiffness", "friction_force", "x0", "v0")
    return CoulombOscillator(refiner=Refiner.of(scale), **exact)
