"""Witness of Koenig's theorem: energy and angular momentum about the centre of mass as sums over
pairs of points, without the centre of mass.

With the total mass M, centre R, its velocity V, momentum P = M V, and sums over all pairs i < j:

    sum m |v - V|^2/2            = sum m_i m_j |v_i - v_j|^2/(2 M)
    sum m (r - R) x (v - V)      = sum m_i m_j (r_i - r_j) x (v_i - v_j)/M
    M V^2/2 = P^2/(2 M),         M R x V = (sum m r) x P/M
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any

from refdem.core.parameters import Exact
from refdem.truth.exact import vector
from refdem.truth.witnesses.turns import hamilton

Point = Sequence[Fraction]
ZERO = Fraction(0)


def of_points(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """The rows of the theorem, and those of the energy of a turn, by name."""
    masses = vector(p, "masses")
    places = _triples(vector(p, "places"))
    velocities = _triples(vector(p, "velocities"))
    omega = vector(p, "omega")
    total = sum(masses, ZERO)
    momentum = _weighted(masses, velocities)
    # M V^2/2 = P^2/(2 M)
    of_centre = _dot(momentum, momentum) / (2 * total)
    about_centre = ZERO
    # M R x V = (sum m r) x P/M
    lever = _cross(_weighted(masses, places), momentum)
    momentum_of_centre = [x / total for x in lever]
    momentum_about_centre = [ZERO] * 3
    for i, j in combinations(range(len(masses)), 2):
        # mu |v_i - v_j|^2/2 and mu (r_i - r_j) x (v_i - v_j), with mu = m_i m_j/M.
        reduced = masses[i] * masses[j] / total
        apart = _less(places[i], places[j])
        parting = _less(velocities[i], velocities[j])
        about_centre += reduced * _dot(parting, parting) / 2
        turned = [reduced * x for x in _cross(apart, parting)]
        momentum_about_centre = _plus(momentum_about_centre, turned)
    energy = of_centre + about_centre
    angular_momentum = _plus(momentum_of_centre, momentum_about_centre)
    turning = _turning(masses, places, omega)
    return {
        "points-energy": [energy],
        "centre-energy": [of_centre],
        "energy-about-centre": [about_centre],
        "koenig-energy": [energy],
        "points-momentum": angular_momentum,
        "centre-momentum": momentum_of_centre,
        "momentum-about-centre": momentum_about_centre,
        "koenig-momentum": angular_momentum,
        "swept-energy": [turning],
        "tensor-energy": [turning],
    }


def _turning(masses: Point, places: Sequence[Point], omega: Point) -> Fraction:
    """The energy sum m (omega^2 r^2 - (omega . r)^2)/2 of points that turn, by Lagrange's
    identity.
    """
    twice = ZERO
    for m, r in zip(masses, places, strict=True):
        twice += m * (_dot(omega, omega) * _dot(r, r) - _dot(omega, r) ** 2)
    return twice / 2


def _triples(entries: Point) -> list[Point]:
    """A flat list of numbers as vectors of three."""
    return [entries[k : k + 3] for k in range(0, len(entries), 3)]


def _weighted(masses: Point, vectors: Sequence[Point]) -> list[Fraction]:
    """The sum of m v over the vectors v with their masses m."""
    pairs = list(zip(masses, vectors, strict=True))
    return [sum((m * v[i] for m, v in pairs), ZERO) for i in range(3)]


def _dot(v: Point, w: Point) -> Fraction:
    """The scalar product of two vectors."""
    return sum((x * y for x, y in zip(v, w, strict=True)), ZERO)


def _cross(v: Point, w: Point) -> list[Fraction]:
    """The vector product of two vectors, the pure part of a product of quaternions."""
    return hamilton([ZERO, *v], [ZERO, *w])[1:]


def _plus(v: Point, w: Point) -> list[Fraction]:
    """The sum v + w, component by component."""
    return [x + y for x, y in zip(v, w, strict=True)]


def _less(v: Point, w: Point) -> list[Fraction]:
    """The difference v - w of two vectors."""
    return [x - y for x, y in zip(v, w, strict=True)]
