"""Witness of the stick-slip oscillator: Taylor integration of the slips under Stribeck's law, and
uniform motion with the belt while the mass sticks.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of, precision
from refdem.truth.exact import number
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import BITS, Solution

METHOD = (
    "Taylor integration of slips, the belt's motion while it sticks, events by a scan and the"
    " secant (refdem/truth/witnesses/stick_slip.py)"
)
SCAN = 1 / 64
"""Step [s] in which a phase is searched for an event."""
NAMES = ("a", "mu0", "mu1", "lambda0", "lambda1", "belt", "gamma", "eta")


def moving(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The motion as a sequence of slips and sticks, up to the last of the times.

    The scalars are the times at which a stick or a slip begins.
    """
    law = Law(
        {name: arb_of(number(p, name)) for name in NAMES}, linear=p["friction_law"] == "linear"
    )
    begin = arb(0)
    x = arb_of(number(p, "x0"))
    v = arb_of(number(p, "v0"))
    waiting = list(times)
    counts = {"stick": 0, "slip": 0}
    held = False
    while waiting:
        side = law.side(begin, x, v)
        sticks = side == 0
        if float(begin) and held != sticks:
            if sticks:
                event = "stick"
            else:
                event = "slip"
            counts[event] += 1
            yield None, {f"{event}_{counts[event]}": begin}
        held = sticks
        phase = Solution(partial(law.rates, side), [x, v], begin=begin)
        end = law.end(phase, side, begin, waiting[-1])
        while waiting and (end is None or arb_of(waiting[0]) < end):
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        if end is None:
            return
        begin = end
        # A slip ends where u = v - belt = 0, and in a stick u = 0 throughout.
        (x, v) = (phase.at(end)[0], law.e["belt"])


class Law:
    """x'' = gamma cos(eta t) - x - a mu(|belt|) - a mu(|u|) sgn u, u = v - belt."""

    def __init__(self, e: Mapping[str, arb], *, linear: bool) -> None:
        self.e = e
        self.linear = linear

    def coefficient(self, u: Any) -> Any:
        """mu(u) = (mu0 - mu1)/(1 + lambda0 u) + mu1 + lambda1 u^2 (or lambda1 u), for u >= 0."""
        e = self.e
        if self.linear:
            growing = u
        else:
            growing = u * u
        falling = (e["mu0"] - e["mu1"]) / (u * e["lambda0"] + 1)
        return falling + e["mu1"] + growing * e["lambda1"]

    def pull(self, t: Any, x: Any) -> Any:
        """The pull P = gamma cos(eta t) - x - a mu(|belt|)."""
        e = self.e
        return (t * e["eta"]).cos() * e["gamma"] - x - e["a"] * self.coefficient(abs(e["belt"]))

    def side(self, t: arb, x: arb, v: arb) -> int:
        """1 or -1 where the mass slips forward or backward relative to the belt, 0 where it sticks.

        It sticks where u = v - belt is 0 and |P| < a mu0.
        """
        u = v - self.e["belt"]
        pull = self.pull(t, x)
        if abs(float(u)) > 1e-30:
            if u > 0:
                return 1
            return -1
        # With u = 0 it slips if |P| >= a mu0. Equality is the end of a stick, found by bisection.
        excess = abs(pull) - self.e["a"] * self.e["mu0"]
        is_released = excess > 0 or abs(float(excess)) < 1e-30
        if not is_released:
            return 0
        if pull > 0:
            return 1
        return -1

    def rates(self, side: int, t: Any, y: Sequence[Any]) -> list[Any]:
        """The rates (x', v'): (v, P - side a mu(|u|)) in a slip to a side, (belt, 0) in a stick."""
        if side == 0:
            return [self.e["belt"], arb(0)]
        x, v = y
        friction = side * self.e["a"] * self.coefficient(side * (v - self.e["belt"]))
        return [v, self.pull(t, x) - friction]

    def end(self, phase: Solution, side: int, begin: arb, last: Fraction) -> arb | None:
        """The time at which a slip ends (u = 0), or a stick (|P| = a mu0); None after `last`."""
        t = float(begin)
        while t <= float(last):
            t += SCAN
            if side and side * (phase.at(Fraction(t))[1] - self.e["belt"]) < 0:
                return phase.crossing(lambda y: y[1] - self.e["belt"], t - SCAN / 2, SCAN / 2)
            if not side and self.strain(phase, arb(t)) > 0:
                return self.released(phase, t - SCAN, t)
        return None

    def strain(self, phase: Solution, t: arb) -> arb:
        """The excess |P| - a mu0 over static friction."""
        size: arb = abs(self.pull(t, phase.at(t)[0])) - self.e["a"] * self.e["mu0"]
        return size

    def released(self, phase: Solution, low: float, high: float) -> arb:
        """The zero of the strain between two times, by bisection."""
        a = arb(low)
        b = arb(high)
        with precision(BITS + 16):
            for _ in range(BITS):
                middle = ((a + b) / 2).mid()
                if self.strain(phase, middle) > 0:
                    b = middle
                else:
                    a = middle
        return b


WITNESSES = {"stick-slip": Witness(METHOD, moving)}
