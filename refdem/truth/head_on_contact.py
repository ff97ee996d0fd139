"""Head-on contact of two spheres with a linear spring and dashpot, in closed form.

Theorem: the overlap d obeys m d'' + c d' + k d = 0, d(0) = 0, d'(0) = v, with m the effective mass,
until the force or the overlap ends; then the spheres fly freely. Schwager and Poeschel, Granular
Matter 9 (2007) 465.

Hypotheses, and where each is checked:

* nothing slips, ever: `SpherePair.is_head_on`, of exact parameters;
* the sign of w^2 below is decided exactly (`regime`);
* whether t is before the end of the force need not be decided: both are held (`relative`).

Formula: with b = c/(2m), w0^2 = k/m, w^2 = w0^2 - b^2: d = v exp(-b t) sin(w t)/w, with sinh(W t)/W
or t in place of sin(w t)/w where damping is over-critical (W^2 = -w^2) or critical.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.dual import atan2
from refdem.truth.exact import sign_of
from refdem.truth.reals import Number
from refdem.truth.sphere_pair import SpherePair


@dataclass(frozen=True)
class HeadOnContact:
    """Overlap, force and free flight of a head-on pair at the current precision."""

    pair: SpherePair

    @cached_property
    def decay(self) -> arb:
        """Half the rate of decay, b = c/(2m) [1/s]."""
        return arb_of(self.pair.half_decay)

    @cached_property
    def square(self) -> Number:
        """w^2 = k/m - b^2 [1/s^2], exact if the pair is."""
        return self.pair.stiffness / self.pair.effective_mass - self.pair.half_decay**2

    @cached_property
    def regime(self) -> int:
        """The sign of w^2: 1 under-damped, 0 critical, -1 over-critical."""
        return sign_of(self.square)

    @cached_property
    def rate(self) -> arb:
        """w where under-damped, W where over-critical [1/s]."""
        size: Any = abs(self.square)
        return arb_of(size).sqrt()

    @cached_property
    def angle(self) -> arb:
        """atan2(w, b), where under-damped: the overlap is largest at angle/w."""
        return atan2(self.rate, self.decay)

    @cached_property
    def speed(self) -> arb:
        """The speed v [m/s] at touch."""
        return arb_of(self.pair.closing_speed)

    def overlap(self, t: arb) -> tuple[arb, arb]:
        """The overlap d [m] and its rate d' [m/s] at t [s], while the law acts.

        d = v exp(-b t) s and d' = v exp(-b t) (c - b s), with c = cos(w t), s = sin(w t)/w or what
        stands in their place.
        """
        if self.regime > 0:
            cosine = (self.rate * t).cos()
            sine = (self.rate * t).sin() / self.rate
        elif self.regime < 0:
            cosine = (self.rate * t).cosh()
            sine = (self.rate * t).sinh() / self.rate
        else:
            cosine = arb(1)
            sine = t
        # d = v exp(-b t) s, d' = v exp(-b t) (c - b s)
        amplitude = self.speed * (-self.decay * t).exp()
        return amplitude * sine, amplitude * (cosine - self.decay * sine)

    def end(self) -> arb | None:
        """The time [s] at which the force ends; None if the overlap never does (zero_overlap, not
        under-damped).
        """
        if self.regime > 0:
            if self.pair.ends_with_overlap:
                phase = arb.pi()
            else:
                # The force k d + c d' ends at twice the phase of the largest overlap.
                phase = 2 * self.angle
            return phase / self.rate
        if self.pair.ends_with_overlap:
            return None
        return self._times_to_turn(2)

    def _times_to_turn(self, count: int) -> arb:
        """`count` times the time [s] from touch to the largest overlap, for over-critical or
        critical damping.

        tanh(W t) = W/b, so that t = ln((b + W)/(b - W))/(2 W); t = 1/b for W = 0.
        """
        if self.regime == 0:
            return count / self.decay
        # t = artanh(W/b)/W = ln((b + W)/(b - W))/(2 W)
        logarithm = ((self.decay + self.rate) / (self.decay - self.rate)).log()
        return logarithm / self.rate * count / 2

    def force(self, t: arb) -> arb:
        """Normal force [N] at t while the law acts."""
        overlap, rate = self.overlap(t)
        return arb_of(self.pair.stiffness) * overlap + arb_of(self.pair.damping) * rate

    def relative(self, t: arb) -> list[arb]:
        """x, y, vx, vy of body 1 against body 2 at t [s], and two zeros: the friction impulse and
        what its moment arm loses.
        """
        end = self.end()
        overlap, rate = self.overlap(t)
        if end is not None and not t <= end:
            # Free flight from the end of the force on.
            overlap_at_end, free_rate = self.overlap(end)
            free_overlap = overlap_at_end + free_rate * (t - end)
            if t >= end:
                overlap = free_overlap
                rate = free_rate
            else:
                # Balls do not decide on which side of the end t lies: the union contains both.
                overlap = overlap.union(free_overlap)
                rate = rate.union(free_rate)
        return [overlap - arb_of(self.pair.reach), arb(0), rate, arb(0), arb(0), arb(0)]

    def constants(self) -> dict[str, arb]:
        """The scalars max_overlap [m], max_force [N], and, if the force ends, duration [s] and
        restitution exp(-b t_end).
        """
        pair = self.pair
        end = self.end()
        if self.regime > 0:
            turn = self.angle / self.rate
        else:
            turn = self._times_to_turn(1)
        largest_overlap, _ = self.overlap(turn)
        # k d + c d' falls from touch on, where it is c v, unless 4 b^2 < k/m: then it is largest
        # where its rate vanishes, at w t = 3 angle - pi.
        if 4 * pair.half_decay**2 * pair.effective_mass < pair.stiffness:
            largest_force = self.force((3 * self.angle - arb.pi()) / self.rate)
        else:
            largest_force = arb_of(pair.damping) * self.speed
        scalars = {"max_overlap": largest_overlap, "max_force": largest_force}
        if end is not None:
            scalars |= {"duration": end, "restitution": (-self.decay * end).exp()}
        return scalars
