"""The probes of `refdem smoke` as a record of a gate: they test what no case of the catalogue does,
such as stale neighbour lists, pairs across a periodic boundary, and fixed bodies.
"""

from refdem.core.engine import Engine
from refdem.core.finding import Record
from refdem.planning.deviations import applied, of_engine
from refdem.smoke.battery import smoke

LABEL = "smoke"
"""The case and the label of the record; no case of the catalogue has this name."""
METHOD = "all"
"""The method of the record: of each quantity it has the method with the largest error."""


def probe_records(engine: Engine) -> list[Record]:
    """The record of all probes that the engine supports; none if it supports no probe.

    Probes that it does not support are left out, as cases are.
    """
    findings = [finding for finding in smoke(engine) if finding.outcome != "unsupported"]
    if not findings:
        return []
    record = Record(
        case=LABEL,
        label=LABEL,
        parameters={},
        engine=engine.name,
        version=engine.version(),
        method=METHOD,
        is_reference=engine.is_reference,
        runs=(),
        findings=tuple(findings),
    )
    return [applied(record, of_engine(engine))]
