"""From findings to verdicts: the verdict of a point, and the point at which a method breaks."""

import math
from collections.abc import Sequence
from fractions import Fraction

import msgspec

from refdem.core import finding
from refdem.core.finding import FAILING, Finding
from refdem.stress.record import BROKEN, MethodSweep, Point, Verdict
from refdem.stress.sweep import Sweep


def point_of(point: str, judged: finding.Record) -> Point:
    """The result of a point from all findings on it: the worst one, and of passes the one nearest
    to its bound.
    """
    verdict, chosen = _worst(judged.findings)
    return Point(
        point=point,
        verdict=verdict,
        quantity=f"{chosen.check}: {chosen.quantity}",
        value=chosen.value,
        bound=chosen.bound,
        basis=chosen.basis,
        sentence=chosen.sentence,
        seconds=judged.seconds,
    )


def _worst(findings: Sequence[Finding]) -> tuple[Verdict, Finding]:
    """The verdict of findings, with the finding that decides it: fail, error, pass, unsupported,
    else undecided.
    """
    # The record's own summary, that nothing was decided, is not a finding of a check.
    of_checks = [f for f in findings if (f.check, f.quantity) != ("record", "decided")]
    failed = [f for f in of_checks if f.outcome in FAILING]
    errors = [f for f in of_checks if f.outcome == "error"]
    passed = [f for f in of_checks if f.outcome == "pass"]
    unsupported = [f for f in of_checks if f.outcome == "unsupported"]
    if failed:
        return "fail", min(failed, key=_margin)
    if errors:
        return "error", errors[0]
    if passed:
        return "pass", min(passed, key=_margin)
    if unsupported:
        return "unsupported", unsupported[0]
    if of_checks:
        first = of_checks[0]
    else:
        first = findings[0]
    return "undecided", first


def _margin(judged: Finding) -> float:
    """Margin of a finding in decades; 0 without one."""
    margin = judged.margin
    if margin is not None:
        return margin
    return 0.0


def summarised(
    empty: MethodSweep, sweep: Sweep, points: Sequence[Point], *, is_required: bool
) -> MethodSweep:
    """The method sweep with its points: the last that holds, the first that breaks, and whether the
    promise was kept.
    """
    holds = None
    breaks = None
    for point in points:
        if point.verdict != "pass":
            if point.verdict in BROKEN:
                breaks = float(Fraction(point.point))
            else:
                breaks = None
            break
        holds = float(Fraction(point.point))
    result = msgspec.structs.replace(empty, points=list(points), holds=holds, breaks=breaks)
    promised, basis = sweep.promise(empty.method)
    if not is_required or not promised:
        return result
    required = float(Fraction(promised))
    promised_points = points[: sweep.points.index(promised) + 1]
    return msgspec.structs.replace(
        result, required=required, basis=basis, kept=_kept(promised_points)
    )


def _kept(promised_points: Sequence[Point]) -> bool | None:
    """False if any point up to the promise did not pass; None if some were not run or not
    supported; else True.
    """
    verdicts = {point.verdict for point in promised_points}
    if verdicts & {"fail", "error", "undecided"}:
        return False
    if verdicts & {"not run", "unsupported"}:
        return None
    return True


def words(result: MethodSweep) -> tuple[str, str]:
    """Two phrases: the last point that a method sweep holds, and where and how it ends."""
    if result.holds is None:
        holds = "nothing"
    else:
        holds = number(result.holds)
    end = result.end
    if end is None:
        return holds, "not in these points"
    from_end = result.points[result.points.index(end) :]
    passes = sum(point.verdict == "pass" for point in from_end)
    if passes:
        exception = f", but holds at {passes} beyond"
    else:
        exception = ""
    return holds, f"{end.verdict} at {number(float(Fraction(end.point)))}{exception}"


def number(value: float) -> str:
    """A point as text with a few digits: `1e8`, `0.5`."""
    if value == 0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.4g}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def shown_point(point: str) -> str:
    """A point's text in the form of `number`."""
    return number(float(Fraction(point)))


def ratio(point: Point) -> float | None:
    """Value over bound of a point; None without a value."""
    if point.value is None or point.bound is None:
        return None
    if point.bound == 0:
        if point.value == 0:
            return 0.0
        return math.inf
    return point.value / point.bound
