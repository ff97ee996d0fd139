"""From findings to verdicts: a rung's, and the number at which a method breaks."""

import math
from collections.abc import Sequence
from fractions import Fraction

import msgspec

from refdem.core import finding
from refdem.core.finding import FAILING, Finding
from refdem.stress.ladder import Ladder
from refdem.stress.record import BROKEN, Climb, Rung, Verdict


def rung_of(rung: str, judged: finding.Record) -> Rung:
    """A rung from all that was found on it: the worst finding, and among passes the one that comes
    nearest to its bound.
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


def _worst(found: Sequence[Finding]) -> tuple[Verdict, Finding]:
    """The verdict of findings and the one that gives it; nothing decided is `undecided`, which is
    never a pass.
    """
    real = [f for f in found if (f.check, f.quantity) != ("record", "decided")]
    failed = [f for f in real if f.outcome in FAILING]
    errors = [f for f in real if f.outcome == "error"]
    passed = [f for f in real if f.outcome == "pass"]
    unsupported = [f for f in real if f.outcome == "unsupported"]
    if failed:
        return "fail", min(failed, key=_margin)
    if errors:
        return "error", errors[0]
    if passed:
        return "pass", min(passed, key=_margin)
    if unsupported:
        return "unsupported", unsupported[0]
    if real:
        first = real[0]
    else:
        first = found[0]
    return "undecided", first


def _margin(judged: Finding) -> float:
    margin = judged.margin
    if margin is not None:
        return margin
    return 0.0


def climbed(bare: Climb, ladder: Ladder, rungs: Sequence[Rung], *, is_required: bool) -> Climb:
    """The climb with its rungs: the last that holds, the first that breaks, and whether what had to
    hold did.
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
    found = msgspec.structs.replace(bare, rungs=list(rungs), holds=holds, breaks=breaks)
    promised, basis = ladder.promise(bare.method)
    if not is_required or not promised:
        return found
    required = float(Fraction(promised))
    due = rungs[: ladder.rungs.index(promised) + 1]
    return msgspec.structs.replace(found, required=required, basis=basis, kept=_kept(due))


def _kept(due: Sequence[Rung]) -> bool | None:
    """False if any rung that was due did not pass.

    None if some were left out: by the budget, or as the method cannot run them.
    """
    verdicts = {rung.verdict for rung in due}
    if verdicts & {"fail", "error", "undecided"}:
        return False
    if verdicts & {"not run", "unsupported"}:
        return None
    return True


def words(climb: Climb) -> tuple[str, str]:
    """How far a climb holds, and where and how it ends."""
    if climb.holds is None:
        holds = "nothing"
    else:
        holds = number(climb.holds)
    end = climb.end
    if end is None:
        return holds, "not in these rungs"
    beyond = climb.rungs[climb.rungs.index(end) :]
    again = sum(rung.verdict == "pass" for rung in beyond)
    if again:
        more = f", but holds at {again} beyond"
    else:
        more = ""
    return holds, f"{end.verdict} at {number(float(Fraction(end.rung)))}{more}"


def number(value: float) -> str:
    """A rung with two digits: `1e8`, `0.5`."""
    if value == 0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.4g}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def shown_rung(rung: str) -> str:
    """A rung's name as people read it."""
    return number(float(Fraction(rung)))


def ratio(rung: Rung) -> float | None:
    """Value over bound; None where there is no value."""
    if rung.value is None or rung.bound is None:
        return None
    if rung.bound == 0:
        if rung.value == 0:
            return 0.0
        return math.inf
    return rung.value / rung.bound
