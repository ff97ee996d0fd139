"""Head-on contact of two spheres with a linear spring and dashpot, in closed form: m d'' + c d' + k
d = 0, d(0) = 0, d'(0) = v.

With m the effective mass, b = c/(2m), w0^2 = k/m, w^2 = w0^2 - b^2: d = v exp(-b t) sin(w t)/w,
sinh(W t)/W or t in place of sin(w t)/w where damping is over-critical (W^2 = -w^2) or critical.
Schwager and Poeschel, Granular Matter 9 (2007) 465.
"""

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.sphere_pair import SpherePair


class HeadOnContact:
    """Overlap, force and free flight of a head-on pair at the current precision."""

    def __init__(self, pair: SpherePair) -> None:
        self.pair = pair
        self.decay = arb_of(pair.half_decay)
        squared = pair.stiffness / pair.effective_mass - pair.half_decay**2
        self.regime = (squared > 0) - (squared < 0)
        self.rate = arb_of(abs(squared)).sqrt()
        if self.regime > 0:
            self.angle = arb.atan2(self.rate, self.decay)
        else:
            self.angle = arb(0)
        self.speed = arb_of(pair.closing_speed)

    def overlap(self, t: arb) -> tuple[arb, arb]:
        """Overlap [m] and its rate [m/s] while the law acts."""
        wave = arb(1)
        swing = t
        if self.regime > 0:
            wave = (self.rate * t).cos()
            swing = (self.rate * t).sin() / self.rate
        elif self.regime < 0:
            wave = (self.rate * t).cosh()
            swing = (self.rate * t).sinh() / self.rate
        size = self.speed * (-self.decay * t).exp()
        return size * swing, size * (wave - self.decay * swing)

    def end(self) -> arb | None:
        """When the force ends [s].

        None if the overlap never does (zero_overlap, not under-damped).
        """
        if self.regime > 0:
            return (arb.pi() if self.pair.ends_with_overlap else 2 * self.angle) / self.rate
        if self.pair.ends_with_overlap:
            return None
        return self._span(2)

    def _span(self, times: int) -> arb:
        """Once or twice the time to the turn for over-critical or critical damping [s]."""
        if self.regime == 0:
            return times / self.decay
        return ((self.decay + self.rate) / (self.decay - self.rate)).log() / self.rate * times / 2

    def force(self, t: arb) -> arb:
        """Normal force [N] at t while the law acts."""
        overlap, rate = self.overlap(t)
        return arb_of(self.pair.stiffness) * overlap + arb_of(self.pair.damping) * rate

    def relative(self, t: arb) -> list[arb]:
        """x, y, vx, vy of body 1 against body 2, the friction impulse and its moment arm lost, at
        t.
        """
        end = self.end()
        overlap, rate = self.overlap(t)
        if end is not None and not t <= end:
            at_end, flying = self.overlap(end)
            free = at_end + flying * (t - end), flying
            overlap, rate = free if t >= end else (overlap.union(free[0]), rate.union(free[1]))
        return [overlap - arb_of(self.pair.reach), arb(0), rate, arb(0), arb(0), arb(0)]

    def constants(self) -> dict[str, arb]:
        """max_overlap, max_force, and duration and restitution if the force ends."""
        pair = self.pair
        end = self.end()
        if self.regime > 0:
            turn = self.angle / self.rate
        else:
            turn = self._span(1)
        found = {
            "max_overlap": self.overlap(turn)[0],
            "max_force": arb_of(pair.damping) * self.speed,
        }
        if 4 * pair.half_decay**2 * pair.effective_mass < pair.stiffness:
            found["max_force"] = self.force((3 * self.angle - arb.pi()) / self.rate)
        if end is not None:
            found |= {"duration": end, "restitution": (-self.decay * end).exp()}
        return found
