"""Oblique contact of two spheres, frictionless or in gross sliding, by proven integration in the plane.

Polar coordinates of r = r1 - r2 = -rho (cos phi, sin phi): with the overlap d = reach - rho, normal force F = k d - c rho' and the
friction f = -sgn(slip) mu F on body 1 along s (the normal e = r/rho turned by +90 degrees about z) while F presses,

    rho'' = h^2/rho^3 + F/m,   phi' = h/rho^2,   h' = rho f/m,   J' = f,   slip = h/rho - l1 omega1 - l2 omega2,

m the effective mass, h = rho^2 phi', l_i = R_i - beta d the levers (beta = 0, 1/2, 1). The torque on each body is -l_i f about z.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_poly, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.sphere_pair import SpherePair
from refdem.truth.validated import Flow, Piece, first_zero, is_positive

STILL: tuple[Fraction, ...] = (Fraction(0),) * 4
MANY = 500
"""Pieces of a contact, 60 to 120 time constants: an over-damped one that has not ended by then is left."""


class SlidingContact:
    """The relative motion at the precision at which it is made, integrated only as far as it is asked for.

    `offset` displaces the start (x, y, vx, vy); the law acts from t = 0 even if that parts the spheres by a hair.
    """

    def __init__(self, pair: SpherePair, *, offset: Sequence[Fraction] = STILL) -> None:
        self.pair = pair
        self.start = [value + arb_of(by) for value, by in zip(pair.start(), offset, strict=True)]
        x, y, vx, vy = self.start
        rho = (x * x + y * y).sqrt()
        self.twist = x * vy - y * vx
        self.polar = [rho, (x * vx + y * vy) / rho, arb.atan2(-y, -x), self.twist, arb(0)]
        self.side = 0 if pair.is_head_on or pair.friction == 0 else self._side(self.polar)
        self.phases = [Phase(self, self.polar, slides=self.side != 0)]

    def _side(self, polar: Sequence[arb]) -> int:
        pair, slip = self.pair, self.slip(polar)
        if any(pair.spins[axis] for axis in (0, 1, 3, 4)):
            raise NotCertifiedError("two-spheres: with friction, only spins about z keep the motion in its plane; set the others to 0")
        if pair.tangential_stiffness and pair.damping:
            raise NotCertifiedError("two-spheres: the tangential spring starts unstretched under a force, so the contact sticks first")
        if not (slip > 0 or slip < 0):
            raise NotCertifiedError("two-spheres: no slip is proved at the start, so that the contact may stick")
        return 1 if slip > 0 else -1

    def slip(self, polar: Sequence[Any]) -> Any:
        """Tangential velocity of surface 1 against surface 2 along s [m/s]."""
        pair, overlap = self.pair, arb_of(self.pair.reach) - polar[0]
        omega = self.spun(polar[3], polar[4])
        levers = [arb_of(radius) - arb_of(pair.lever) * overlap for radius in pair.radii]
        return polar[3] / polar[0] - levers[0] * omega[0] - levers[1] * omega[1]

    def lost(self, twist: arb, impulse: arb) -> arb:
        """Integral of overlap x friction [N s m]: reach J - m (h - h0)."""
        return arb_of(self.pair.reach) * impulse - arb_of(self.pair.effective_mass) * (twist - self.twist)

    def spun(self, twist: arb, impulse: arb) -> list[arb]:
        """Spins of both about z [rad/s] after the friction impulse."""
        lost = arb_of(self.pair.lever) * self.lost(twist, impulse)
        start = (self.pair.spins[2], self.pair.spins[5])
        bodies = zip(start, self.pair.radii, self.pair.moments, strict=True)
        return [arb_of(spin) - (arb_of(radius) * impulse - lost) / arb_of(moment) for spin, radius, moment in bodies]

    def relative(self, t: arb) -> list[arb]:
        """x, y, vx, vy of body 1 against body 2, and the friction impulse J and integral of overlap x friction, at t >= 0."""
        for phase in self.parts():
            phase.advance(t)
            if phase.end is None or t <= phase.end:
                return self._cartesian(phase.polar(t))
            if not t > phase.end:
                raise NotCertifiedError("two-spheres: asked too near the end of the contact to tell whether it has ended")
            t, last = t - phase.end, phase.polar(phase.end)
        x, y, vx, vy, *impulses = self._cartesian(last)
        return [x + vx * t, y + vy * t, vx, vy, *impulses]

    def parts(self) -> Iterator["Phase"]:
        """The phases, each from where the one before has ended."""
        yield self.phases[0]
        pulls = self.side != 0 and self.pair.damping > 0 and self.pair.ends_with_overlap
        if pulls and self.phases[0].end is not None:
            if len(self.phases) == 1:
                self.phases.append(Phase(self, self.phases[0].polar(self.phases[0].end), slides=False))
            yield self.phases[1]

    def _cartesian(self, polar: Sequence[arb]) -> list[arb]:
        rho, rate, phi, twist, impulse = polar
        sine, cosine = phi.sin_cos()
        across = twist / rho
        place = [-rho * cosine, -rho * sine, across * sine - rate * cosine, -across * cosine - rate * sine]
        return [*place, impulse, self.lost(twist, impulse)]

    def constants(self) -> dict[str, arb]:
        """duration, restitution of the normal velocity, max_overlap, and max_force where nothing damps."""
        duration = arb(0)
        for phase in self.parts():
            phase.advance(None)
            if phase.end is None:
                raise NotCertifiedError("two-spheres: the contact does not end within the time that is integrated")
            duration, last = duration + phase.end, phase.polar(phase.end)
        deepest = arb_of(self.pair.reach) - self.phases[0].closest()
        found = {"duration": duration, "restitution": -last[1] / self.polar[1], "max_overlap": deepest}
        return found if self.pair.damping else {**found, "max_force": arb_of(self.pair.stiffness) * deepest}


class Phase:
    """A stretch of the contact under one law: with friction or without, until overlap or force falls to zero."""

    def __init__(self, contact: SlidingContact, start: Sequence[arb], *, slides: bool) -> None:
        pair = contact.pair
        self.contact, self.slides = contact, slides
        self.mobility, self.stiffness, self.damping = (arb_of(x) for x in (1 / pair.effective_mass, pair.stiffness, pair.damping))
        self.reach, self.push = arb_of(pair.reach), -contact.side * arb_of(pair.friction) * slides
        self.ends_with_overlap = pair.damping == 0 or (pair.ends_with_overlap and not slides)
        self.flow = Flow(self._rates, start, pair.dyadic_step(), order=ctx.prec // 5)
        self.end: arb | None = None
        self.covered = 0

    def _force(self, polar: Sequence[Any]) -> Any:
        return (self.reach - polar[0]) * self.stiffness - polar[1] * self.damping

    def _rates(self, polar: Sequence[Any]) -> list[Any]:
        rho, rate, _, twist, _ = polar
        force, curvature = self._force(polar), 1 / rho
        turn, friction = twist * curvature * curvature, force * self.push
        return [rate, twist * turn * curvature + force * self.mobility, turn, rho * friction * self.mobility, friction]

    def advance(self, t: arb | None) -> None:
        """Integrates until the end is known or t (since the phase began) is covered; None: until the end."""
        while self.end is None and self.covered < MANY:
            if self.covered and t is not None:
                last = self.flow.piece(self.covered - 1)
                if t < last.begin + last.length:
                    return
            piece = self.flow.piece(self.covered)
            state = piece.polynomials
            gap: arb_poly = self.reach - state[0] if self.ends_with_overlap else self._force(state)
            zero = first_zero(gap, arb(0), piece.length)
            self._prove_sliding(piece, piece.length if zero is None else zero)
            self.end = None if zero is None else piece.begin + zero
            self.covered += 1

    def _prove_sliding(self, piece: Piece, until: arb) -> None:
        """Raises NotCertifiedError unless slip keeps its sign and, if there is a tangential spring, it stays at the limit.

        It does where k_t |slip| > mu dF/dt: the stretch that is clipped to mu F/k_t would grow faster than its limit does.
        """
        pair, contact = self.contact.pair, self.contact
        if not self.slides:
            return
        spring, limit = arb_of(pair.tangential_stiffness), arb_of(pair.friction * pair.stiffness)

        def margin(since: arb) -> arb:
            state = piece.at(since)
            slip: arb = contact.slip(state) * contact.side
            return slip if not pair.tangential_stiffness else slip.min(slip * spring + limit * state[1])

        if not is_positive(margin, arb(0), until):
            raise NotCertifiedError(f"two-spheres: sliding is proved up to {float(piece.begin):.17g} s of the contact; then it may stick")

    def polar(self, t: arb) -> list[arb]:
        """rho, rho', phi, h, J at t since the phase began."""
        for piece in self.flow.pieces[: self.covered]:
            if t <= piece.begin + piece.length:
                return piece.at(t - piece.begin)
        raise NotCertifiedError(f"two-spheres: the contact is not followed beyond {MANY} steps")

    def closest(self) -> arb:
        """The least distance of the centres [m], where rho' rises through zero."""
        for piece in self.flow.pieces[: self.covered]:
            zero = first_zero(-piece.polynomials[1], arb(0), piece.length)
            if zero is not None:
                return piece.at(zero)[0]
        raise NotCertifiedError("two-spheres: no turn of the overlap is seen")
