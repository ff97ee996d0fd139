"""The digest of a case covers every file that its truth can reach, and none that it cannot."""

from pathlib import Path

import pytest

from refdem.truth.certified import sources


def reached(case: str) -> set[str]:
    return {path.relative_to(sources.ROOT).as_posix() for path in sources.closure(sources.case_files(case))}


def test_it_follows_imports_inside_functions_and_through_others() -> None:
    found = reached("pendulum")
    assert {"cases/pendulum.py", "truth/closed_forms/pendulum.py", "truth/jacobi.py", "truth/balls.py"} <= found
    assert not any("two_body" in name or "witness" in name for name in found)
    assert {"cases/_attitude.py", "truth/free_body.py"} <= reached("free-rigid-body")
    assert {"truth/validated_ivp/integration.py", "truth/validated_ivp/enclosure.py"} <= reached("van-der-pol")


@pytest.mark.parametrize(("name", "stale"), [("truth/balls.py", True), ("cases/pendulum.py", True), ("truth/witness.py", False)])
def test_a_changed_file_changes_the_digest_of_those_that_reach_it(name: str, stale: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    before, content = sources.digest_of("pendulum"), sources._content

    def other(path: Path) -> str:
        return "changed" if path == sources.ROOT / name else content(path)

    monkeypatch.setattr(sources, "_content", other)
    assert (sources.digest_of("pendulum") != before) is stale


def test_a_case_of_another_package_has_no_digest() -> None:
    assert sources.digest_of("somebody-elses") == ""
