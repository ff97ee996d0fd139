"""One impact of two rigid bodies that are round where they touch: impulses in closed form.

Theorem: let n be the unit normal from the first body to the second, and g the velocity of the first
body's point of contact against that of the second, with the closing speed g.n > 0 and the slip s =
g - (g.n) n. The impulse P = -p n - k s on the first body and -P on the second multiplies the
closing speed by -e and the slip by -b (Walton 1993; Brach 1989); Coulomb's law cuts k |s| at mu p.
A wall is a second body with 1/m2 = 0 and R2 = 0.

Hypotheses, and where each is checked:

* the bodies close, g.n > 0: whoever follows the motion (impact_sequence.py, impacts_in_balls.py);
* whether friction is cut: `Impact.excess`, exactly, of numbers of one field (surds.py).

Formula:

    g = v1 - v2 + (R1 omega1 + R2 omega2) x n,    p = (1 + e) m_n g.n,    k = (1 + b) m_t,

where m_n and m_t are the inverses of those sums by which P changes g,

    P (1/m1 + 1/m2) along n,    P (1/m1 + 1/m2 + R1^2/J1 + R2^2/J2) across n.

The functions are written for any numbers that add and multiply: exact ones, balls, and balls with
derivatives.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from refdem.truth.surds import Number, sign
from refdem.truth.vectors import Vector, cross, dot


@dataclass(frozen=True, kw_only=True)
class RoundBody:
    """Mass m [kg], inertia factor f of J = f m R^2 about every axis, and radius R [m]."""

    mass: Fraction
    inertia_factor: Fraction
    radius: Fraction


@dataclass(frozen=True, kw_only=True)
class ImpactLaw:
    """Normal restitution e, tangential restitution b, and Coulomb's friction mu."""

    restitution: Fraction
    tangential_restitution: Fraction
    friction: Fraction


@dataclass(frozen=True)
class Motion:
    """r, v, omega (3,) of one body, in numbers of any kind."""

    r: Vector
    v: Vector
    omega: Vector

    def numbers(self) -> list[Any]:
        """All nine numbers in their order."""
        return [*self.r, *self.v, *self.omega]

    def after(self, t: Any, gravity: Vector | None = None) -> "Motion":
        """The motion after a flight of t [s]: free, or under uniform gravity (3,) [m/s^2]."""
        place = [r + v * t for r, v in zip(self.r, self.v, strict=True)]
        if gravity is None:
            return Motion(place, self.v, self.omega)
        # r + v t + g t^2/2, and v + g t.
        gained = [t * g for g in gravity]
        fallen = [t * speed / 2 for speed in gained]
        place = [r + depth for r, depth in zip(place, fallen, strict=True)]
        velocity = [v + speed for v, speed in zip(self.v, gained, strict=True)]
        return Motion(place, velocity, self.omega)


