"""Expected deviations: values known to be out of bounds, each with its range, reason and link. One
becomes stale when its finding passes.
"""

import msgspec

from refdem.core.deviation import Deviation
from refdem.core.engine import Engine
from refdem.core.finding import Finding, Record
from refdem.core.outside import one_line
from refdem.core.reading import toml_as
from refdem.planning.specification import validation_folder


class _File(msgspec.Struct, forbid_unknown_fields=True):
    """The content of validation/expected/<engine>.toml."""

    expected: list[Deviation] = []


def of_engine(engine: Engine) -> list[Deviation]:
    """The deviations in validation/expected/<name>.toml, and those that the engine brings; raises
    UsageError if the file is not well formed.

    A program that has a refdem.toml brings its own alone, whatever its name.
    """
    path = validation_folder() / "expected" / f"{engine.name}.toml"
    if engine.address != engine.name or not path.exists():
        return list(engine.expected)
    shipped = toml_as(_File, path, "expected deviations of an engine").expected
    return [*shipped, *engine.expected]


def applied(record: Record, deviations: list[Deviation]) -> Record:
    """The record in which failing findings that a deviation covers are expected, and passing ones
    that a deviation covers are stale.
    """
    findings = tuple(_applied(record, finding, deviations) for finding in record.findings)
    return msgspec.structs.replace(record, findings=findings)


def _applied(record: Record, finding: Finding, deviations: list[Deviation]) -> Finding:
    """The finding as the first deviation that covers it changes it; unchanged if none does.

    A failing value inside [low, high] becomes `expected`, one outside still fails; a finding that
    passes makes the deviation `stale`.
    """
    deviation = next((d for d in deviations if d.covers(record, finding)), None)
    if deviation is None or finding.outcome not in ("pass", "fail") or finding.value is None:
        return finding
    if deviation.link:
        reason = f"{deviation.reason} ({deviation.link})"
    else:
        reason = deviation.reason
    why = one_line(reason)
    if finding.outcome == "pass":
        sentence = f"{finding.sentence} A deviation was expected here and is stale: {why}"
        return msgspec.structs.replace(finding, outcome="stale", sentence=sentence)
    is_inside = deviation.low <= finding.value <= deviation.high
    if is_inside:
        relation = "inside"
        outcome = "expected"
    else:
        relation = "outside"
        outcome = "fail"
    sentence = (
        f"{finding.sentence} It is {relation} the expected deviation [{deviation.low:.3g},"
        f" {deviation.high:.3g}]: {why}"
    )
    return msgspec.structs.replace(finding, outcome=outcome, sentence=sentence)
