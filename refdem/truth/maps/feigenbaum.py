"""Period doubling of the logistic map: first windows, superstable parameters by interval Newton,
Feigenbaum's ratio, accumulation.

A cycle of p iterates through x = 1/2 is superstable: g(eta) = f^p(1/2) - 1/2 = 0. Theorem (interval
Newton): if m - g(m)/g'(E) lies in the interval E, then g has exactly one zero in E, and it lies
there. Ratios of certified gaps tend to Feigenbaum's number (Lanford 1982). The doublings p = 2^k
pile up from below. From above come p = 3 2^k: a map with such a cycle has cycles of every 2^k
(Sharkovskii 1964) and positive entropy, which does not fall as eta rises (Milnor & Thurston 1988;
Douady 1995), so that both sides enclose the point.
"""

from fractions import Fraction

from flint import arb, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision

FOLLOWING = 4.67
"""Where the next superstable parameter is looked for: the last gap over Feigenbaum's ratio."""
TRIPLES = (3.8318740552833156, 3.6275575)
"""About where the superstable cycles of 3 and 6 iterates are."""


def orbit(eta: arb, count: int) -> tuple[arb, arb]:
    """f^count(1/2) - 1/2 and its derivative by eta, both over the whole ball of eta."""
    y = arb(0)
    slope = arb(0)
    half = arb_of(Fraction(1, 2))
    quarter = arb_of(Fraction(1, 4))
    for _ in range(count):
        y, slope = eta * (quarter - y * y) - half, (quarter - y * y) - 2 * eta * y * slope
    return y, slope


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
    """The zero of g beside `near`, between `low` and `high`: plain Newton to come close, interval
    Newton for the proof.
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
        box = middle + arb(0, 1) * width
        closer = middle - orbit(middle, count)[0] / orbit(box, count)[1]
        if (
            closer.is_finite()
            and box.contains_interior(closer)
            and low < closer < high
            and has_period(closer, count)
        ):
            return closer
        width = width / 2**8
    raise NotCertifiedError(
        f"no superstable cycle of {count} iterates is proved near {float(near.mid()):.15g}"
    )


def has_period(eta: arb, count: int) -> bool:
    """The cycle through 1/2, which closes after `count` iterates, does not close after a half or a
    third of them.
    """
    return not any(orbit(eta, count // part)[0].contains(0) for part in (2, 3) if count % part == 0)


def ratios(last: int, bits: int = 256) -> list[arb]:
    """(s_k - s_(k-1))/(s_(k+1) - s_k) for k = 1 .. last: they tend to 4.6692016..."""
    with precision(bits):
        s = [superstable(k, bits) for k in range(last + 2)]
        return [(s[k] - s[k - 1]) / (s[k + 1] - s[k]) for k in range(1, last + 1)]


def accumulation(k: int, bits: int = 256) -> arb:
    """Where the doublings pile up: between the superstable parameters of 2^(k + 2) and of 3 2^k
    iterates.
    """
    with precision(bits):
        return superstable(k + 2, bits).union(tripled(k, bits))


def first_windows(bits: int = 256) -> tuple[arb, arb]:
    """Where the fixed point 1 - 1/eta becomes unstable (slope 2 - eta = -1), and where the 2-cycle
    does (4 + 2 eta - eta^2 = -1).
    """
    with precision(bits):
        return arb(3), 1 + arb(6).sqrt()
