"""A motion integrated ahead of its proof, without radii, to forecast the number of pieces.

The length of a piece of a proof is limited by the radius of convergence of the motion's Taylor
series and by the largest exponent of a disc, and so is that of a step of this module. So a proof
makes about the same number of pieces for each step, also in fast parts of the motion that it has
not reached. A second motion, displaced at the start, shows how errors grow. No proof depends on it.
"""

from bisect import bisect_right
from collections.abc import Sequence
from math import isfinite, log2

from flint import arb, arb_poly

from refdem.truth.balls import outward, precision
from refdem.truth.traced_field import Program
from refdem.truth.validated_ivp.recurrences import taylor
from refdem.truth.weights import ABOVE_QUICKEST, MAX_DISC_EXPONENT, quickest

BITS = 128
"""The working precision, at which a displacement of 2^NEAR is known to 64 bits."""
NEAR = -64
"""log2 of the displacement with which the second motion begins each step."""
ORDER = 20
"""The order of the Taylor polynomials: their remainder is about 3^-20 of the speed."""
RATIO = 1 / 3
"""The ratio of a step to the radius of convergence."""
FADING = 1 / 4
"""The factor by which the largest speed of a coordinate so far is reduced from step to step."""
SHORTEST = 2.0**-24
"""The part of the longest step below which a step shows that the motion is singular."""


class Scout:
    """The steps of y' = field(y) from the midpoints of `start` at the time `begin` [s]; `slopes` is
    the program of the field's Jacobian, row after row.

    A second motion, displaced at the start in the coordinates `moved`, makes the same steps.
    `times` has the ends of the steps, `polynomials` is the series of the last one, and `swellings`
    log2 of the growth of the displacement up to each. `ended` is True if no step follows the last
    one: the series is not finite there, or has an infinite radius (a motion at rest). `is_singular`
    is True if steps became too short before a singularity, beyond which a proof makes no pieces.
    """

    def __init__(
        self,
        field: Program,
        slopes: Program,
        start: Sequence[arb],
        begin: float,
        moved: Sequence[int],
    ) -> None:
        self.field = field
        self.slopes = slopes
        self.y = [value.mid() for value in start]
        self.gap = [arb(int(i in moved)) for i in range(len(self.y))]
        self.polynomials: list[arb_poly] = []
        self.times = [begin]
        self.swellings = [0.0]
        self.fastest = [0.0] * len(self.y)
        self.longest = 0.0
        self.ended = False
        self.is_singular = False

    def advance(self) -> None:
        """Makes a step, if there is one."""
        with precision(BITS):
            polynomials = taylor(self.field, self.y, ORDER)
            radius = self.radius([one.coeffs() for one in polynomials])
            if isfinite(radius):
                radius = min(radius, self.widest_disc())
            length = RATIO * radius
            following = self.moved_on(polynomials, length)
            gap = self.gap_after(following, length)
        is_made = 0 < length < float("inf") and all(value.is_finite() for value in following)
        self.ended = not is_made
        if is_made:
            self.y = following
            self.polynomials = polynomials
            self.times.append(self.times[-1] + length)
            self.swell(gap)
            self.longest = max(self.longest, length)
            self.is_singular = length < SHORTEST * self.longest
            self.ended = self.is_singular

    def moved_on(self, polynomials: Sequence[arb_poly], length: float) -> list[arb]:
        """The midpoints of a state at the end of a step of that length [s]."""
        return [one(arb(length)).mid() for one in polynomials]

    def gap_after(self, following: Sequence[arb], length: float) -> list[arb]:
        """The displacement of the neighbour at the end of a step, in units of 2^NEAR."""
        unit = arb(2) ** NEAR
        # The neighbour begins at y + 2^NEAR gap; the new gap is the difference of the two ends over
        # 2^NEAR.
        beside = [(value + gap * unit).mid() for value, gap in zip(self.y, self.gap, strict=True)]
        arrived = self.moved_on(taylor(self.field, beside, ORDER), length)
        return [((a - b) / unit).mid() for a, b in zip(arrived, following, strict=True)]

    def swell(self, gap: Sequence[arb]) -> None:
        """Notes the displacement at the end of a step, and brings it back to the length 1; one that
        is 0 or not finite leaves both as they were.
        """
        size = max(abs(float(value)) for value in gap)
        if not 0 < size < float("inf"):
            self.swellings.append(self.swellings[-1])
            return
        self.swellings.append(self.swellings[-1] + log2(size))
        self.gap = [value / size for value in gap]

    def swelling(self, steps: float) -> float:
        """log2 of the growth of a displacement from the start to so many steps; beyond the last
        step at the rate of the later half.
        """
        last = len(self.swellings) - 1
        if steps <= last:
            number = min(int(steps), last - 1)
            before, after = self.swellings[number : number + 2]
            return before + (after - before) * (steps - number)
        half = last // 2
        rate = (self.swellings[last] - self.swellings[half]) / (last - half)
        return self.swellings[last] + rate * (steps - last)

    def widest_disc(self) -> float:
        """The largest radius [s] of a disc that a proof tries, however far the series converges.

        |J| R <= MAX_DISC_EXPONENT, where |J| in the weights of the proof is ABOVE_QUICKEST times
        the largest eigenvalue of the absolute values of J. Infinite where J is not finite.
        """
        norm = ABOVE_QUICKEST * quickest(self.slopes.run(self.y))
        if not isfinite(norm):
            return float("inf")
        return MAX_DISC_EXPONENT / norm

    def radius(self, series: Sequence[Sequence[arb]]) -> float:
        """The radius of convergence, about; not a positive finite number if there is none.

        With the coefficients c_n of y, those of the speed y' are n c_n. Each is measured against
        the largest |c_1| of late, since |c_1| may pass zero; a coordinate that has been constant so
        far is ignored. R is the least (|c_1|/|n c_n|)^(1/(n - 1)) of the last two n.
        """
        radii = [float("inf")]
        for i, one in enumerate(series):
            sizes = [float(outward(value)) for value in one]
            if not all(map(isfinite, sizes)):
                return 0.0
            sizes += [0.0] * (ORDER + 1 - len(sizes))
            self.fastest[i] = max(self.fastest[i] * FADING, sizes[1])
            # (|c_1|/(n |c_n|))^(1/(n - 1)), with the largest |c_1| of late.
            radii += [
                (self.fastest[i] / (n * sizes[n])) ** (1 / (n - 1))
                for n in (ORDER - 1, ORDER)
                if sizes[n] * self.fastest[i] > 0
            ]
        return min(radii)

    def go_on(self, steps: int, t: float) -> None:
        """Makes so many steps more, fewer where the time t [s] is reached or the motion ends."""
        for _ in range(steps):
            if self.ended or self.times[-1] >= t:
                break
            self.advance()

    def clock(self, t: float) -> float:
        """The number of steps to a time [s], with the part of the last one; beyond the last step
        at the pace of the later half, or no further; the time itself where there are no steps.
        """
        times = self.times
        steps = len(times) - 1
        if not steps:
            return t
        number = min(bisect_right(times, t), steps)
        if t <= times[-1]:
            number = max(number, 1)
            begin = times[number - 1]
            return number - 1 + (t - begin) / (times[number] - begin)
        if self.is_singular:
            return float(steps)
        # The last step that begins in the first half of the time.
        half = bisect_right(times, (times[0] + times[-1]) / 2) - 1
        pace = (steps - half) / (times[-1] - times[half])
        return steps + pace * (t - times[-1])
