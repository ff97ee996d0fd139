"""Proof that an oscillator whose spring repels beyond some reach is infinite within a known time.

Theorem. Let z'' = k z^n - w z - 2 d z' + f with n > 1, k > 0 and |f| <= F, let m = (n + 1)/2, and
let z > 0 and z' > a z^m at some time, with a > 0 and

    k - w+ z^(1-n) - F z^(-n) - 2 d+ a z^((1-n)/2) > m a^2        (x+ is the larger of x and 0).

Then z is infinite within 2/((n - 1) a z^((n-1)/2)). Proof: where z' = a z^m, the inequality times
z^n says that z'' > m a^2 z^(2m-1), which is (a z^m)'; so z' - a z^m cannot become negative, z
grows, and with z the left side of the inequality does. From z' > a z^m follows (z^(1-m))' < (1 - m)
a.
"""

from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of

HALVINGS = 8
"""How often a smaller a is tried."""


@dataclass(frozen=True)
class Repulsion:
    """z'' = strength z^power - stiffness z - 2 damping z' + f, |f| <= force, for z > 0: power > 1
    and strength > 0.
    """

    power: int
    strength: Fraction
    stiffness: Fraction
    damping: Fraction
    force: Fraction

    def infinite_within(self, z: arb, speed: arb) -> arb | None:
        """A bound of the time [s] until z is infinite, for every start in the balls.

        None where the theorem does not tell.
        """
        if not (z > 0 and speed > 0):
            return None
        n = self.power
        reach = arb(z.lower())
        root = (reach ** (n - 1)).sqrt()
        # The largest a that the start allows, and one at which m a^2 takes half of k.
        begun = (speed / (arb(z.upper()) ** (n + 1)).sqrt()).lower() * arb("0.99")
        half = (arb_of(self.strength) / (n + 1)).sqrt().lower()
        a = min(begun, half).mid()
        for _ in range(HALVINGS):
            if self.grows(reach, root, a):
                return 2 / ((n - 1) * a * root)
            a /= 2
        return None

    def grows(self, z: arb, root: arb, a: arb) -> bool:
        """The inequality of the theorem at z, with root = z^((n-1)/2)."""
        n = self.power
        stiffness = arb_of(max(self.stiffness, Fraction(0)))
        damping = arb_of(max(self.damping, Fraction(0)))
        slowed = stiffness / z ** (n - 1) + arb_of(self.force) / z**n + 2 * damping * a / root
        return bool(arb_of(self.strength) - slowed > a * a * (n + 1) / 2)
