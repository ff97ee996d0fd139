"""Witness of the Poincare sections of the mass on a belt: its state at multiples of the drive's
period, and the times and positions of v = 0, x > 0 by a scan and the secant method.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.stick_slip import NAMES, SCAN, Law
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration of slips, passages by a scan and the secant"
    " (refdem/truth/witnesses/poincare_sections.py)"
)
MOST_PERIODS = 16
"""Length of the search in periods of the drive or of the spring, whichever is longer."""


def sections(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The points of both sections that are claimed."""
    law = Law(
        {name: arb_of(number(p, name)) for name in NAMES}, linear=p["friction_law"] == "linear"
    )
    asked = {name.partition(".")[0] for name in claimed}
    period = 2 * arb.pi() / law.e["eta"]
    strobes = [period * n for n in range(1, 1 + len([x for x in asked if "strobe" in x]))]
    passages: list[tuple[arb, arb]] = []
    points: dict[str, tuple[arb, arb]] = {}
    due = list(enumerate(strobes, start=1))
    start = (arb_of(number(p, "x0")), arb_of(number(p, "v0")))
    # MOST_PERIODS max(2 pi/eta, 2 pi): the spring has the angular frequency 1.
    last = Fraction(float(period * MOST_PERIODS * law.e["eta"].max(arb(1))))
    for phase, side, begin, end in phases(law, start, last):
        while due and (end is None or due[0][1] < end):
            n, t = due.pop(0)
            x, v = phase.at(t)
            points[f"strobe-{n}"] = (x, v)
        if side and end is not None:
            passages += rests(phase, float(begin), float(end))
        missing = asked - points.keys() - {f"passage-{n}" for n in range(1, 1 + len(passages))}
        if not missing:
            break
    points |= {f"passage-{n}": point for n, point in enumerate(passages, start=1)}
    said: dict[str, arb] = {}
    for name in asked & points.keys():
        said |= {f"{name}.{i}": value for i, value in enumerate(points[name])}
    yield None, said


def phases(
    law: Law, start: tuple[arb, arb], last: Fraction
) -> Iterator[tuple[Solution, int, arb, arb | None]]:
    """Every slip and stick as (solution, side, begin, end); the end is None if after `last` [s]."""
    begin: arb | None = arb(0)
    x, v = start
    while begin is not None:
        side = law.side(begin, x, v)
        phase = Solution(partial(law.rates, side), [x, v], begin=begin)
        end = law.end(phase, side, begin, last)
        yield phase, side, begin, end
        if end is not None:
            # A slip ends where v = belt, and in a stick v = belt throughout.
            (x, v) = (phase.at(end)[0], law.e["belt"])
        begin = end


def rests(phase: Solution, begin: float, end: float) -> list[tuple[arb, arb]]:
    """Pairs (time, x) at which v = 0 and x > 0 within a slip, by sign changes of v on a grid."""
    found = []
    count = 1 + int((end - begin) / SCAN)
    grid = [begin + (end - begin) * k / count for k in range(count + 1)]
    speeds = [phase.at(Fraction(t))[1] for t in grid]
    for k in range(len(grid) - 1):
        # A simple zero of v lies between grid points at which v has different signs.
        if not speeds[k] * speeds[k + 1] < 0:
            continue
        half = (grid[k + 1] - grid[k]) / 2
        time = phase.crossing(lambda y: y[1], grid[k] + half, half)
        place = phase.at(time)[0]
        if place > 0:
            found.append((time, place))
    return found


WITNESSES = {"poincare-sections": Witness(METHOD, sections)}
