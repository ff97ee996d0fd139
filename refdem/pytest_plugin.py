"""For pytest: a refdem.toml is collected as a test file, a gate for engines in process, and
campaigns run once a session.
"""

import fcntl
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import pytest

if TYPE_CHECKING:
    from refdem.core.engine import Engine
    from refdem.core.finding import Finding, Record, Sheet

_SESSION = uuid4().hex
"""This process's own session: a process number may come back, and with it another session's
records.
"""


def pytest_addoption(parser: pytest.Parser) -> None:
    """A refdem.toml runs programs, so that it is collected only where the project's settings or the
    caller say so.
    """
    parser.addoption(
        "--refdem", action="store_true", help="collect every refdem.toml: run its program's gate"
    )
    parser.addini(
        "refdem", "collect every refdem.toml: run its program's gate", type="bool", default=False
    )


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """A refdem.toml as a file of tests."""
    wanted = parent.config.getoption("--refdem") or parent.config.getini("refdem")
    if wanted and file_path.name == "refdem.toml":
        return RefdemFile.from_parent(parent, path=file_path)
    return None


class RefdemFile(pytest.File):
    """The gate of one program; run once a session, also under xdist."""

    def collect(self) -> Iterator[pytest.Item]:
        """One item a case, method and check."""
        from refdem.core.finding import BROKEN, DECIDED
        from refdem.errors import RefdemError

        judged = (*DECIDED, *BROKEN)
        try:
            gate_records = once(f"gate of {self.path}", lambda: _gate(self.path))
        except RefdemError as error:
            raise self.CollectError(str(error)) from None
        if not any(
            finding.outcome in judged for record in gate_records for finding in record.findings
        ):
            raise self.CollectError(
                f"the gate of {self.path} judged nothing: {reasons(gate_records)}"
            )
        for name, findings in by_check(gate_records).items():
            yield RefdemItem.from_parent(self, name=name, findings=findings)


class RefdemItem(pytest.Item):
    """One check of one method in one case."""

    def __init__(self, *, findings: "list[Finding]", **more: Any) -> None:
        super().__init__(**more)
        self.findings = findings

    def runtest(self) -> None:
        """Fails with the sentences of what is broken; skips with the reason where nothing was
        decided.
        """
        decide(self.findings)

    def repr_failure(
        self, excinfo: pytest.ExceptionInfo[BaseException], *style: Any, **more: Any
    ) -> str:
        """The sentences alone: there is no code of the project to show."""
        return str(excinfo.value)

    def reportinfo(self) -> tuple[Path, int, str]:
        """The path and name under which pytest reports the item."""
        return self.path, 0, self.name


@pytest.fixture
def refdem_gate() -> "Callable[..., list[Record]]":
    """`refdem_gate(engine, cases=(), levels=4)`: judges an engine object in process; fails the test
    if its gate is closed.
    """

    def judge(engine: "Engine", cases: Iterable[str] = (), *, levels: int = 4) -> "list[Record]":
        from refdem.core.finding import DECIDED
        from refdem.gate.in_process import broken, records

        judged = records(engine, cases, levels=levels)
        if wrong := broken(judged):
            pytest.fail("\n".join(wrong), pytrace=False)
        if not any(finding.outcome in DECIDED for record in judged for finding in record.findings):
            pytest.fail(f"nothing was judged: {reasons(judged)}", pytrace=False)
        return judged

    return judge


def reasons(judged: "Iterable[Record]") -> str:
    """Why nothing was decided, each sentence once."""
    sentences = dict.fromkeys(finding.sentence for record in judged for finding in record.findings)
    return " ".join(sentences) or "no case is one that the engine supports"


def decide(findings: "Iterable[Finding]") -> None:
    """Fails, skips or passes as the findings of one check say."""
    from refdem.core.finding import BROKEN

    findings = list(findings)
    if wrong := [finding.sentence for finding in findings if finding.outcome in BROKEN]:
        pytest.fail("\n".join(wrong), pytrace=False)
    if all(finding.outcome == "undecided" for finding in findings):
        pytest.skip("; ".join(finding.sentence for finding in findings))


def campaign_records(name: str) -> "list[Record]":
    """The records of a campaign of refdem's own; the first process of a session runs it, the others
    wait and read.
    """
    return once(f"campaign {name}", lambda: _campaign(name))


def once(what: str, sheets: "Callable[[], list[Sheet]]") -> "list[Record]":
    """The records of `sheets()`, called by the first process of the test session that asks for
    `what`.
    """
    from hashlib import sha256

    from refdem.core.finding import Record
    from refdem.report import read_records, write_records

    session = os.environ.get("PYTEST_XDIST_TESTRUNUID", _SESSION)
    place = sha256(f"{session}\0{what}".encode()).hexdigest()[:24]
    folder = Path(tempfile.gettempdir()) / f"refdem-{os.getuid()}-{place}"
    folder.mkdir(mode=0o700, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "records.jsonl").exists():
            write_records(folder, sheets())
        return [sheet for sheet in read_records(folder) if isinstance(sheet, Record)]


def by_check(records: "Iterable[Record]") -> "dict[str, list[Finding]]":
    """Findings by `case[params]/engine/method/check`, without those that an engine refused."""
    findings: dict[str, list[Finding]] = {}
    for record in records:
        for finding in record.findings:
            if finding.outcome != "unsupported":
                test = f"{record.label}/{record.engine}/{record.method}/{finding.check}"
                findings.setdefault(test, []).append(finding)
    return findings


def _campaign(name: str) -> "list[Sheet]":
    from refdem.core.store import Store, default_path
    from refdem.planning.campaign import Campaign
    from refdem.planning.specification import named

    return Campaign(named(name), Store(default_path()), os.cpu_count() or 1).sheets()


def _gate(toml: Path) -> "list[Sheet]":
    """What the gate of a program finds, against its baseline."""
    from refdem.gate.gate import of_program

    gate = of_program(toml, None, os.cpu_count() or 1, lambda stage, done, total: None)
    return gate.against_baseline(gate.sheets())