@dataclass(frozen=True, kw_only=True)
class Impact:
    """What the impulses depend on, in numbers of one kind.

    The two restitutions of the law stay exact. `normal_factor` is (1 + e) m_n, `stopping` is (1 +
    b) m_t [kg]. `is_smooth`: there is no friction at all. Of each body: `inverse_masses` [1/kg],
    `radii` [m], and `spin_factors` R/J [1/(kg m)].
    """

    restitution: Fraction
    tangential_restitution: Fraction
    normal_factor: Any
    stopping: Any
    friction: Any
    inverse_masses: Vector
    radii: Vector
    spin_factors: Vector
    is_smooth: bool

    def in_numbers(self, kind: Callable[[Any], Any]) -> "Impact":
        """The same in numbers of another kind, each made by `kind`."""
        return Impact(
            restitution=self.restitution,
            tangential_restitution=self.tangential_restitution,
            normal_factor=kind(self.normal_factor),
            stopping=kind(self.stopping),
            friction=kind(self.friction),
            inverse_masses=[kind(x) for x in self.inverse_masses],
            radii=[kind(x) for x in self.radii],
            spin_factors=[kind(x) for x in self.spin_factors],
            is_smooth=self.is_smooth,
        )

    def approach(self, normal: Vector, states: Sequence[Motion]) -> tuple[Any, list[Any]]:
        """The closing speed g.n and the slip s (3,) [m/s] of two bodies, or of one and a wall."""
        relative = list(states[0].v)
        surface = [spin * self.radii[0] for spin in states[0].omega]
        if len(states) == 2:
            other = states[1]
            relative = [first - second for first, second in zip(relative, other.v, strict=True)]
            carried = [spin * self.radii[1] for spin in other.omega]
            surface = [first + second for first, second in zip(surface, carried, strict=True)]
        # g = v1 - v2 + (R1 omega1 + R2 omega2) x n.
        swept = cross(surface, normal)
        contact = [a + b for a, b in zip(relative, swept, strict=True)]
        closing = dot(contact, normal)
        slip = [g - closing * n for g, n in zip(contact, normal, strict=True)]
        return closing, slip

    def excess(self, closing: Number, slip: Sequence[Number]) -> int:
        """The sign of k |s| - mu p, exactly: 1 where friction is cut, 0 where it is just enough, -1
        below that, and where there is no friction to cut.

        Both are >= 0, so that their squares, which need no root, are compared.
        """
        if self.is_smooth:
            return -1
        # (k |s|)^2 - (mu p)^2 with k = (1 + b) m_t, p = (1 + e) m_n g.n.
        needed = dot(slip, slip) * self.stopping**2
        limit = closing * (self.friction * self.normal_factor)
        return sign(needed - limit * limit)

    def normal_impulse(self, closing: Any) -> Any:
        """p = (1 + e) m_n g.n [N s]."""
        return closing * self.normal_factor

    def tangential_factor(self, closing: Any, slip: Vector, *, is_cut: bool) -> Any:
        """k of the tangential impulse -k s [kg]: what stops or reverses the slip, or the limit mu
        p/|s|; 0 without friction.
        """
        if self.is_smooth:
            return self.stopping * 0
        if not is_cut:
            return self.stopping
        # k |s| = mu p
        return self.normal_impulse(closing) * self.friction / length(slip)

    def parted(self, normal: Vector, states: Sequence[Motion], *, is_cut: bool) -> list[Motion]:
        """The states right after the impulse P = -p n - k s.

        v1 += P/m1, v2 -= P/m2, and both spins turn by (R/J) n x P: the levers R1 n and -R2 n and
        the impulses P and -P have products of one sign.
        """
        closing, slip = self.approach(normal, states)
        p = self.normal_impulse(closing)
        k = self.tangential_factor(closing, slip, is_cut=is_cut)
        # P = -p n - k s; each omega changes by (R/J) n x P.
        impulse = [-(n * p) - s * k for n, s in zip(normal, slip, strict=True)]
        moment = cross(normal, impulse)
        signs = (1, -1)
        parted_states = []
        for number, state in enumerate(states):
            inverse_mass = self.inverse_masses[number] * signs[number]
            spin_factor = self.spin_factors[number]
            velocity = [v + x * inverse_mass for v, x in zip(state.v, impulse, strict=True)]
            omega = [w + x * spin_factor for w, x in zip(state.omega, moment, strict=True)]
            parted_states.append(Motion(state.r, velocity, omega))
        return parted_states


def impact_of(bodies: Sequence[RoundBody], law: ImpactLaw) -> Impact:
    """The impact of two bodies, or of one on a wall, in exact numbers."""
    # 1/m_n = 1/m1 + 1/m2, and 1/m_t = 1/m_n + R1^2/J1 + R2^2/J2, where R^2/J = 1/(f m).
    inverse_masses = [1 / body.mass for body in bodies]
    turning = [1 / (body.inertia_factor * body.mass) for body in bodies]
    normal_mass = 1 / sum(inverse_masses, Fraction(0))
    tangential_mass = 1 / sum([*inverse_masses, *turning], Fraction(0))
    # Impulses (1 + e) m_n g.n and (1 + b) m_t s: the closing speed becomes -e g.n, the slip -b s.
    normal_factor = (1 + law.restitution) * normal_mass
    stopping = (1 + law.tangential_restitution) * tangential_mass
    # R/J = 1/(f m R).
    spin_factors = [1 / (body.inertia_factor * body.mass * body.radius) for body in bodies]
    return Impact(
        restitution=law.restitution,
        tangential_restitution=law.tangential_restitution,
        normal_factor=normal_factor,
        stopping=stopping,
        friction=law.friction,
        inverse_masses=inverse_masses,
        radii=[body.radius for body in bodies],
        spin_factors=spin_factors,
        is_smooth=law.friction == 0,
    )


def length(a: Vector) -> Any:
    """The length of a vector (3,) in balls; an exact vector must lie along one of the axes."""
    if not isinstance(a[0], Number):
        return dot(a, a).sqrt()
    absolute_values = [x * sign(x) for x in a if sign(x) != 0]
    if len(absolute_values) != 1:
        raise TypeError("an exact length asks for a vector along one of the axes")
    return absolute_values[0]
