"""The cosine of a multiple of an angle from the sine and cosine of the angle, and the product of
two cosines. They describe the higher harmonics of a nonlinear oscillator and its mixing of
frequencies (chapter 1, sections 1.5.3 and 1.5.5).
"""

import math


def cosine_by_recurrence(angle: float, multiple: int) -> float:
    """cos(n angle), for `angle` [rad] and n = `multiple` >= 0, by the recurrence cos((k + 1) angle)
    = 2 cos(angle) cos(k angle) - cos((k - 1) angle).
    """
    cosine = math.cos(angle)
    # cos(k angle) and cos((k - 1) angle), from k = 0 on.
    current = 1.0
    previous = cosine
    # cos((k + 1) a) = 2 cos(a) cos(k a) - cos((k - 1) a).
    for _ in range(multiple):
        current, previous = 2 * cosine * current - previous, current
    return current


def cosine_by_powers(angle: float, multiple: int) -> float:
    """cos(n angle), for `angle` [rad] and n = `multiple` >= 0, as the real part of (cos + i sin)^n:
    the sum over k of (-1)^k binomial(n, 2 k) sin^(2 k) cos^(n - 2 k).
    """
    sine = math.sin(angle)
    cosine = math.cos(angle)
    terms = []
    for k in range(multiple // 2 + 1):
        binomial = math.comb(multiple, 2 * k)
        terms.append((-1) ** k * binomial * sine ** (2 * k) * cosine ** (multiple - 2 * k))
    return math.fsum(terms)


def cosine_product(a: float, b: float) -> float:
    """The product cos(a) cos(b) for angles [rad], a term of (cos(a) + cos(b))^2."""
    return math.cos(a) * math.cos(b)


def cosines_mixed(a: float, b: float) -> float:
    """The product cos(a) cos(b) as (cos(a - b) + cos(a + b))/2: spectral lines at the difference
    and the sum of two frequencies.
    """
    return (math.cos(a - b) + math.cos(a + b)) / 2
