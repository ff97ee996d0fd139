"""Certified contact of a linear spring without loss: d'' = -w^2 d while d > 0, uniform motion
before and after.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.growth import Grows, Growth, Norm, Stretch, Times, narrow, smooth
from refdem.truth.line_growth import linear


@dataclass(frozen=True)
class HalfSine(ClosedForm):
    """The overlap d (negative: apart) and its rate, from an exact start (d, rate) in contact or
    before it; `square` is w^2 = k/m.

    `bodies` take part, and an error of each may reach all others, so that S is larger by that
    factor.
    """

    method = "uniform motion, sine until the overlap is 0, uniform motion: Arb balls"
    witness = "Runge-Kutta integration (tests/stress)"
    state = ("overlap", "rate")

    square: Fraction
    start: tuple[Fraction, Fraction]
    bodies: int = 1

    displaced = displaced_tuple("start")

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The overlap [m] and its rate [m/s] at t [s]."""
        d, rate = self.start
        w = arb_of(self.square).sqrt()
        contact_start, d0 = self._contact_start()
        if t < contact_start:
            return self._pair(arb_of(d) + arb_of(rate) * t, arb_of(rate))
        # d = A sin(w (t - t_c) + phase) with A w = sqrt((w d0)^2 + rate^2) and phase = atan2(w d0,
        # rate). The contact ends at the argument pi with the rate -A w, and d = -A w (t - t_end).
        amplitude_sine = arb_of(d0) * w
        amplitude_cosine = arb_of(rate)
        amplitude = (
            amplitude_sine * amplitude_sine + amplitude_cosine * amplitude_cosine
        ).sqrt() / w
        phase = arb.atan2(amplitude_sine, amplitude_cosine)
        phase_now = w * (t - contact_start) + phase
        end = arb.pi()
        if phase_now < end:
            return self._pair(amplitude * phase_now.sin(), amplitude * w * phase_now.cos())
        if phase_now > end:
            return self._pair(-amplitude * (phase_now - end), -amplitude * w)
        raise UndecidedError("at the end of contact")

    def _contact_start(self) -> tuple[arb, Fraction]:
        """The time [s] at which contact begins, with the overlap [m] then: at once, or after
        uniform motion with overlap 0.
        """
        d, rate = self.start
        if d < 0:
            return arb_of(-d / rate), Fraction(0)
        return arb_of(Fraction(0)), d

    def _pair(self, overlap: arb, rate: arb) -> dict[str, arb]:
        """Values of all quantities; those other than overlap and rate are 0."""
        others = {name: arb(0) for name in self.scale if name not in self.state}
        return {"overlap": overlap, "rate": rate, **others}

    @per_precision
    def growth(self) -> Grows:
        """The growth of errors of one pair, times the number of bodies."""
        rate = arb_of(self.square).sqrt()
        return Times(Growth(self.stretches(), Norm([1, 1]), step=narrow(rate)), arb(self.bodies))

    def stretches(self) -> Iterator[Stretch]:
        """Uniform motion, contact, uniform motion. The force is continuous, so errors do not jump
        between them.
        """
        d, rate = self.start
        ratio = arb_of(self.scale["overlap"] / self.scale["rate"])
        w = arb_of(self.square).sqrt()
        contact_start, d0 = self._contact_start()
        free = partial(linear, arb(0), 0, ratio)
        if d < 0:
            yield smooth(arb(0), contact_start, free)
        # The phase runs from atan2(w d, rate) to pi.
        phase = arb.atan2(arb_of(d0) * w, arb_of(rate))
        duration = (arb.pi() - phase) / w
        yield smooth(contact_start, duration, partial(linear, arb_of(self.square), -1, ratio))
        yield smooth(contact_start + duration, None, free)
