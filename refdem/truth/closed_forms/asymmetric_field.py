"""A particle in a force that increases linearly from x1 to 0 and decreases to x2 (1.139): phases in
closed form; exact energies decide which phase follows.

x1 < 0 < x2. Rising flank, x1 < x < 0: with xi = x - x1, xi'' = l^2 xi and l^2 = k1/m (`steep`).
Falling flank, 0 < x < x2: with eta = x - x2, eta'' = -w^2 eta and w^2 = |k2|/m (`fall`), |k2| = k1
|x1|/x2. Outside free flight.

The energies v^2 - l^2 xi^2 and v^2 + w^2 eta^2 are constant on a flank, and rational. So it is
decided exactly whether the particle turns, and on which flank. A phase begins at a rational
position with a rational square of the velocity (`Start`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.dual import atan2
from refdem.truth.exact import numbers, sign_of
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.line_growth import linear
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start


@dataclass(frozen=True)
class Start:
    """The begin of a phase: a rational place, the square of the velocity and its sign (`sense`)."""

    x: Fraction
    square: Fraction
    sense: int


@dataclass(frozen=True)
class Phase:
    """The motion in a region (left, rising, falling, right), from its start [s] to its end (None:
    never).
    """

    region: str
    start: Start
    begin: arb
    end: arb | None


@dataclass(frozen=True, kw_only=True)
class AsymmetricField(ClosedForm):
    """x [m] and v [m/s] at t >= 0; scalar: work, that of the force on a particle that crosses from
    left to right [J].
    """

    state = ("x", "v")
    method = "closed form phase by phase, branches by exact energies"
    witness = "Taylor integration phase by phase, energy"

    mass: Fraction
    k1: Fraction
    x1: Fraction
    x2: Fraction
    x0: Fraction
    v0: Fraction

    displaced = displaced_fields("x0", "v0")
    jacobian = derivative_by_start

    @property
    def steep(self) -> Fraction:
        """The square l^2 = k1/m of the rate on the rising flank [1/s^2]."""
        return self.k1 / self.mass

    @property
    def fall(self) -> Fraction:
        """The square w^2 = |k2|/m of the rate on the falling flank [1/s^2]."""
        return self.steep * -self.x1 / self.x2

    @per_precision
    def phases(self) -> list[Phase]:
        """All phases, the last without an end."""
        x = self.x0
        v = self.v0
        start = Start(x, v * v, sign_of(v))
        phases = []
        begin = arb(0)
        region = self.region(x, start.sense)
        while True:
            following = self.end(region, start)
            if following is None:
                phases.append(Phase(region, start, begin, None))
                return phases
            duration, next_region, next_start = following
            phases.append(Phase(region, start, begin, begin + duration))
            begin = begin + duration
            region = next_region
            start = next_start

    def region(self, x: Fraction, sense: int) -> str:
        """The region in which a start lies; at an edge, the one into which it moves."""
        x1 = self.x1
        x2 = self.x2
        if x < x1 or (x == x1 and sense <= 0):
            return "left"
        if x < 0 or (x == 0 and sense < 0):
            return "rising"
        if x < x2 or (x == x2 and sense < 0):
            return "falling"
        return "right"

    def end(self, region: str, start: Start) -> tuple[arb, str, Start] | None:
        """The duration [s] of a phase, and the region and start of the next; None without end."""
        x1 = self.x1
        x2 = self.x2
        speed = arb_of(start.square).sqrt()
        if region == "left":
            if start.sense > 0:
                # Free flight to the edge at a constant speed.
                return (arb_of(x1 - start.x) / speed, "rising", Start(x1, start.square, 1))
            return None
        if region == "right":
            if start.sense < 0:
                return (arb_of(start.x - x2) / speed, "falling", Start(x2, start.square, -1))
            return None
        if region == "rising":
            return self.climbed(start)
        return self.descended(start)

    def climbed(self, start: Start) -> tuple[arb, str, Start] | None:
        """The end of a phase on the rising flank, xi = A exp(l t) + B exp(-l t).

        A, B = (xi0 +- v0/l)/2, and 4 A B = xi0^2 - v0^2/l^2. With v0 < 0 it leaves to the left at
        xi = 0 if v^2 = v0^2 - l^2 xi0^2 > 0 there; if that is 0, it approaches xi = 0 for all
        times. Otherwise it reaches the top xi = h = |x1|, at exp(l t) = (h + sqrt(h^2 - 4 A
        B))/(2 A).
        """
        # A, B = (xi0 +- v0/l)/2
        xi = start.x - self.x1
        height = -self.x1
        l_rate = arb_of(self.steep).sqrt()
        v_over_l = start.sense * arb_of(start.square).sqrt() / l_rate
        a = (arb_of(xi) + v_over_l) / 2
        b = (arb_of(xi) - v_over_l) / 2
        square_at_x1 = start.square - self.steep * xi * xi
        if start.sense < 0 and square_at_x1 == 0:
            return None
        # xi = 0 at exp(2 l t) = -B/A.
        if start.sense < 0 and square_at_x1 > 0:
            next_start = Start(self.x1, square_at_x1, -1)
            return (-b / a).log() / (2 * l_rate), "left", next_start
        # v^2 at the top: v0^2 + l^2 (h^2 - xi0^2).
        square_at_top = start.square + self.steep * (height * height - xi * xi)
        # sqrt(h^2 - 4 A B) is the velocity at the top over l.
        root = arb_of(square_at_top / self.steep).sqrt()
        duration = ((arb_of(height) + root) / (2 * a)).log() / l_rate
        return duration, "falling", Start(Fraction(0), square_at_top, 1)

    def descended(self, start: Start) -> tuple[arb, str, Start] | None:
        """The end of a phase on the falling flank, eta = R cos(w t + delta), pi/2 <= delta <= 3
        pi/2.

        R^2 = eta0^2 + v0^2/w^2. With v0 < 0 it reaches the top, eta = -x2, if R > x2, at the phase
        acos(-x2/R). Otherwise it leaves to the right at eta = 0, at the phase 3 pi/2. At rest at x2
        it stays there.
        """
        eta = start.x - self.x2
        width = self.x2
        w = arb_of(self.fall).sqrt()
        # R^2 = eta0^2 + v0^2/w^2.
        radius_square = eta * eta + start.square / self.fall
        if radius_square == 0:
            return None
        delta = self.lag(eta, start)
        if start.sense < 0 and radius_square > width * width:
            phase_at_top = (arb_of(-width) / arb_of(radius_square).sqrt()).acos()
            # v^2 = w^2 (R^2 - x2^2) at the top.
            next_start = Start(Fraction(0), self.fall * (radius_square - width * width), -1)
            return (phase_at_top - delta) / w, "rising", next_start
        if start.sense < 0 and radius_square == width * width:
            raise UndecidedError("it turns exactly where the flanks meet")
        # v^2 = w^2 R^2 at eta = 0.
        next_start = Start(self.x2, self.fall * radius_square, 1)
        return (3 * arb.pi() / 2 - delta) / w, "right", next_start

    def lag(self, eta: Fraction, start: Start) -> arb:
        """The phase delta at the start: eta = R cos(delta), v = -R w sin(delta)."""
        # delta = pi + atan2(v/w, -eta), in [pi/2, 3 pi/2] since eta <= 0
        v_over_w = start.sense * arb_of(start.square / self.fall).sqrt()
        return arb.pi() + atan2(v_over_w, arb_of(-eta))

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x and v at time t; raises UndecidedError where the phase of t is not decided."""
        if t < 0:
            raise NotCertifiedError("asymmetric-field: t < 0 is before the start")
        for phase in self.phases():
            if phase.end is None or t <= phase.end:
                return self.moved(phase, t - phase.begin)
            if not t > phase.end:
                raise UndecidedError(f"in which phase it is at {t}")
        raise AssertionError("the last phase has no end")

    def moved(self, phase: Phase, t: arb) -> dict[str, arb]:
        """The state at the time t [s] after the start of a phase.

        x = z + (x0 - z) c + (v0/r) s about the zero z of the flank's line, with c, s = cosh, sinh
        of r t on the rising flank (r = l) and cos, sin on the falling one (r = w).
        """
        start = phase.start
        x = arb_of(start.x)
        v = start.sense * arb_of(start.square).sqrt()
        if phase.region in ("left", "right"):
            return {"x": x + v * t, "v": v}
        if phase.region == "rising":
            zero = arb_of(self.x1)
            rate = arb_of(self.steep).sqrt()
            c = (rate * t).cosh()
            s = (rate * t).sinh()
            side = 1
        else:
            zero = arb_of(self.x2)
            rate = arb_of(self.fall).sqrt()
            c = (rate * t).cos()
            s = (rate * t).sin()
            side = -1
        return {
            "x": zero + (x - zero) * c + v / rate * s,
            "v": side * (x - zero) * rate * s + v * c,
        }

    @per_precision
    def growth(self) -> Grows:
        """How errors grow, phase by phase."""
        fastest = arb_of(max(self.steep, self.fall)).sqrt()
        return Growth(self.stretches(), Norm([1, 1]), step=narrow(fastest))

    def stretches(self) -> Iterator[Stretch]:
        """The stretches of time along which errors grow by a linear law: one a phase.

        The force is continuous at the edges, so that errors do not jump there.
        """
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        # Slope of the force per mass and its sign, see line_growth.linear.
        laws = {
            "left": (arb(0), 0),
            "rising": (arb_of(self.steep), 1),
            "falling": (arb_of(self.fall), -1),
            "right": (arb(0), 0),
        }
        for phase in self.phases():
            if phase.end is None:
                length = None
            else:
                length = phase.end - phase.begin
            yield smooth(phase.begin, length, partial(linear, *laws[phase.region], ratio))

    def constants(self) -> dict[str, arb]:
        """The work -k1 x1 (x2 - x1)/2 [J] of the force from x1 to x2: the area of a triangle."""
        x1 = self.x1
        x2 = self.x2
        # The largest force is -k1 x1, at x = 0; the base of the triangle is x2 - x1.
        return {"work": arb_of(self.k1 * -x1 * (x2 - x1) / 2)}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case asymmetric-field."""
    exact = numbers(p, "mass", "k1", "x1", "x2", "x0", "v0")
    return AsymmetricField(refiner=Refiner.of(scale), **exact)
