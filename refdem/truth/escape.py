"""Proof that an oscillator whose spring repels beyond some reach is infinite within a known time.

Theorem. Let z'' = k z^n - w z - 2 d z' + f with n > 1, k > 0 and |f| <= F, let m = (n + 1)/2, and
let z > 0 and z' > a z^m at some time, with a > 0 and

    k - w+ z^(1-n) - F z^(-n) - 2 d+ a z^((1-n)/2) > m a^2        (x+ is the larger of x and 0).

Then z is infinite within 2/((n - 1) a z^((n-1)/2)). Proof: where z' = a z^m, the inequality times
z^n is z'' > m a^2 z^(2m-1), and the right side is (a z^m)'; so z' - a z^m cannot become negative, z
grows, and with z the left side of the inequality does. From z' > a z^m follows (z^(1-m))' < (1 - m)
a.
"""

from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of

HALVINGS = 8
"""The number of values of a that are tried, each half of the one before."""


@dataclass(frozen=True)
class Repulsion:
    """The oscillator z'' = strength z^power - stiffness z - 2 damping z' + f, |f| <= force, for z >
    0: power > 1 and strength > 0.

    In the symbols of the theorem these are k, n, w, d and F.
    """

    power: int
    strength: Fraction
    stiffness: Fraction
    damping: Fraction
    force: Fraction

    def infinite_within(self, z: arb, speed: arb) -> arb | None:
        """A bound 2/((n - 1) a z^((n-1)/2)) [s] of the time until z is infinite, for every start in
        the balls of z and of its `speed` z'.

        None where the theorem does not apply.
        """
        if not (z > 0 and speed > 0):
            return None
        n = self.power
        least_z = arb(z.lower())
        root = (least_z ** (n - 1)).sqrt()
        # z' > a z^m: the largest a that every start allows, less a part for rounding.
        largest_by_start = (speed / (arb(z.upper()) ** (n + 1)).sqrt()).lower() * arb("0.99")
        # m a^2 = k/2.
        largest_by_strength = (arb_of(self.strength) / (n + 1)).sqrt().lower()
        a = min(largest_by_start, largest_by_strength).mid()
        for _ in range(HALVINGS):
            if self.satisfies_theorem(least_z, root, a):
                return 2 / ((n - 1) * a * root)
            a /= 2
        return None

    def satisfies_theorem(self, z: arb, root: arb, a: arb) -> bool:
        """True if k - w+ z^(1-n) - F z^(-n) - 2 d+ a z^((1-n)/2) > m a^2 is proved at z.

        `root` is z^((n-1)/2), m = (n + 1)/2.
        """
        n = self.power
        stiffness = arb_of(max(self.stiffness, Fraction(0)))
        damping = arb_of(max(self.damping, Fraction(0)))
        # w+ z^(1-n) + F z^(-n) + 2 d+ a z^((1-n)/2)
        resisting = stiffness / z ** (n - 1) + arb_of(self.force) / z**n + 2 * damping * a / root
        return bool(arb_of(self.strength) - resisting > a * a * (n + 1) / 2)
