"""Koenig's theorem in rational numbers: kinetic energy and angular momentum of moving points, of
their centre of mass, and about it; and the energy of the same points in a rotation.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.truth.balls import arb_of
from refdem.truth.exact import vector

Exacts = Sequence[Fraction]


def values(p: Parameters) -> dict[str, list[arb]]:
    """The rows of the theorem, by name."""
    return {name: [arb_of(x) for x in row] for name, row in exact_values(p).items()}


def exact_values(p: Parameters) -> dict[str, list[Fraction]]:
    """The same rows as exact fractions.

    The parts of the centre are M V^2/2 and M R x V; those about it are the sums over the points in
    coordinates whose origin is the centre.
    """
    masses = vector(p, "masses")
    places = points(p, "places")
    velocities = points(p, "velocities")
    omega = vector(p, "omega")
    # R = sum m r/M, V = sum m v/M; about the centre r - R and v - V; in the rotation omega x r.
    total = sum(masses, Fraction(0))
    centre = mean(masses, places)
    drift = mean(masses, velocities)
    arms = [less(r, centre) for r in places]
    inner = [less(v, drift) for v in velocities]
    swept = [cross(omega, r) for r in places]
    energy_of_all = energy(masses, velocities)
    momentum_of_all = momentum(masses, places, velocities)
    turning = energy(masses, swept)
    return {
        "points-energy": [energy_of_all],
        "centre-energy": [energy([total], [drift])],
        "energy-about-centre": [energy(masses, inner)],
        # E = M V^2/2 + E about the centre: the sum equals the energy of the points.
        "koenig-energy": [energy_of_all],
        "points-momentum": momentum_of_all,
        "centre-momentum": momentum([total], [centre], [drift]),
        "momentum-about-centre": momentum(masses, arms, inner),
        # L = M R x V + L about the centre.
        "koenig-momentum": momentum_of_all,
        "swept-energy": [turning],
        # omega . J omega/2 = sum m (omega x r)^2/2.
        "tensor-energy": [turning],
    }


def points(p: Parameters, name: str) -> list[Exacts]:
    """A parameter of three numbers a point as a list of vectors."""
    entries = vector(p, name)
    return [entries[k : k + 3] for k in range(0, len(entries), 3)]


def mean(masses: Exacts, vectors: Sequence[Exacts]) -> Exacts:
    """The mean of vectors with the masses as weights."""
    total = sum(masses, Fraction(0))
    weighted = [[m * x for x in v] for m, v in zip(masses, vectors, strict=True)]
    return [sum(components, Fraction(0)) / total for components in zip(*weighted, strict=True)]


def less(v: Exacts, w: Exacts) -> Exacts:
    """The difference v - w of two vectors."""
    return [x - y for x, y in zip(v, w, strict=True)]


def cross(v: Exacts, w: Exacts) -> list[Fraction]:
    """The vector product v x w of two vectors."""
    a, b, c = v
    x, y, z = w
    return [b * z - c * y, c * x - a * z, a * y - b * x]


def energy(masses: Exacts, velocities: Sequence[Exacts]) -> Fraction:
    """The kinetic energy sum m v^2/2 of points."""
    pairs = zip(masses, velocities, strict=True)
    return sum((m * sum(x * x for x in v) for m, v in pairs), Fraction(0)) / 2


def momentum(
    masses: Exacts, places: Sequence[Exacts], velocities: Sequence[Exacts]
) -> list[Fraction]:
    """The angular momentum sum m r x v of points about the origin."""
    moving = zip(masses, places, velocities, strict=True)
    of_each = [[m * x for x in cross(r, v)] for m, r, v in moving]
    return [sum(components, Fraction(0)) for components in zip(*of_each, strict=True)]
