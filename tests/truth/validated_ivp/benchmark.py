"""What blocked products and larger discs save: CPU seconds of the free rigid body at 300 bits,
beside the naive recurrence.

    python -m tests.truth.validated_ivp.benchmark [t]

Naive: every coefficient of a product from all earlier ones, one by one, and steps of R/8, R being
what Picard's iteration proves from the start alone: the largest b/|f| on the complex box of
half-width b. Both runs alternate; medians of three; t = 100 s unless another is given. Measured
with t = 2: 0.56 against 6.8 CPU seconds, 6 steps against 115, a ratio of 12; with naive steps of
R/8 of the longest discs, 2.
"""

import sys
from contextlib import contextmanager
from fractions import Fraction
from statistics import median
from time import process_time

from flint import acb, arb

from refdem.truth.balls import arb_of
from refdem.truth.validated_ivp import enclosure, recurrences
from refdem.truth.validated_ivp.integration import Integration, Steps

BITS = 300
ROUNDS = 3


def body(y):
    """J = (1, 2, 3): omega in body axes and the attitude."""
    a, b, c, w, x, u, z = y
    spin = [-b * c, c * a, -a * b / 3]
    turn = [
        -x * a - u * b - z * c,
        w * a + u * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - u * a,
    ]
    return spin + [part / 2 for part in turn]


START = [
    Fraction(9, 10),
    Fraction(11, 10),
    Fraction(13, 10),
    Fraction(1),
    Fraction(0),
    Fraction(0),
    Fraction(0),
]


def picard_radius():
    """max over b of b/|f| where every coordinate is within b of its start, in the complex plane and
    the maximum norm.
    """
    found = []
    for k in range(1, 40):
        half = k / 20
        box = [acb(arb(float(x), half), arb(0, half)) for x in START]
        found.append(half / max(float(rate.abs_upper()) for rate in body(box)))
    return max(found)


@contextmanager
def naive():
    """No blocks, no search."""
    before = recurrences.BLOCK, enclosure.FACTORS
    recurrences.BLOCK = 10**9
    enclosure.FACTORS = ()
    try:
        begun = Integration(
            body, lambda: [arb_of(x) for x in START], BITS, Steps(ratio=Fraction(1, 8))
        )
        begun.advance()
        share = picard_radius() / 8 / float(begun.pieces[0].disc.outer)
        yield Steps(ratio=Fraction(share).limit_denominator(10**6), order=BITS // 3)
    finally:
        recurrences.BLOCK, enclosure.FACTORS = before


def seconds(t, steps):
    """CPU seconds to t, and the number of steps."""
    begun = process_time()
    found = Integration(body, lambda: [arb_of(x) for x in START], BITS, steps)
    found.at(arb_of(t))
    return process_time() - begun, len(found.pieces)


def main(t):
    """Prints both and their ratio."""
    quick = []
    slow = []
    for _ in range(ROUNDS):
        quick.append(seconds(t, Steps()))
        with naive() as steps:
            slow.append(seconds(t, steps))
    for name, found in (
        ("blocked products, longest discs", quick),
        ("naive recurrence, R/8", slow),
    ):
        print(
            f"{name:32} {median(one for one, _ in found):8.2f} CPU s in {found[0][1]} steps to t ="
            f" {t} s at {BITS} bits"
        )
    print(
        f"{'naive over blocked':32}"
        f" {median(a / b for (a, _), (b, _) in zip(slow, quick, strict=True)):8.2f}"
    )


if __name__ == "__main__":
    main(Fraction(sys.argv[1]) if len(sys.argv) > 1 else Fraction(100))
