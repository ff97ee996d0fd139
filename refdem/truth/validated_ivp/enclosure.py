"""Where solutions exist on a complex disc about a Taylor polynomial T of one of them, and how far
from it they are (Cauchy, Gronwall).

Norms, for weights w > 0 in which all coordinates change about equally fast along the field:

    |x| = max_i |x_i|/w_i,    |J| = max_i (sum_j |J_ij| w_j)/w_i.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import frexp
from operator import mul

from flint import acb, arb, arb_poly

from refdem.truth.balls import arb_of, largest, outward, precision
from refdem.truth.traced_field import Program
from refdem.truth.weights import MAX_DISC_EXPONENT, quickest, typical, weighted

BITS = 64
"""The working precision of boxes, which bound and need not be sharp."""
JACOBIAN_BITS = 40
"""The bits to which the flow Jacobian of a step is enclosed. It multiplies the radii of the set
only, so that more bits would hardly make the set smaller.
"""
FACTORS = 2.0, 1 / 2, 1.25, 1 / 1.25, 1.08, 1 / 1.08
"""The factors by which the outer radius is multiplied as long as the step becomes longer."""
RINGS = 8
"""The number of rings between the step and nearly the outer radius, on each of which |J| is
bounded.
"""
MIN_RELATIVE_MARGIN = arb(2) ** -20
"""The least margin about the polynomial T, as a part of the norm of |T(z) - T(0)|: more than sets
of small radius need.
"""


def geometric(ratio: arb, order: int) -> arb:
    """The tail ratio^order/(1 - ratio) of the geometric series: the sum of ratio^n over n >= order,
    for 0 <= ratio < 1.
    """
    return ratio**order / (1 - ratio)


@dataclass(frozen=True)
class Disc:
    """A complex disc |z| <= radius of times on which the solutions from all starts are proved to
    exist and to be analytic.

    T is the Taylor polynomial, of degree `order`, of one of them. |f(T(z))| <= `speed` for |z| <=
    `outer`, in the norm of `weights`. `rings` has radii in rising order and, for each, a bound L of
    |J| on the solutions between the radius before it and itself. `step` is the length [s] of the
    piece that the order allows.
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
        """A bound of each coordinate of a vector whose norm is at most `size`."""
        return [outward(weight * size) for weight in self.weights]

    def gronwall(self, since: arb) -> arb:
        """Bound exp(integral of L from 0 to s) of |V(z)|, V the flow Jacobian, and of the growth of
        a distance, for |z| = s (`since`); nan beyond the radius.
        """
        # Integral of L from 0 to s, with L_k on the ring between R_(k-1) and R_k, R_0 = 0: the sum
        # of L_k (min(R_k, s) - R_(k-1)) over the rings that begin before s.
        if since <= self.radius:
            exponent = arb(0)
        else:
            exponent = arb("nan")
        inner = arb(0)
        for radius, stiffness in self.rings:
            if inner < since:
                exponent += stiffness * (min(radius, since) - inner)
            inner = radius
        return exponent.exp()

    def apart(self, since: arb, start: arb) -> arb:
        """Bound of |y(z) - T(z)|, |z| = since <= R, for every solution with |y(0) - T(0)| <= start.

        Theorem (defect): T' and f(T) have the same coefficients below N, T' has no others, and
        those of f(T) are at most M S^-n where |f(T)| <= M on |z| <= S (Cauchy). So |T' - f(T)| <= M
        q^N/(1 - q), q = |z|/S, whose integral from 0 to |z| = s is at most s M q^N/((1 - q)(N +
        1)). Theorem (Gronwall): e = y - T has |e|' <= L |e| + |T' - f(T)| along a ray.

        Here N is `order`, S `outer`, M `speed`, s `since`.
        """
        # defect = s M q^N/((1 - q)(N + 1)), q = s/S, and by Gronwall's inequality
        # |y - T| <= exp(integral of L from 0 to s) (|y(0) - T(0)| + defect).
        defect = since * self.speed * geometric(since / self.outer, self.order) / (self.order + 1)
        return outward(self.gronwall(since) * (start + defect))

    def jacobian_remainder(self, since: arb, order: int) -> arb:
        """Bound of |V(z) - sum_(n <= order) V_n z^n| for |z| = since < R.

        |V_n| <= exp(integral of L from 0 to R) R^-n (Gronwall, Cauchy).
        """
        # Sum over n > order: exp(integral of L) q^(order + 1)/(1 - q), q = |z|/R.
        return outward(self.gronwall(self.radius) * geometric(since / self.radius, order + 1))

    def jacobian_order(self, bits: int) -> int:
        """The order n at which that remainder over the step h is at most about 2^-bits:
        exp(integral of L) (h/R)^n <= 2^-bits.
        """
        needed_bits = self.gronwall(self.radius).log() / arb(2).log() + bits
        # n >= (integral of L + bits ln 2)/ln(R/h); the bits are the numerator over ln 2.
        order = needed_bits / (self.radius / arb_of(self.step)).log()
        return int(float(order * arb(2).log())) + 1


