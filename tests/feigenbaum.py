"""Period doubling of the logistic map f(x) = eta x (1 - x): first windows, superstable parameters
by interval Newton, Feigenbaum's ratio, accumulation.

A cycle of p iterates through x = 1/2 is superstable: g(eta) = f^p(1/2) - 1/2 = 0.

Theorem (interval Newton): if m - g(m)/g'(E) lies in the interval E, then g has exactly one zero in
E, and it lies there. `only_zero` checks it, and `has_period` that the cycle has no shorter period.

Ratios of certified gaps tend to Feigenbaum's number (Lanford 1982).

Accumulation. The doublings p = 2^k pile up from below. From above come p = 3 2^k: a map with such a
cycle has cycles of every 2^k (Sharkovskii 1964) and positive entropy, which does not fall as eta
rises (Milnor & Thurston 1988; Douady 1995), so that both sides enclose the point.
"""

from fractions import Fraction

from flint import arb, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision

FOLLOWING = 4.67
"""About Feigenbaum's ratio: Newton's method starts at the last parameter plus the last gap over it.
"""
TRIPLES = (3.8318740552833156, 3.6275575)
"""Starting values of the superstable parameters of 3 and 6 iterates."""


def orbit(eta: arb, count: int) -> tuple[arb, arb]:
    """g(eta) = f^count(1/2) - 1/2 and its derivative by eta, over the whole ball of eta.

    In y = x - 1/2 the map is y -> eta (1/4 - y^2) - 1/2, and dy/deta -> 1/4 - y^2 - 2 eta y
    dy/deta.
    """
    y = arb(0)
    y_slope = arb(0)
    half = arb_of(Fraction(1, 2))
    quarter = arb_of(Fraction(1, 4))
    for _ in range(count):
        next_y = eta * (quarter - y * y) - half
        y_slope = (quarter - y * y) - 2 * eta * y * y_slope
        y = next_y
    return y, y_slope


def superstable(k: int, bits: int = 256) -> arb:
    """The parameter of the superstable cycle of 2^k iterates; k = 0, 1 are 2 and 1 + sqrt 5."""
    with precision(bits):
        known = [arb(2), 1 + arb(5).sqrt()]
        while len(known) <= k:
            near = known[-1] + (known[-1] - known[-2]) / arb(FOLLOWING)
            known.append(only_zero(near, 2 ** len(known), known[-1], arb(4)))
        return known[k]


def tripled(k: int, bits: int = 256) -> arb:
    """The parameter of a superstable cycle of 3 2^k iterates, each below the one before."""
    with precision(bits):
        known = [only_zero(arb(near), 3 * 2**i, arb(3), arb(4)) for i, near in enumerate(TRIPLES)]
        while len(known) <= k:
            near = known[-1] + (known[-1] - known[-2]) / arb(FOLLOWING)
            known.append(only_zero(near, 3 * 2 ** len(known), arb(3), known[-1]))
        return known[k]


def only_zero(near: arb, count: int, low: arb, high: arb) -> arb:
    """The zero of g near `near`, proved the only one in a ball, between `low` and `high`.

    Newton's method in floating point comes close, which proves nothing; interval Newton on boxes
    that become narrower proves it. Raises NotCertifiedError if it does not on any of them.
    """
    middle = near.mid()
    for _ in range(60):
        value, slope = orbit(middle, count)
        step = (value / slope).mid()
        middle = (middle - step).mid()
        if abs(step) < arb(2) ** -ctx.prec * count**3:
            break
    width = arb(2) ** (-ctx.prec // 2)
    for _ in range(8):
        # N = m - g(m)/g'(E)
        box = middle + arb(0, 1) * width
        value, _ = orbit(middle, count)
        _, slope = orbit(box, count)
        image = middle - value / slope
        is_proved = image.is_finite() and box.contains_interior(image)
        if is_proved and low < image < high and has_period(image, count):
            return image
        width = width / 2**8
    raise NotCertifiedError(
        f"no superstable cycle of {count} iterates is proved near {float(near.mid()):.15g}"
    )


def has_period(eta: arb, count: int) -> bool:
    """True if the cycle through 1/2, which closes after `count` iterates, has no shorter period.

    A period divides `count`, whose prime factors are 2 and 3: a shorter one would divide a half or
    a third of it.
    """
    for factor in (2, 3):
        if count % factor == 0 and orbit(eta, count // factor)[0].contains(0):
            return False
    return True


def ratios(last: int, bits: int = 256) -> list[arb]:
    """The ratios (s_k - s_(k-1))/(s_(k+1) - s_k) of gaps for k = 1 .. last.

    s_k is the superstable parameter of 2^k iterates; they tend to Feigenbaum's number 4.6692016...
    """
    with precision(bits):
        s = [superstable(k, bits) for k in range(last + 2)]
        return [(s[k] - s[k - 1]) / (s[k + 1] - s[k]) for k in range(1, last + 1)]


def accumulation(k: int, bits: int = 256) -> arb:
    """A ball of the parameter at which the doublings accumulate.

    It lies between the superstable parameters of 2^(k + 2) and of 3 2^k iterates.
    """
    with precision(bits):
        return superstable(k + 2, bits).union(tripled(k, bits))


def first_windows(bits: int = 256) -> tuple[arb, arb]:
    """The parameters at which the fixed point 1 - 1/eta becomes unstable, and the 2-cycle.

    There the slope is -1: 2 - eta of the fixed point, 4 + 2 eta - eta^2 of the 2-cycle.
    """
    with precision(bits):
        return arb(3), 1 + arb(6).sqrt()
