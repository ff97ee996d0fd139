"""Findings against the baseline: worse than 1.5 times what was accepted and beyond noise, lost, or
absent.
"""

from collections.abc import Callable

import msgspec

from refdem.core.finding import DECIDED, Finding, Record
from refdem.gate.baseline import Accepted
from refdem.planning.missing import with_missing

WORSE = 1.5
"""A finding is worse if its size grows by more than this factor. An error constant of an unchanged
method does not change.
"""

QUIET = 0.01
"""Margin [decades] to its bound beyond which a value that is no error constant counts as round-off,
which any rearrangement of sums may change.
"""

Noise = Callable[[Record, Finding], float]
"""A function that returns how far a finding's size moves when the start is moved by some units in
the last place.
"""


def size(finding: Finding) -> float | None:
    """The number that is compared: the error constant, or the value without such a constant."""
    if finding.constant_seen is not None:
        return finding.constant_seen
    return finding.value


def compared(records: list[Record], baseline: dict[str, Accepted], noise: Noise) -> list[Record]:
    """The records in which findings are worse or lost against the baseline.

    A finding of the baseline that was not made is absent, or is named in the error that explains
    it.
    """
    changed = []
    for record in records:
        findings = [_compared(record, finding, baseline, noise) for finding in record.findings]
        changed.append(msgspec.structs.replace(record, findings=tuple(findings)))
    decided = [name for name, entry in baseline.items() if entry.outcome in DECIDED]
    return with_missing(changed, decided, "the baseline")


def _compared(
    record: Record, finding: Finding, baseline: dict[str, Accepted], noise: Noise
) -> Finding:
    """The finding as it is, or as lost, or as worse.

    It is lost if the baseline decided it and it is not decided now. It is worse if its size exceeds
    the factor WORSE times the accepted one by more than the noise of reruns.
    """
    entry = baseline.get(record.id(finding))
    if entry is None or finding.outcome == "fail":
        return finding
    if entry.outcome in DECIDED and finding.outcome not in DECIDED and finding.outcome != "error":
        sentence = (
            f"{finding.sentence} The baseline contains a decided finding here ({entry.outcome})."
        )
        return msgspec.structs.replace(finding, outcome="lost", sentence=sentence)
    now = size(finding)
    before = entry.size
    if now is None or before is None or now <= WORSE * before or _is_quiet(finding):
        return finding
    spread = noise(record, finding)
    if now - WORSE * before <= spread:
        return finding
    allowed = f"the factor {WORSE:g} allows"
    if spread:
        allowed = (
            f"the factor {WORSE:g} and the spread {spread:.1g} of runs with perturbed starts allow"
        )
    sentence = (
        f"{finding.sentence} This is {_times(now, before)} the accepted value"
        f" {before:.2g}, more than {allowed}."
    )
    return msgspec.structs.replace(finding, outcome="worse", sentence=sentence)


def _is_quiet(finding: Finding) -> bool:
    """True if the value is far inside its bound, where it is mere round-off.

    An error constant is never quiet: it shows a change of the method at any size.
    """
    if finding.constant_seen is not None or finding.value is None or finding.bound is None:
        return False
    return finding.value <= QUIET * finding.bound


def _times(now: float, before: float) -> str:
    """The ratio of two sizes in words, or the new size where the old one is 0."""
    if before > 0:
        return f"{now / before:.2g} times"
    return f"{now:.2g} against"
