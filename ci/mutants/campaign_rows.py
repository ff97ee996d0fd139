"""Every row of campaign `main` as one test an engine, in this process.

usage: pytest ci/mutants/campaign_rows.py

CI runs the same rows as validation/test_validation.py does, in worker processes. Here each row is a
test of its own, so that executed_lines.py can say which lines it runs, and mutants.py can ask for
the rows that a planted error stands in.
"""

import os
from collections import Counter
from pathlib import Path

import msgspec
import pytest

from refdem.core import discovery
from refdem.core.finding import BROKEN, DECIDED, Record
from refdem.core.store import Store, default_path
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification, named

MAIN = named("main")
ENGINES = tuple(discovery.own_names("engines"))


def name_of(entry: Entry) -> str:
    """A row as its case and parameters, in words that pytest can print."""
    settings = ",".join(f"{name}={value}" for name, value in entry.set.items())
    if settings:
        return f"{entry.id}({settings})"
    return entry.id


def part(entry: Entry, engine: str) -> Specification:
    """The campaign with one row and one engine; what it must find there is still required."""
    return msgspec.structs.replace(MAIN, case=[entry], engines=[engine], is_part=True)


def test_no_row_of_main_comes_twice() -> None:
    counts = Counter(name_of(entry) for entry in MAIN.case)
    assert [name for name, count in counts.items() if count > 1] == []


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("entry", MAIN.case, ids=name_of)
def test_a_row_of_main_holds(entry: Entry, engine: str) -> None:
    place = os.environ.get("REFDEM_STORE")
    store = Store(Path(place) if place else default_path())
    campaign = Campaign(part(entry, engine), store, jobs=0, use_store=False)
    records = [sheet for sheet in campaign.sheets() if isinstance(sheet, Record)]
    found = [finding for record in records for finding in record.findings]
    wrong = [finding.sentence for finding in found if finding.outcome in BROKEN]
    assert wrong == []
    is_refused = all(finding.outcome == "unsupported" for finding in found)
    assert is_refused or any(finding.outcome in DECIDED for finding in found)
