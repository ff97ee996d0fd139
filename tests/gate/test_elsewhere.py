"""Of several programs of one export each is compared with a baseline of its own."""

from pathlib import Path

import msgspec
import pytest

from refdem.core.finding import CampaignSheet, Record
from refdem.core.judgement import judged
from refdem.errors import UsageError
from refdem.gate import baseline, elsewhere
from refdem.planning.exchange import MANIFEST, Manifest
from refdem.planning.specification import Entry

WHOLE = CampaignSheet(name="own", refdem="1", runs_made=1, runs_read=0, seconds=0.5)


def record(engine: str, value: float) -> Record:
    finding = judged(
        check="error", quantity="x", value=value, bound=1e-2, unit="1", basis="b", what="w"
    )
    return Record(
        case="c",
        label="c",
        parameters={},
        engine=engine,
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=(finding,),
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An export for two programs."""
    import refdem

    manifest = Manifest(
        refdem=refdem.__version__,
        case=[Entry("pendulum")],
        levels=3,
        versions={"one": "1", "other": "1"},
    )
    (tmp_path / MANIFEST).write_bytes(msgspec.json.encode(manifest))
    return tmp_path


def test_a_program_without_a_baseline_is_not_compared(folder: Path) -> None:
    paths = elsewhere.baselines(folder)
    assert {path.parent for path in paths.values()} == {folder}
    baseline.write(paths["one"], [record("one", 1e-3)], "first")
    accepted = elsewhere.accepted(paths)
    assert set(accepted) == {"one"}
    sheets = [WHOLE, record("one", 2e-3), record("other", 2e-3)]
    compared = elsewhere.against_baselines(sheets, accepted)
    assert WHOLE in compared
    for name, outcome in (("one", "worse"), ("other", "pass")):
        (found,) = elsewhere.of_program(compared, name)
        assert [finding.outcome for finding in found.findings] == [outcome]


def test_a_program_whose_records_are_gone_has_lost_its_findings(folder: Path) -> None:
    paths = elsewhere.baselines(folder)
    baseline.write(paths["one"], [record("one", 1e-3)], "first")
    compared = elsewhere.against_baselines([record("other", 1e-3)], elsewhere.accepted(paths))
    (vanished,) = elsewhere.of_program(compared, "one")
    assert [finding.outcome for finding in vanished.findings] == ["absent"]


def test_the_baseline_of_one_program_is_not_taken_for_that_of_another(folder: Path) -> None:
    paths = elsewhere.baselines(folder)
    baseline.write(paths["one"], [record("one", 1e-3)], "first")
    paths["one"].rename(paths["other"])
    with pytest.raises(UsageError, match="is that of 'one'; expected one of 'other'"):
        elsewhere.accepted(paths)