class Tube:
    """Boxes about a polynomial T on discs about 0, one number of T for each coordinate.

    |T_i(z) - T_i(0)| <= sum over n >= 1 of |c_n| |z|^n: `sizes` has that polynomial of |z|.
    """

    def __init__(self, polynomials: Sequence[arb_poly]) -> None:
        self.centre = [acb(one[0]) for one in polynomials]
        self.sizes = [arb_poly([0, *(outward(c) for c in one.coeffs()[1:])]) for one in polynomials]

    def box(self, radius: arb, margin: Sequence[arb] = ()) -> list[acb]:
        """A box of squares in the complex plane that holds all points within `margin` (one number a
        coordinate; none: 0) of T(z) for some |z| <= radius.
        """
        halves = [
            outward(size(radius) + (margin[i] if margin else 0))
            for i, size in enumerate(self.sizes)
        ]
        return [
            value + acb(arb(0, half), arb(0, half))
            for value, half in zip(self.centre, halves, strict=True)
        ]


def norm(values: Sequence[arb | acb], weights: Sequence[arb]) -> arb:
    """Bound of the norm of a vector; not finite if one of its values is not."""
    return largest([value / weight for value, weight in zip(values, weights, strict=True)])


def matrix_norm(entries: Sequence[arb | acb], weights: Sequence[arb]) -> arb:
    """Bound of |J| for a matrix whose rows come one after another: max_i (sum_j |J_ij| w_j)/w_i."""
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
    """The disc for the longest step at this order; None if none is proved.

    The search for the outer radius S begins at `first` [s]. `polynomials` are the Taylor
    polynomials T of one solution, `radii` bound the set of starts about it, and weights are at
    least `least`. The step is h = `ratio` S (M_0/M)^(1/N), with the order N and bounds M of |f(T)|
    on |z| <= S and M_0 of |f(T(0))|: the remainder M (h/S)^N is then `ratio`^N M_0. All choices
    made here only make steps long; the proof is in `grown`.
    """
    with precision(BITS):
        tube = Tube(polynomials)
        here = tube.box(arb(0))
        rates = field.run(here)
        start = jacobian.run(here)
        weights = chosen_weights(jacobian, tube, rates, start, first=first, least=least)
        speed_here = norm(rates, weights)
        stiff = matrix_norm(start, weights)
        # Keeps the ratio of speeds from 0/0 where the motion rests.
        least_speed = (stiff + 1 / arb(first)) / 2**40

        def speed(radius: float) -> arb:
            return norm(field.run(tube.box(arb(radius))), weights)

        def step(radius: float) -> float:
            """The step h = `ratio` S (M_0/M)^(1/N) for the outer radius S; 0 where no disc can be
            proved.
            """
            speed_there = speed(radius)
            is_usable = speed_there.is_finite() and stiff * radius < MAX_DISC_EXPONENT
            if not is_usable:
                return 0.0
            speed_ratio = float((speed_here + least_speed) / (speed_there + least_speed))
            length: float = ratio * radius * speed_ratio ** (1.0 / order)
            return length

        outer = highest(step, first)
        # h is rounded down to 8 bits.
        mantissa, exponent = frexp(step(outer))
        short = Fraction(int(mantissa * 256), 256) * Fraction(2) ** exponent
        begun = Disc(order, weights, arb(outer), speed(outer), short, [])
        if short:
            return grown(begun, jacobian, tube, norm(radii, weights), stiff)
        return None


