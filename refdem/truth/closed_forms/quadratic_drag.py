"""Fall in a fluid with quadratic drag: m v' = -m g - c |v| v.

Notation: v_t = sqrt(m g/c) is the terminal velocity, s = g t/v_t the time, u = -v/v_t the downward
velocity and X = -y g/v_t^2 the downward displacement. Then X' = u and u' = 1 - |u| u.

Theorem. From u0 < 0 the body rises until s1 = arctan(-u0):

    u = tan(s - s1),  X = -ln(cos s - u0 sin s)           for 0 <= s <= s1,

and falls from rest after it. From u0 >= 0, with T = tanh s,

    u = (u0 + T)/(1 + u0 T),  X = ln(cosh s + u0 sinh s),

for velocities below, at and above the terminal velocity (Riccati's equation; the solutions are tanh
and coth of a shifted time).

S(t). An error of u made at s' has shrunk by s, for |u| u increases; its integral b(s', s) is what
it has moved X by. The largest row sum is that of X: S = 1 + m max b, m being the scale of v over
v_t. With u' = 1 -+ u^2 the error of u is as 1 -+ u^2 itself, so that
b = (u(s) - u(s'))/(1 -+ u(s')^2).

* 0 <= u0 <= 1: b falls with s', so that max b = b(0, s) = T/(1 + u0 T).
* u0 > 1, u = coth theta: b = (sinh 2 theta' - (cosh 2 theta' - 1) coth theta)/2 is largest at
  theta' = theta/2, where it is tanh(theta/2)/2, if that time is not before the start.
* u0 < 0: b = cos^2 phi' (u - tan phi') with u' = tan phi' is largest where tan phi' = -1/(u + R),
  R = sqrt(1 + u^2), where it is (u + R)/2, if that time is not before the start; u is the velocity
  at s, before the turning point or after it. Errors made later, on the way down, have b <= u.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Told
from refdem.truth.refiner import Refiner


@dataclass(frozen=True, kw_only=True)
class QuadraticDrag(ClosedForm):
    """Height y [m] and velocity v [m/s], both upwards, at t >= 0.

    Scalars: terminal_velocity [m/s]; thrown up, top [m] and top_time [s] of the turning point.
    """

    method = "closed form: tan on the way up, Riccati's solution on the way down"
    witness = "Taylor integration of the equation of motion, way up and way down apart"
    state = ("y", "v")

    mass: Fraction
    gravity: Fraction
    drag: Fraction
    y0: Fraction = Fraction(0)
    v0: Fraction

    displaced = displaced_fields("y0", "v0")

    @property
    def terminal_squared(self) -> Fraction:
        """The square v_t^2 = m g/c of the terminal velocity [m^2/s^2]."""
        return self.mass * self.gravity / self.drag

    @per_precision
    def terminal(self) -> arb:
        """The terminal velocity v_t = sqrt(m g/c) [m/s]."""
        return arb_of(self.terminal_squared).sqrt()

    @per_precision
    def start(self) -> arb:
        """u0, the velocity downwards at the start in units of v_t."""
        return -arb_of(self.v0) / self.terminal()

    @per_precision
    def rise(self) -> arb:
        """s1 = arctan(-u0), the time of the turning point in units of v_t/g."""
        return (-self.start()).atan()

    def scaled_time(self, t: arb) -> arb:
        """The time in units of v_t/g: s = g t/v_t."""
        return arb_of(self.gravity) * t / self.terminal()

    def evaluate(self, t: arb) -> dict[str, arb]:
        if t < 0:
            raise NotCertifiedError("t < 0: the motion is asked for from its start on")
        s = self.scaled_time(t)
        way, velocity = self.downwards(s)
        # y = y0 - X v_t^2/g,  v = -u v_t.
        length = arb_of(self.terminal_squared / self.gravity)
        return {"y": arb_of(self.y0) - way * length, "v": -velocity * self.terminal()}

    def downwards(self, s: arb) -> tuple[arb, arb]:
        """X and u at the scaled time s >= 0."""
        if self.v0 <= 0:
            return fallen(self.start(), s)
        if s <= self.rise():
            return risen(self.start(), s)
        # After the turning point; where the ball s contains it, the union of both formulas.
        to_top, _ = risen(self.start(), self.rise())
        since = s - self.rise()
        way, velocity = fallen(arb(0), since)
        if since > 0:
            return to_top + way, velocity
        on_way_up = risen(self.start(), s)
        return on_way_up[0].union(to_top + way), on_way_up[1].union(velocity)

    @per_precision
    def growth(self) -> Grows:
        return Told(self.grown)

    def grown(self, t: arb) -> arb:
        """S = 1 + m max b (see the module), m being the scale of v over v_t."""
        s = self.scaled_time(t)
        ratio = arb_of(self.scale["v"]) / self.terminal()
        return 1 + ratio * self.largest_shift(s)

    def largest_shift(self, s: arb) -> arb:
        """max b over the times up to s at which an error of u may be made."""
        u0 = self.start()
        _, u = self.downwards(s)
        if self.v0 > 0:
            # tan phi' = -1/(u + R), and tan phi' = u0 at the start.
            root = (1 + u * u).sqrt()
            if -1 / (u + root) < u0:
                # The start is after the time of the largest shift: b(0, s) = (u - u0)/(1 + u0^2).
                return (u - u0) / (1 + u0 * u0)
            return (u + root) / 2
        tangent = s.tanh()
        # b(0, s) = T/(1 + u0 T).
        from_start = tangent / (1 + u0 * tangent)
        if self.v0**2 <= self.terminal_squared:
            return from_start
        # u = coth(theta) with theta = arcoth(u0) at the start.
        theta_start = ((u0 + 1) / (u0 - 1)).log() / 2
        theta = theta_start + s
        # b is largest at theta' = theta/2, which is before the start if theta < 2 theta_start.
        if theta < 2 * theta_start:
            return from_start
        return (theta / 2).tanh() / 2

    def constants(self) -> dict[str, arb]:
        """The terminal velocity, and the turning point of a body that is thrown up."""
        scalars = {"terminal_velocity": self.terminal()}
        if self.v0 > 0:
            to_top, _ = risen(self.start(), self.rise())
            scalars["top"] = -to_top * arb_of(self.terminal_squared / self.gravity)
            scalars["top_time"] = self.rise() * self.terminal() / arb_of(self.gravity)
        return scalars


def fallen(u0: arb, s: arb) -> tuple[arb, arb]:
    """X = ln(cosh s + u0 sinh s) and u = (u0 + T)/(1 + u0 T), T = tanh s, from u0 >= 0 on."""
    tangent = s.tanh()
    # ln(cosh s + u0 sinh s) = s + ln((1 + u0)/2 + (1 - u0)/2 exp(-2 s)): nothing overflows for a
    # large s.
    way = s + ((1 + u0) / 2 + (1 - u0) / 2 * (-2 * s).exp()).log()
    return way, (u0 + tangent) / (1 + u0 * tangent)


def risen(u0: arb, s: arb) -> tuple[arb, arb]:
    """X = -ln(cos s - u0 sin s) and u = tan(s + arctan u0), up to the turning point."""
    sine, cosine = s.sin_cos()
    # tan(s + arctan u0) = (sin s + u0 cos s)/(cos s - u0 sin s).
    below = cosine - u0 * sine
    return -below.log(), (sine + u0 * cosine) / below


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, gravity, drag, v0; `scale` of y and v."""
    exact = numbers(p, "mass", "gravity", "drag", "v0")
    return QuadraticDrag(refiner=Refiner.of(scale), **exact)
