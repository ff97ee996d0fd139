"""Limits of a program in a campaign: its own time limit comes first, its budget ends the campaign's
patience.
"""

from pathlib import Path

import pytest

from refdem.core.finding import CampaignSheet, Finding, Record
from refdem.core.store import Store
from refdem.errors import UsageError
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification

WORKERS = 2


def sheets(folder: Path, *tomls: Path, method: str = "", timeout: float = 60.0) -> list:  # type: ignore[type-arg]
    specification = Specification(
        name="test",
        case=[Entry("harmonic-oscillator")],
        engines=[str(toml) for toml in tomls],
        levels=3,
        method=method,
        timeout=timeout,
    )
    store = Store(folder / "store.sqlite")
    found = Campaign(specification, store, jobs=WORKERS).sheets()
    store.close()
    return found


def findings(folder: Path, toml: Path, **more: object) -> tuple[Finding, ...]:
    (record,) = (sheet for sheet in sheets(folder, toml, **more) if isinstance(sheet, Record))  # type: ignore[arg-type]
    return record.findings


def test_the_programs_own_limit_comes_before_the_workers(small: Path, tmp_path: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", "timeout = 1"))
    (finding,) = findings(tmp_path, toml, method="hangs", timeout=0.5)
    assert finding.outcome == "error"
    assert (
        "still running after 1 s and was ended (request and output are kept in" in finding.sentence
    )


def test_a_program_that_hangs_costs_its_time_once_and_not_at_every_step(
    small: Path, tmp_path: Path
) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", "timeout = 1"))
    (finding,) = findings(tmp_path, toml, method="hangs")
    assert finding.outcome == "error"
    assert (
        len(list((tmp_path / "kept" / "failed-runs").iterdir())) <= 3 * WORKERS
    )  # two steps, and what had begun meanwhile


def test_runs_after_the_budget_is_spent_are_errors_that_say_so(small: Path, tmp_path: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", "timeout = 600\nbudget = 1e-6"))
    (finding,) = findings(tmp_path, toml, method="good")
    assert finding.outcome == "error"
    assert "(budget)" in finding.sentence
    assert "engine.budget" in finding.sentence


def test_a_good_program_passes_and_is_not_run_again_until_it_changes(
    small: Path, tmp_path: Path
) -> None:
    toml = small / "refdem.toml"

    def counts() -> tuple[int, set[str]]:
        found = sheets(tmp_path, toml, method="good")
        made = next(sheet.runs_made for sheet in found if isinstance(sheet, CampaignSheet))
        return made, {
            f.outcome for sheet in found if isinstance(sheet, Record) for f in sheet.findings
        }

    made, outcomes = counts()
    assert made > 0
    assert "fail" not in outcomes
    assert counts() == (0, outcomes)
    program = small / "program.py"
    program.write_text(program.read_text().replace("x += h * v", "x -= h * v"))
    rebuilt, outcomes = counts()
    assert rebuilt == made
    assert "fail" in outcomes


def test_an_expected_deviation_of_the_description_excuses_what_it_covers(
    small: Path, tmp_path: Path
) -> None:
    toml = small / "refdem.toml"
    toml.write_text(
        toml.read_text()
        + '\n[[expected]]\ncase = "harmonic-oscillator"\nmethod = "good"\ncheck = "error"\nquantity'
        ' = "x"\nversions = "*"\n' + 'low = 1e-9\nhigh = 1.0\nreason = "a test of staleness"\n'
    )
    (stale,) = (f for f in findings(tmp_path, toml, method="good") if f.outcome == "stale")
    assert (stale.check, stale.quantity) == ("error", "x")


def test_two_programs_of_one_name_are_refused(small: Path, tmp_path: Path) -> None:
    other = small / "other.toml"
    other.write_text((small / "refdem.toml").read_text())
    with pytest.raises(UsageError, match="two engines are named 'small'"):
        sheets(tmp_path, small / "refdem.toml", other)
