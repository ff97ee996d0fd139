"""Certified contact of a linear spring without loss: d'' = -w^2 d while d > 0, uniform motion
before and after.
"""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import partial

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.growth import Grows, Growth, Norm, Stretch, Times, narrow, smooth
from refdem.truth.line_growth import linear
from refdem.truth.refiner import Refiner, Size


class HalfSine(ClosedForm):
    """The overlap d (negative: apart) and its rate, from an exact start (d, rate) that is in
    contact or comes into it; w^2 = k/m.

    `bodies`: so many take part, and an error of each reaches all others, so that S is as many times
    larger.
    """

    method = "uniform motion, sine until the overlap is 0, uniform motion: Arb balls"
    witness = "Runge-Kutta integration (tests/stress)"
    state = ("overlap", "rate")

    def __init__(
        self,
        square: Fraction,
        start: tuple[Fraction, Fraction],
        scale: Mapping[str, Size],
        bodies: int = 1,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.square = square
        self.start = start
        self.bodies = bodies

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The overlap [m] and its rate [m/s] at t [s]."""
        d, rate = self.start
        w = arb_of(self.square).sqrt()
        touch, inside = self._contact_start()
        if t < touch:
            return self._pair(arb_of(d) + arb_of(rate) * t, arb_of(rate))
        sine = arb_of(inside) * w
        cosine = arb_of(rate)
        size = (sine * sine + cosine * cosine).sqrt() / w
        phase = arb.atan2(sine, cosine)
        turned = w * (t - touch) + phase
        end = arb.pi()
        if turned < end:
            return self._pair(size * turned.sin(), size * w * turned.cos())
        if turned > end:
            return self._pair(-size * (turned - end), -size * w)
        raise UndecidedError("at the end of contact")

    def _contact_start(self) -> tuple[arb, Fraction]:
        """The time [s] at which contact begins, and the overlap [m] then: at once with that of
        the start, or later with none.
        """
        d, rate = self.start
        if d < 0:
            return arb_of(-d / rate), Fraction(0)
        return arb_of(Fraction(0)), d

    def _pair(self, overlap: arb, rate: arb) -> dict[str, arb]:
        """The values of all quantities; those that are not the pair's are 0."""
        others = {name: arb(0) for name in self.scale if name not in self.state}
        return {"overlap": overlap, "rate": rate, **others}

    def displaced(self, axis: int, amount: Fraction) -> "HalfSine":
        """The motion from a start that is larger by `amount`."""
        d, rate = self.start
        if axis == 0:
            start = (d + amount, rate)
        else:
            start = (d, rate + amount)
        return HalfSine(self.square, start, self.scale, self.bodies)

    @per_precision
    def growth(self) -> Grows:
        """The growth for one body times the number of bodies."""
        rate = arb_of(self.square).sqrt()
        return Times(Growth(self.stretches(), Norm([1, 1]), step=narrow(rate)), arb(self.bodies))

    def stretches(self) -> Iterator[Stretch]:
        """Uniform motion, contact, uniform motion; the force has no jump, and so errors have
        none.
        """
        d, rate = self.start
        ratio = arb_of(self.scale["overlap"] / self.scale["rate"])
        w = arb_of(self.square).sqrt()
        touch, inside = self._contact_start()
        free = partial(linear, arb(0), 0, ratio)
        if d < 0:
            yield smooth(arb(0), touch, free)
        # The phase runs from atan2(w d, rate) to pi.
        phase = arb.atan2(arb_of(inside) * w, arb_of(rate))
        lasting = (arb.pi() - phase) / w
        yield smooth(touch, lasting, partial(linear, arb_of(self.square), -1, ratio))
        yield smooth(touch + lasting, None, free)