def chosen_weights(
    jacobian: Program,
    tube: Tube,
    rates: Sequence[acb],
    start: Sequence[acb],
    *,
    first: float,
    least: Sequence[arb],
) -> list[arb]:
    """The weights of the norm in which a disc is proved, from f (`rates`) and J (`start`) at T(0).

    An entry of J may be 0 at T(0) and not near it: so J is bounded on a disc about T(0)
    (`typical`), if it is small enough on one. Other arguments are those of `disc`.
    """
    radius = min(first, MAX_DISC_EXPONENT / quickest(start)) / 3
    nearby = typical(lambda radius: jacobian.run(tube.box(arb(radius))), radius)
    return weighted(rates, nearby or start, 1 / first, least)


def highest(value: Callable[[float], float], first: float) -> float:
    """The argument, about, at which a function that rises and then falls has its maximum.

    `first` is halved until the function is not 0 there, and then changed by FACTORS as long as the
    function grows.
    """
    best = first
    reached = value(first)
    while reached == 0.0 and best > first / 2**100:
        best, reached = best / 2, value(best / 2)
    for factor in FACTORS:
        while (now := value(best * factor)) > reached and best < first * 2**20:
            best = best * factor
            reached = now
    return best


def grown(candidate: Disc, jacobian: Program, tube: Tube, start: arb, stiff: arb) -> Disc | None:
    """The disc with the rings that make the series of the flow Jacobian shortest; None if the step
    is not inside any that is proved.

    `candidate` is a disc without rings, `start` the norm of the set about T(0), `stiff` a guess of
    |J|.

    Theorem (existence): let |J| <= L at all points within `margin` of T(z), |z| <= s, and let
    apart(s) <= margin. Then the solutions from all starts exist and stay within `margin` of T(z)
    for |z| <= s: along a ray, no solution can be the first to leave this neighbourhood.
    """
    best = None
    step = float(candidate.step)
    widest = float(candidate.outer) * 0.95
    # Rings at half the step and at the step, then in equal ratios up to nearly the outer radius.
    radii = [step / 2] + [step * (widest / step) ** (k / RINGS) for k in range(RINGS + 1)]
    for number, ring in enumerate(radii):
        radius = arb(ring)
        # margin = 4 apart(s) + MIN_RELATIVE_MARGIN |T(z) - T(0)|, with the bound of |J| from the
        # ring before in apart(s). The theorem is then checked with |J| within that margin.
        guess = replace(candidate, rings=[*candidate.rings, (radius, stiff)])
        motion = norm([size(radius) for size in tube.sizes], candidate.weights)
        margin = 4 * guess.apart(radius, start) + MIN_RELATIVE_MARGIN * motion
        stiff = matrix_norm(
            jacobian.run(tube.box(radius, candidate.sides(margin))), candidate.weights
        )
        candidate = replace(candidate, rings=[*candidate.rings, (radius, stiff)])
        if not candidate.apart(radius, start) <= margin:
            break
        if number > 1:
            # The disc holds the step. A wider disc is taken while the series of the flow Jacobian
            # needs no more terms on it.
            if best is not None:
                order = candidate.jacobian_order(JACOBIAN_BITS)
                if order > best.jacobian_order(JACOBIAN_BITS):
                    break
            best = candidate
    return best
