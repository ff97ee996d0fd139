"""refdem resolution: tables what a run would notice, and refuses what it cannot measure."""

import msgspec
import pytest
from typer.testing import CliRunner

from refdem.cli.app import app
from refdem.core.resolution import Resolution
from refdem.errors import UsageError

RUNNER = CliRunner()


def test_the_command_measures_a_case_and_writes_a_page(tmp_path):
    words = ["resolution", "harmonic-oscillator", "--engine", "rebound", "--method", "leapfrog"]
    result = RUNNER.invoke(app, [*words, "--out", str(tmp_path), "--computed"])
    assert result.exit_code == 0, result.output
    assert "stiffness of the spring" in result.stdout
    assert "\ncomputed  " in result.stdout
    page = (tmp_path / "resolution.md").read_text()
    assert page.startswith("# Resolution")
    assert "| stiffness of the spring |" in page
    as_json = RUNNER.invoke(app, [*words, "--json"])
    (found,) = msgspec.json.decode(as_json.stdout, type=list[Resolution])
    assert {seen.number for seen in found.numbers} >= {"mass", "stiffness of the spring"}


@pytest.mark.parametrize("words", [[], ["pendulum", "--campaign", "main"]])
def test_cases_or_a_campaign_are_expected_and_not_both(words):
    result = RUNNER.invoke(app, ["resolution", *words])
    assert isinstance(result.exception, UsageError)
    assert "expected cases" in str(result.exception)


def test_a_question_without_a_scene_has_nothing_to_misread():
    result = RUNNER.invoke(app, ["resolution", "rotations"])
    assert isinstance(result.exception, UsageError)
    assert "nothing was measured" in str(result.exception)


def test_the_next_report_in_the_folder_tells_it_on_the_page_of_the_case(tmp_path):
    words = ["harmonic-oscillator", "--engine", "rebound", "--method", "leapfrog"]
    out = ["--out", str(tmp_path)]
    assert RUNNER.invoke(app, ["run", *words, *out]).exit_code == 0
    page = tmp_path / "cases" / "harmonic-oscillator.html"
    assert "Would have noticed" not in page.read_text()
    assert RUNNER.invoke(app, ["resolution", *words, *out]).exit_code == 0
    assert RUNNER.invoke(app, ["run", *words, *out]).exit_code == 0
    assert "leapfrog: Would have noticed: " in page.read_text()
    # That of other methods is none of this report's.
    assert RUNNER.invoke(app, ["run", "pendulum", "--engine", "rebound", *out]).exit_code == 0
    assert '"resolution"' not in (tmp_path / "records.jsonl").read_text()
    assert RUNNER.invoke(app, ["run", *words, *out]).exit_code == 0
    # The records have it too, so that the report can be made of them again.
    page.unlink()
    assert RUNNER.invoke(app, ["report", str(tmp_path)]).exit_code == 0
    assert "leapfrog: Would have noticed: " in page.read_text()


def test_a_damaged_file_beside_a_report_is_named_before_anything_runs(tmp_path):
    (tmp_path / "resolution.jsonl").write_text("{}\n")
    result = RUNNER.invoke(app, ["run", "pendulum", "--out", str(tmp_path)])
    assert isinstance(result.exception, UsageError)
    assert "resolution.jsonl, line 1" in str(result.exception)
