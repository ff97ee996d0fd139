"""m x'' + 2 m delta x' + k x = m g + m f0 cos(w t): damped in any of three ways, driven or not,
from any start.

About c = m g/k: X = X0 (C + delta S) + V0 S, V = V0 (C - delta S) - w0^2 X0 S with, D^2 = |w0^2 -
delta^2|, C = exp(-delta t) cos D t, S = exp(-delta t) (sin D t)/D below critical damping,
exp(-delta t) and exp(-delta t) t at it, cosh and sinh above. A drive adds its steady motion Re(A
exp(i w t)), A = f0/(w0^2 - w^2 + 2 i delta w) (1.104), and takes its start from X0, V0; without
damping at w = w0 it adds f0 t sin(w0 t)/(2 w0) instead.
"""

from collections.abc import Mapping
from copy import copy
from fractions import Fraction
from typing import Self

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Norm, SteadyGrowth, Told, narrow
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import SmoothFlow


class DrivenOscillator(ClosedForm, SmoothFlow):
    """x [m] and v [m/s] at t; `f0` [m/s^2] and `drive` [rad/s] are zero where nothing drives."""

    method = "closed form; regime and resonance decided in exact rationals"
    witness = "Taylor series of the equation in rational arithmetic"
    state = ("x", "v")

    def __init__(self, p: Parameters, scale: Mapping[str, float], *, is_driven: bool) -> None:
        self.refiner = Refiner.of(scale)
        values = numbers(
            p,
            "mass",
            "stiffness",
            "gravity",
            "x0",
            "v0",
            "delta",
            *(("f0", "drive") if is_driven else ()),
        )
        self.square = values["stiffness"] / values["mass"]
        self.delta = values["delta"]
        self.centre = values["gravity"] / self.square
        self.x0 = values["x0"]
        self.v0 = values["v0"]
        self.f0, self.drive = values.get("f0", Fraction(0)), values.get("drive", Fraction(0))
        self.is_driven = is_driven

    @property
    def gap(self) -> Fraction:
        """The difference w0^2 - delta^2 of squared frequencies [1/s^2]."""
        return self.square - self.delta**2

    @property
    def resounds(self) -> bool:
        """Undamped and driven at w0: the amplitude grows for ever."""
        return self.delta == 0 and self.drive**2 == self.square

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion from a neighbouring start."""
        other = copy(self)
        other.kept = {}
        other.x0 = self.x0 + amount * (axis == 0)
        other.v0 = self.v0 + amount * (axis == 1)
        return other

    def free(self, x0: arb, v0: arb, t: arb) -> tuple[arb, arb]:
        """X and V at t of the free motion about the equilibrium."""
        delta = arb_of(self.delta)
        fade = (-arb_of(self.delta) * t).exp()
        width = arb_of(abs(self.gap)).sqrt()
        if self.gap > 0:
            c = (width * t).cos()
            s = (width * t).sin() / width
        elif self.gap < 0:
            c = (width * t).cosh()
            s = (width * t).sinh() / width
        else:
            c = arb(1)
            s = t
        c = fade * c
        s = fade * s
        return x0 * (c + delta * s) + v0 * s, v0 * (c - delta * s) - arb_of(self.square) * x0 * s

    def steady(self, t: arb) -> tuple[arb, arb]:
        """x and v of the steady motion; at undamped resonance of the growing one from rest."""
        f0 = arb_of(self.f0)
        w = arb_of(self.drive)
        sine, cosine = (w * t).sin_cos()
        if self.f0 == 0:
            return arb(0), arb(0)
        if self.resounds:
            return f0 * t * sine / (2 * w), f0 * (sine + w * t * cosine) / (2 * w)
        away = arb_of(self.square - self.drive**2)
        drag = arb_of(2 * self.delta * self.drive)
        size = away * away + drag * drag
        return (
            f0 * (away * cosine + drag * sine) / size,
            f0 * w * (drag * cosine - away * sine) / size,
        )

    def evaluate(self, t: arb) -> dict[str, arb]:
        centre, (x_first, v_first), (x_steady, v_steady) = (
            arb_of(self.centre),
            self.steady(arb(0)),
            self.steady(t),
        )
        x, v = self.free(arb_of(self.x0) - centre - x_first, arb_of(self.v0) - v_first, t)
        return {"x": centre + x + x_steady, "v": v + v_steady}

    @per_precision
    def growth(self) -> Grows:
        """The motion is linear: an error grows as the free motion does, whenever it is made; in a
        whole period it does not grow.
        """
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        if self.delta**2 >= 4 * self.square:
            # Over-damped, with the rates s1 < s2 = delta -+ kappa: of x there is left, for x at the
            # start, (s2 exp(-s1 t) - s1 exp(-s2 t))/(s2 - s1) <= 1, for v at most 1/(s2 - s1); of v
            # at most s1 s2/(s2 - s1) for x, and 1 for v.
            apart = 2 * arb_of(-self.gap).sqrt()
            by_other = ((1 / (apart * ratio)).max(arb_of(self.square) * ratio / apart)).upper()
            return Told(lambda _: 1 + by_other)
        one = arb(1)
        none = arb(0)

        def propagator(elapsed: arb) -> arb_mat:
            (by_x, rate_by_x), (by_v, rate_by_v) = (
                self.free(one, none, elapsed),
                self.free(none, one, elapsed),
            )
            return arb_mat([[by_x, by_v / ratio], [rate_by_x * ratio, rate_by_v]])

        if self.gap > 0:
            period = 2 * arb.pi() / arb_of(self.gap).sqrt()
        else:
            period = None
        return SteadyGrowth(
            propagator,
            Norm([1, 1]),
            narrow(arb_of(self.square).sqrt() + arb_of(self.delta)),
            period,
        )

    def constants(self) -> dict[str, arb]:
        """The period of the free oscillation, if it oscillates; driven, the amplitude |A| (1.105)
        of the steady motion, if there is one.
        """
        if not self.is_driven:
            if self.gap > 0:
                return {"period": 2 * arb.pi() / arb_of(self.gap).sqrt()}
            return {}
        if self.resounds:
            return {}
        away = self.square - self.drive**2
        drag = 2 * self.delta * self.drive
        return {"steady_amplitude": arb_of(abs(self.f0)) / arb_of(away**2 + drag**2).sqrt()}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, gravity, delta, f0, drive, x0, v0.

    `scale` of x and v.
    """
    return DrivenOscillator(p, scale, is_driven=True)
