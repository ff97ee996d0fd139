"""For pytest: the records of a campaign that is planned and run once a session, also under xdist."""

import fcntl
import os
import tempfile
from pathlib import Path

from refdem.core.finding import Finding, Record


def campaign_records(name: str) -> list[Record]:
    """The records of a campaign; the first process of a test session runs it, the others wait and read."""
    from refdem.report import read_records, write_records

    session = os.environ.get("PYTEST_XDIST_TESTRUNUID", f"pid{os.getpid()}")
    folder = Path(tempfile.gettempdir()) / f"refdem-{os.getuid()}-{session}-{name}"
    folder.mkdir(mode=0o700, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "records.jsonl").exists():
            write_records(folder, _sheets(name))
        return [sheet for sheet in read_records(folder) if isinstance(sheet, Record)]


def _sheets(name: str):  # type: ignore[no-untyped-def]
    from refdem.campaign.campaign import Campaign
    from refdem.campaign.specification import named
    from refdem.core.store import Store, default_path

    return Campaign(named(name), Store(default_path()), os.cpu_count() or 1).sheets()


def by_check(records: list[Record]) -> dict[str, list[Finding]]:
    """Findings by `case[params]/engine/method/check`."""
    found: dict[str, list[Finding]] = {}
    for record in records:
        for finding in record.findings:
            found.setdefault(f"{record.label}/{record.engine}/{record.method}/{finding.check}", []).append(finding)
    return found
