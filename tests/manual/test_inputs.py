"""The committed pages are those of the cases, the certified values and the checks as they are; what
changed is named.
"""

from pathlib import Path

import pytest

from refdem.manual import inputs
from refdem.planning.kept_truth import truth_folder

PAGES = Path(__file__).parents[2] / "reports" / "manual"


def test_the_committed_pages_are_up_to_date() -> None:
    assert inputs.out_of_date(PAGES, truth_folder()) == [], (
        "run `refdem manual reports` and commit reports/manual"
    )


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(inputs, "digests", lambda folder: {"a": "1", "b": "2"})
    for case in "ab":
        (tmp_path / f"{case}.md").write_text("a page")
    (tmp_path / inputs.NAME).write_text(inputs.text_of({"a": "1", "b": "2"}))
    return tmp_path


def test_what_changed_is_missing_or_gone_is_named(
    made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert inputs.out_of_date(made, made) == []
    (made / "c.md").write_text("a page of nothing")
    assert inputs.out_of_date(made, made) == ["c"]
    (made / "c.md").unlink()
    (made / "a.md").unlink()
    assert inputs.out_of_date(made, made) == ["a"]
    monkeypatch.setattr(inputs, "digests", lambda folder: {"a": "1", "b": "3", "d": "4"})
    assert inputs.out_of_date(made, made) == ["a", "b", "d"]


def test_a_digest_knows_certified_values_and_checks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "certified").mkdir()
    before = inputs.digests(tmp_path)
    (tmp_path / "certified" / "pendulum.jsonl").write_text("values")
    after = inputs.digests(tmp_path)
    assert {case for case in before if before[case] != after[case]} == {"pendulum"}
    check = inputs.discovery.check("phase-area")
    monkeypatch.setattr(type(check), "kills", "something else")
    again = inputs.digests(tmp_path)
    changed = {case for case, digest in again.items() if digest != after[case]}
    assert changed == {"phase-flow"}, "a check changes the pages of the cases that it judges alone"
