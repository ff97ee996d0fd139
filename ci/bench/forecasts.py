"""Forecasts of proofs at random settings against the CPU seconds that the proofs then take.

A line for each: the case, the time, the forecast, the proof, and the factor between the two. Those
beyond MOST_FACTOR are marked; the exit status is 1 where there are any.

    python ci/bench/forecasts.py [--count 30] [--seed 1] [CASE ...]
"""

import argparse
import random
import signal
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from time import process_time
from types import FrameType

from refdem.core import discovery
from refdem.errors import RefdemError
from tests.random_settings import NAMES, settings

MOST_FACTOR = 3.0
"""A forecast holds if it and the proof differ by no larger factor."""
DIGITS = 40
SOONEST = Fraction(1, 64)
"""Fraction of its default duration at which a motion is evaluated first; it is doubled each time.
"""
DOUBLINGS = 16
DEAR = 2.0
"""Smallest forecast [CPU s] that is compared; shorter times are measured too roughly."""
TOO_DEAR = 16.0
"""Largest forecast [CPU s] of a proof that is made here."""
PATIENCE = 4
"""Largest ratio of the time of a proof to its forecast, after which it is stopped."""


class TooLongError(Exception):
    """A proof is too expensive, or takes PATIENCE times its forecast."""


@dataclass(frozen=True)
class Comparison:
    """A forecast and the proof after it [CPU s]; `following` was spent on the forecast itself."""

    case: str
    given: Mapping[str, str]
    t: Fraction
    forecast: float
    following: float
    proof: float
    refusal: str = ""

    def factor(self) -> float:
        """By how much the two differ, > 1 where the forecast was too low."""
        return self.proof / self.forecast

    def holds(self) -> bool:
        """True if they differ by MOST_FACTOR at most, or the proof was refused."""
        return bool(self.refusal) or 1 / MOST_FACTOR <= self.factor() <= MOST_FACTOR

    def line(self) -> str:
        """All of it as a line."""
        if self.holds():
            mark = " "
        else:
            mark = "!"
        set_to = " ".join(f"{name}={value}" for name, value in self.given.items())
        words = [
            f"{mark} {self.case:22} t = {float(self.t):<10.5g}",
            f"forecast {self.forecast:6.2f} s after {self.following:5.2f} s,",
            f"proof {self.proof:6.2f} s, factor {self.factor():5.2f}",
            self.refusal[:60],
            set_to,
        ]
        return " ".join(words)


def stop(number: int, frame: FrameType | None) -> None:
    """Raises TooLongError, as the handler of a signal."""
    raise TooLongError


def compared(case: str, given: Mapping[str, str], t: Fraction) -> Comparison | None:
    """The forecast of a value at t and its proof; None if the forecast is below DEAR.

    Raises TooLongError if it is above TOO_DEAR.
    """
    truth = discovery.case(case).at(**given).truth()
    begun = process_time()
    forecast = truth.forecast(t, DIGITS)
    if forecast > TOO_DEAR:
        raise TooLongError
    following = process_time() - begun
    if forecast < DEAR:
        return None
    refusal = ""
    begun = process_time()
    signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE * forecast)
    try:
        truth.refined(DIGITS).at(t)
    except RefdemError as error:
        refusal = f"refused: {error}"
    except TooLongError:
        pass
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return Comparison(case, given, t, forecast, following, process_time() - begun, refusal)


def comparison(case: str, rng: random.Random) -> Comparison | None:
    """A forecast of a case at a random setting, at the first time with a forecast above DEAR."""
    given = settings(rng, case)
    duration = discovery.case(case).at(**given).scales.duration or 1
    t = Fraction(duration) * SOONEST * Fraction(rng.randint(1000, 2000), 1000)
    for _ in range(DOUBLINGS):
        found = compared(case, given, t.limit_denominator(10**6))
        if found is not None:
            return found
        t *= 2
    return None


def comparisons(cases: list[str], count: int, seed: int) -> Iterator[Comparison]:
    """So many of the cases, one after another, until `count` were found."""
    found = 0
    for number in range(count):
        for case in cases:
            rng = random.Random(f"{seed} {case} {number}")
            try:
                one = comparison(case, rng)
            except (RefdemError, TooLongError):
                continue
            if one is None:
                continue
            yield one
            found += 1
            if found >= count:
                return


def main() -> int:
    """Prints all comparisons; returns 1 if one does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=NAMES)
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    signal.signal(signal.SIGVTALRM, stop)
    failed = 0
    for one in comparisons(arguments.cases, arguments.count, arguments.seed):
        print(one.line(), flush=True)
        failed += not one.holds()
    print(f"{failed} beyond a factor of {MOST_FACTOR:g}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
