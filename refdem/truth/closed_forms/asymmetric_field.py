"""A particle in a force that rises from x1 to 0 and falls to x2 (1.139): phases in closed form,
which one follows by exact energies.

Rising flank: x - x1 = xi, xi'' = (k1/m) xi. Falling flank: x - x2 = eta, eta'' = -|k2|/m eta.
Outside free flight. Speeds squared at x1, 0 and x2 are rational, so that whether it turns, and on
which flank, is decided exactly.
"""

from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Self

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.line_growth import linear
from refdem.truth.refiner import Refiner, Size
from refdem.truth.smooth_flow import SmoothFlow


@dataclass(frozen=True)
class Start:
    """Where a phase begins: a rational place, the square of the velocity and its sign."""

    x: Fraction
    square: Fraction
    sense: int


@dataclass(frozen=True)
class Phase:
    """A phase with its region (left, rising, falling, right), its begin [s], and its end (None:
    never).
    """

    region: str
    start: Start
    begin: arb
    end: arb | None


class AsymmetricField(ClosedForm, SmoothFlow):
    """x [m] and v [m/s] at t >= 0; scalar: work, that of the force on a particle that crosses from
    left to right [J].
    """

    state = ("x", "v")
    method = "closed form phase by phase, branches by exact energies"
    witness = "Taylor integration phase by phase, energy"

    def __init__(self, scale: Mapping[str, Size], exact: Mapping[str, Fraction]) -> None:
        self.refiner = Refiner.of(scale)
        self.exact = dict(exact)
        self.steep = self.exact["k1"] / self.exact["mass"]
        self.fall = self.steep * -self.exact["x1"] / self.exact["x2"]

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        name = ("x0", "v0")[axis]
        other.kept = {}
        other.exact = self.exact | {name: self.exact[name] + amount}
        return other

    @per_precision
    def phases(self) -> list[Phase]:
        """All phases, the last without an end."""
        x = self.exact["x0"]
        v = self.exact["v0"]
        start = Start(x, v * v, (v > 0) - (v < 0))
        found = []
        begin = arb(0)
        region = self.region(x, start.sense)
        while True:
            told = self.end(region, start)
            found.append(Phase(region, start, begin, None if told is None else begin + told[0]))
            if told is None:
                return found
            begin = begin + told[0]
            (_, region, start) = told

    def region(self, x: Fraction, sense: int) -> str:
        """Where a start lies; at an edge, where it goes."""
        x1 = self.exact["x1"]
        x2 = self.exact["x2"]
        if x < x1 or (x == x1 and sense <= 0):
            return "left"
        if x < 0 or (x == 0 and sense < 0):
            return "rising"
        if x < x2 or (x == x2 and sense < 0):
            return "falling"
        return "right"

    def end(self, region: str, start: Start) -> tuple[arb, str, Start] | None:
        """How long a phase lasts, and what follows; None if it never ends."""
        x1 = self.exact["x1"]
        x2 = self.exact["x2"]
        speed = arb_of(start.square).sqrt()
        if region == "left":
            if start.sense > 0:
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
        """The end on the rising flank, xi = A exp(l t) + B exp(-l t)."""
        xi = start.x - self.exact["x1"]
        high = -self.exact["x1"]
        rate = arb_of(self.steep).sqrt()
        swing = start.sense * arb_of(start.square).sqrt() / rate
        a = (arb_of(xi) + swing) / 2
        b = (arb_of(xi) - swing) / 2
        back = start.square - self.steep * xi * xi
        if start.sense < 0 and back == 0:
            return None
        if start.sense < 0 and back > 0:
            return (-b / a).log() / (2 * rate), "left", Start(self.exact["x1"], back, -1)
        top = arb_of(high)
        end = start.square + self.steep * (high * high - xi * xi)
        apart = arb_of(end / self.steep).sqrt()  # sqrt(high^2 - 4 A B), and 4 A B = xi^2 - v^2/l^2
        return ((top + apart) / (2 * a)).log() / rate, "falling", Start(Fraction(0), end, 1)

    def descended(self, start: Start) -> tuple[arb, str, Start] | None:
        """The end on the falling flank, eta = R cos(w t + delta), pi/2 <= delta <= 3 pi/2."""
        eta = start.x - self.exact["x2"]
        wide = self.exact["x2"]
        rate = arb_of(self.fall).sqrt()
        size = eta * eta + start.square / self.fall
        if size == 0:
            return None
        lag = self.lag(eta, start)
        if start.sense < 0 and size > wide * wide:
            until = (arb_of(-wide) / arb_of(size).sqrt()).acos()
            return (
                (until - lag) / rate,
                "rising",
                Start(Fraction(0), self.fall * (size - wide * wide), -1),
            )
        if start.sense < 0 and size == wide * wide:
            raise UndecidedError("it turns exactly where the flanks meet")
        return (
            (3 * arb.pi() / 2 - lag) / rate,
            "right",
            Start(self.exact["x2"], self.fall * size, 1),
        )

    def lag(self, eta: Fraction, start: Start) -> arb:
        """The phase delta by which the motion lags, for a given eta."""
        swing = start.sense * arb_of(start.square / self.fall).sqrt()
        return arb.pi() + arb.atan2(swing, arb_of(-eta))

    def evaluate(self, t: arb) -> dict[str, arb]:
        if t < 0:
            raise NotCertifiedError("asymmetric-field: t < 0 is before the start")
        for phase in self.phases():
            if phase.end is None or t <= phase.end:
                return self.moved(phase, t - phase.begin)
            if not t > phase.end:
                raise UndecidedError(f"in which phase it is at {t}")
        raise AssertionError("the last phase has no end")

    def moved(self, phase: Phase, t: arb) -> dict[str, arb]:
        """The state so long after the begin of a phase."""
        start = phase.start
        x = arb_of(start.x)
        v = start.sense * arb_of(start.square).sqrt()
        if phase.region in ("left", "right"):
            return {"x": x + v * t, "v": v}
        if phase.region == "rising":
            flank = self.steep
        else:
            flank = self.fall
        centre = arb_of(self.exact["x1" if phase.region == "rising" else "x2"])
        rate = arb_of(flank).sqrt()
        c, s = (
            ((rate * t).cosh(), (rate * t).sinh())
            if phase.region == "rising"
            else ((rate * t).cos(), (rate * t).sin())
        )
        if phase.region == "rising":
            side = 1
        else:
            side = -1
        return {
            "x": centre + (x - centre) * c + v / rate * s,
            "v": side * (x - centre) * rate * s + v * c,
        }

    @per_precision
    def growth(self) -> Grows:
        return Growth(
            self.stretches(), Norm([1, 1]), step=narrow(arb_of(max(self.steep, self.fall)).sqrt())
        )

    def stretches(self) -> Iterator[Stretch]:
        """Phase by phase; the force has no jump, and so errors have none."""
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        kinds = {
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
            yield smooth(phase.begin, length, partial(linear, *kinds[phase.region], ratio))

    def constants(self) -> dict[str, arb]:
        x1 = self.exact["x1"]
        x2 = self.exact["x2"]
        return {"work": arb_of(self.exact["k1"] * -x1 * (x2 - x1) / 2)}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case asymmetric-field."""
    return AsymmetricField(scale, numbers(p, "mass", "k1", "x1", "x2", "x0", "v0"))
