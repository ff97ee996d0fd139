"""The gate for a Python code in its own tests, without worker processes, files or a store."""

import tempfile
from collections.abc import Iterable
from pathlib import Path

from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.finding import BROKEN, Record, findings_of
from refdem.core.parameters import labelled
from refdem.core.store import Store
from refdem.gate.gate import supported
from refdem.gate.probing import probe_records
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification


def records(engine: Engine, cases: Iterable[str] = (), *, levels: int = 4) -> list[Record]:
    """The records of an engine object in the given cases (`pendulum[theta0=2]`), or in all that it
    supports, with at most `levels` refinement levels. Without `cases` there is one more record, of
    the probes of `refdem smoke`.
    """
    named_cases = [Entry(*labelled(case)) for case in cases]
    # A campaign needs engines with names and a store. Both exist only during this call.
    with discovery.engine_here(engine), tempfile.TemporaryDirectory() as folder:
        entries = named_cases or supported(engine)
        specification = Specification(
            name=f"gate of {engine.name}", case=entries, engines=[engine.name], levels=levels
        )
        store = Store(Path(folder) / "store.sqlite")
        sheets = Campaign(specification, store, jobs=0, use_store=False).sheets()
        store.close()
    judged = [sheet for sheet in sheets if isinstance(sheet, Record)]
    if named_cases:
        return judged
    return [*judged, *probe_records(engine)]


def broken(judged: Iterable[Record]) -> list[str]:
    """The id and the sentence of every finding that closes the gate."""
    return [
        f"{record.id(finding)}: {finding.sentence}"
        for record, finding in findings_of(judged)
        if finding.outcome in BROKEN
    ]
