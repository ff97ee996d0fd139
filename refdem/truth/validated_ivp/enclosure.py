"""Where solutions exist on a complex disc about a Taylor polynomial T of one of them, and how far
from it they are (Cauchy, Gronwall).

|x| is the largest |x_i|/w_i for weights w > 0 in which the field moves all coordinates about alike;
|J| is the matrix norm to it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import frexp
from operator import mul

from flint import acb, arb, arb_poly

from refdem.truth.balls import arb_of, largest, outward, precision
from refdem.truth.traced_field import Program
from refdem.truth.weights import REACH, quickest, typical, weighted

BITS = 64
JACOBIAN_BITS = 40
"""Of boxes, which bound and need not be sharp; of the flow Jacobian of a step, far below its own
share in the error.
"""
FACTORS = 2.0, 1 / 2, 1.25, 1 / 1.25, 1.08, 1 / 1.08
"""By which the outer radius is changed as long as that lengthens the step."""
RINGS = 8
"""Between the step and nearly the outer radius, on each of which |J| is bounded."""
ROOM = arb(2) ** -20
"""About the polynomial, in parts of its motion: more than thin sets need."""


def geometric(ratio: arb, order: int) -> arb:
    """sum over n >= order of ratio^n, for 0 <= ratio < 1."""
    return ratio**order / (1 - ratio)


@dataclass(frozen=True)
class Disc:
    """|f(T(z))| <= speed for |z| <= outer, T of degree `order`; the solutions from all starts are
    analytic for |z| <= radius.

    `rings` has radii and, for each, a bound L of |J| on the solutions from the radius before it;
    `step` is what the order allows.
    """

    order: int
    weights: list[arb]
    outer: arb
    speed: arb
    step: Fraction
    rings: list[tuple[arb, arb]]

    @property
    def radius(self) -> arb:
        """The exact radius R of the disc."""
        return self.rings[-1][0]

    def sides(self, size: arb) -> list[arb]:
        """Bounds of every coordinate of what has at most that norm."""
        return [outward(weight * size) for weight in self.weights]

    def gronwall(self, since: arb) -> arb:
        """Bound of |V(z)|, V the flow Jacobian, and of the growth of a distance, for |z| = since:
        exp(integral of L); nan beyond R.
        """
        exponent = arb(0 if since <= self.radius else "nan")
        inner = arb(0)
        for radius, stiffness in self.rings:
            if inner < since:
                exponent += stiffness * (min(radius, since) - inner)
            inner = radius
        return exponent.exp()

    def apart(self, since: arb, start: arb) -> arb:
        """Bound of |y(z) - T(z)|, |z| = since <= R, for every solution with |y(0) - T(0)| <= start.

        Theorem (defect): T' and f(T) have the same coefficients below N, T' has no others, and
        those of f(T) are at most M S^-n where
        |f(T)| <= M on |z| <= S (Cauchy). So |T' - f(T)| <= M q^N/(1 - q), q = |z|/S, whose integral
        from 0 to |z| = s is at most s M q^N/((1 - q)(N + 1)). Theorem (Gronwall): e = y - T has
        |e|' <= L |e| + |T' - f(T)| along a ray.
        """
        defect = since * self.speed * geometric(since / self.outer, self.order) / (self.order + 1)
        return outward(self.gronwall(since) * (start + defect))

    def jacobian_remainder(self, since: arb, order: int) -> arb:
        """Bound of |V(z) - sum_(n <= order) V_n z^n|, |z| = since < R: |V_n| <= exp(integral of L)
        R^-n (Gronwall, Cauchy).
        """
        return outward(self.gronwall(self.radius) * geometric(since / self.radius, order + 1))

    def jacobian_order(self, bits: int) -> int:
        """The order at which that remainder over the step is at most about 2^-bits."""
        halvings = (self.gronwall(self.radius).log() / arb(2).log() + bits) / (
            self.radius / arb_of(self.step)
        ).log()
        return int(float(halvings * arb(2).log())) + 1


class Tube:
    """Boxes about a polynomial on discs about 0."""

    def __init__(self, polynomials: Sequence[arb_poly]) -> None:
        self.centre = [acb(one[0]) for one in polynomials]
        self.sizes = [arb_poly([0, *(outward(c) for c in one.coeffs()[1:])]) for one in polynomials]

    def box(self, radius: arb, room: Sequence[arb] = ()) -> list[acb]:
        """All within `room` of T(z), |z| <= radius: squares in the complex plane."""
        halves = [
            outward(size(radius) + (room[i] if room else 0)) for i, size in enumerate(self.sizes)
        ]
        return [
            value + acb(arb(0, half), arb(0, half))
            for value, half in zip(self.centre, halves, strict=True)
        ]


def norm(values: Sequence[arb | acb], weights: Sequence[arb]) -> arb:
    """Bound of the norm of a vector; not finite if one of its values is not."""
    return largest([value / weight for value, weight in zip(values, weights, strict=True)])


def matrix_norm(entries: Sequence[arb | acb], weights: Sequence[arb]) -> arb:
    """Bound of |J| for a matrix whose rows come one after another: the norm of the bounds of
    |J| w.
    """
    count = len(weights)
    sizes = [outward(entry) for entry in entries]
    return norm(
        [sum(map(mul, sizes[i : i + count], weights), arb(0)) for i in range(0, len(sizes), count)],
        weights,
    )


def disc(
    field: Program,
    jacobian: Program,
    polynomials: Sequence[arb_poly],
    order: int,
    radii: Sequence[arb],
    *,
    least: Sequence[arb],
    ratio: float,
    first: float,
) -> Disc | None:
    """The disc for the longest step at this order, searched from an outer radius `first` [s] on;
    None if none is proved.

    `radii` bound the set of starts, and weights are at least `least`. The step is `ratio` of the
    outer radius, and shorter by what the speed there would cost in bits.
    """
    with precision(BITS):
        tube = Tube(polynomials)
        here = tube.box(arb(0))
        rates = field.run(here)
        start = jacobian.run(here)
        nearby = typical(
            lambda radius: jacobian.run(tube.box(arb(radius))),
            min(first, REACH / quickest(start)) / 3,
        )
        weights = weighted(rates, nearby or start, 1 / first, least)
        slow = norm(rates, weights)
        stiff = matrix_norm(start, weights)
        slowest = (stiff + 1 / arb(first)) / 2**40

        def speed(radius: float) -> arb:
            return norm(field.run(tube.box(arb(radius))), weights)

        def step(radius: float) -> float:
            quick = speed(radius)
            reaches = quick.is_finite() and stiff * radius < REACH
            if not reaches:
                return 0.0
            part = float((slow + slowest) / (quick + slowest))
            found: float = ratio * radius * part ** (1.0 / order)
            return found

        outer = highest(step, first)
        mantissa, exponent = frexp(step(outer))
        short = Fraction(int(mantissa * 256), 256) * Fraction(2) ** exponent
        begun = Disc(order, weights, arb(outer), speed(outer), short, [])
        if short:
            return grown(begun, jacobian, tube, norm(radii, weights), stiff)
        return None


def highest(value: Callable[[float], float], first: float) -> float:
    """About where a function that rises and then falls has its maximum."""
    best = first
    reached = value(first)
    while reached == 0.0 and best > first / 2**100:
        best, reached = best / 2, value(best / 2)
    for factor in FACTORS:
        while (now := value(best * factor)) > reached and best < first * 2**20:
            best = best * factor
            reached = now
    return best


def grown(found: Disc, jacobian: Program, tube: Tube, start: arb, stiff: arb) -> Disc | None:
    """The disc with the rings that make the series of the flow Jacobian shortest; None if the step
    is not inside any that is proved.

    Theorem (existence): let |J| <= L where within `margin` of T(z), |z| <= s, and apart(s) <=
    margin. Then the solutions from all starts exist and stay there for |z| <= s: along a ray none
    can be the first to leave.
    """
    best = None
    step = float(found.step)
    wide = float(found.outer) * 0.95
    for k in range(-1, RINGS + 1):
        radius = arb(step / 2 if k < 0 else step * (wide / step) ** (k / RINGS))
        guess = replace(found, rings=[*found.rings, (radius, stiff)])
        margin = 4 * guess.apart(radius, start) + ROOM * norm(
            [size(radius) for size in tube.sizes], found.weights
        )
        stiff = matrix_norm(jacobian.run(tube.box(radius, found.sides(margin))), found.weights)
        found = replace(found, rings=[*found.rings, (radius, stiff)])
        if not found.apart(radius, start) <= margin:
            break
        if k > 0:
            if best is not None and found.jacobian_order(JACOBIAN_BITS) > best.jacobian_order(
                JACOBIAN_BITS
            ):
                break
            best = found
    return best
