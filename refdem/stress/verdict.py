"""From findings to verdicts: the verdict of a rung, and the rung at which a method breaks."""

import math
from collections.abc import Sequence
from fractions import Fraction

import msgspec

from refdem.core import finding
from refdem.core.finding import FAILING, Finding
from refdem.stress.ladder import Ladder
from refdem.stress.record import BROKEN, Climb, Rung, Verdict


def rung_of(rung: str, judged: finding.Record) -> Rung:
    """The result of a rung from all findings on it: the worst one, and of passes the one nearest to
    its bound.
    """
    verdict, chosen = _worst(judged.findings)
    return Rung(
        rung=rung,
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


def climbed(empty: Climb, ladder: Ladder, rungs: Sequence[Rung], *, is_required: bool) -> Climb:
    """The climb with its rungs: the last that holds, the first that breaks, and whether the promise
    was kept.
    """
    holds = None
    breaks = None
    for rung in rungs:
        if rung.verdict != "pass":
            if rung.verdict in BROKEN:
                breaks = float(Fraction(rung.rung))
            else:
                breaks = None
            break
        holds = float(Fraction(rung.rung))
    climb = msgspec.structs.replace(empty, rungs=list(rungs), holds=holds, breaks=breaks)
    promised, basis = ladder.promise(empty.method)
    if not is_required or not promised:
        return climb
    required = float(Fraction(promised))
    promised_rungs = rungs[: ladder.rungs.index(promised) + 1]
    return msgspec.structs.replace(
        climb, required=required, basis=basis, kept=_kept(promised_rungs)
    )


def _kept(promised_rungs: Sequence[Rung]) -> bool | None:
    """False if any rung up to the promise did not pass; None if some were not run or not supported;
    else True.
    """
    verdicts = {rung.verdict for rung in promised_rungs}
    if verdicts & {"fail", "error", "undecided"}:
        return False
    if verdicts & {"not run", "unsupported"}:
        return None
    return True


def words(climb: Climb) -> tuple[str, str]:
    """Two phrases: the last rung that a climb holds, and where and how it ends."""
    if climb.holds is None:
        holds = "nothing"
    else:
        holds = number(climb.holds)
    end = climb.end
    if end is None:
        return holds, "not in these rungs"
    from_end = climb.rungs[climb.rungs.index(end) :]
    passes = sum(rung.verdict == "pass" for rung in from_end)
    if passes:
        exception = f", but holds at {passes} beyond"
    else:
        exception = ""
    return holds, f"{end.verdict} at {number(float(Fraction(end.rung)))}{exception}"


def number(value: float) -> str:
    """A rung as text with a few digits: `1e8`, `0.5`."""
    if value == 0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.4g}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def shown_rung(rung: str) -> str:
    """A rung's text in the form of `number`."""
    return number(float(Fraction(rung)))


def ratio(rung: Rung) -> float | None:
    """Value over bound of a rung; None without a value."""
    if rung.value is None or rung.bound is None:
        return None
    if rung.bound == 0:
        if rung.value == 0:
            return 0.0
        return math.inf
    return rung.value / rung.bound
