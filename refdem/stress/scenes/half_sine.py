"""Certified contact of a linear spring without loss: d'' = -w^2 d while d > 0, uniform motion before and after."""

from collections.abc import Mapping
from fractions import Fraction

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, Size


class HalfSine(ClosedForm):
    """The overlap d (negative: apart) and its rate, from an exact start (d, rate) that is in contact or comes into it; w^2 = k/m.

    `bodies`: so many take part, and an error of each reaches all others, so that S is as many times larger.
    """

    method = "uniform motion, sine until the overlap is 0, uniform motion: Arb balls"
    witness = "Runge-Kutta integration (tests/stress)"
    state = ("overlap", "rate")

    def __init__(self, square: Fraction, start: tuple[Fraction, Fraction], scale: Mapping[str, Size], bodies: int = 1) -> None:
        super().__init__(scale)
        self.square, self.start, self.bodies = square, start, bodies

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Overlap [m] and rate [m/s]."""
        d, rate = self.start
        w = arb_of(self.square).sqrt()
        touch = arb_of(-d / rate if d < 0 else Fraction(0))
        inside = Fraction(0) if d < 0 else d
        if t < touch:
            return self._pair(arb_of(d) + arb_of(rate) * t, arb_of(rate))
        sine, cosine = arb_of(inside) * w, arb_of(rate)
        size = (sine * sine + cosine * cosine).sqrt() / w
        phase = arb.atan2(sine, cosine)
        turned, end = w * (t - touch) + phase, arb.pi()
        if turned < end:
            return self._pair(size * turned.sin(), size * w * turned.cos())
        if turned > end:
            return self._pair(-size * (turned - end), -size * w)
        raise UndecidedError("at the end of contact")

    def _pair(self, overlap: arb, rate: arb) -> dict[str, arb]:
        return {"overlap": overlap, "rate": rate, **{name: arb(0) for name in self.scale if name not in self.state}}

    def displaced(self, axis: int, amount: Fraction) -> "HalfSine":
        """From a start that is larger by `amount`."""
        d, rate = self.start
        start = (d + amount, rate) if axis == 0 else (d, rate + amount)
        return HalfSine(self.square, start, self.scale, self.bodies)

    def sensitivity(self, t: Fraction) -> float:
        """That of one body times the number of bodies."""
        return self.bodies * super().sensitivity(t)
