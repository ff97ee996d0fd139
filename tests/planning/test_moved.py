"""What each number of a case moves, against motions known on paper; and who is told of it."""

from fractions import Fraction
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.moved import Moved, MovedLine
from refdem.core.store import Store
from refdem.execution.schedule import InProcess
from refdem.planning import moved
from refdem.planning.moved import moved_at, moved_lines
from refdem.planning.specification import Entry, Specification


def lines_of(name: str, **given: str) -> dict[str, MovedLine]:
    return {line.number: line for line in moved_lines(discovery.case(name).at(**given))}


def test_a_uniform_motion_moves_by_the_time_times_its_velocity() -> None:
    """x = x0 + v t: dx/dv = t, and 1 % more of v moves x by v t/100."""
    instance = discovery.case("newtons-first-law").at()
    lines = lines_of("newtons-first-law")
    time = float(Fraction(moved_at(instance)))
    moving = {number: line for number, line in lines.items() if number.startswith("velocity")}
    assert moving
    for line in moving.values():
        assert line.quantity in ("x", "y", "z")
        assert line.slope == pytest.approx(time, rel=1e-3)
        if line.value:
            scale = instance.quantities[line.quantity].scale
            assert line.share == pytest.approx(abs(line.value) * time / scale, rel=1e-3)


def test_a_border_and_what_changes_nothing_are_told() -> None:
    lines = lines_of("coulomb-oscillator")
    assert not lines["v0"].has_derivative
    assert lines["gravity"].quantity == ""
    assert lines["mass"].quantity in ("x", "v")


def test_the_numbers_of_a_member_are_its_own() -> None:
    lines = lines_of("impact-benchmarks")
    assert lines["restitution"].value == 0.98
    assert lines["restitution"].quantity


def test_a_case_without_time_or_without_derivatives_has_no_lines() -> None:
    assert moved_lines(discovery.case("moments-of-inertia").at()) == ()
    assert moved_lines(discovery.case("granular-gas").at()) == ()


HEAVY = Entry("harmonic-oscillator", {"mass": "2"})


def asked(*entries: Entry) -> Specification:
    return Specification(name="test", case=list(entries))


def test_the_report_of_a_single_case_has_a_sheet_that_is_proved_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    proved = []
    of_case = moved.of_case

    def noted(case: str, given: dict[str, str]) -> bytes:
        proved.append(given)
        return of_case(case, given)

    monkeypatch.setattr(moved, "of_case", noted)
    monkeypatch.setattr(moved, "Schedule", lambda workers, seconds: InProcess())
    store = Store(tmp_path / "store.sqlite")
    (sheet,) = moved.sheets(asked(HEAVY), store)
    assert sheet.label == "harmonic-oscillator[mass=2]"
    assert sheet.command.startswith("refdem truth harmonic-oscillator --set mass=2 --sens")
    assert {line.number for line in sheet.numbers} >= {"mass", "stiffness"}
    assert moved.sheets(asked(HEAVY), store) == [sheet]
    assert proved == [{"mass": "2"}]
    moved.sheets(asked(Entry("harmonic-oscillator")), store)
    assert len(proved) == 2


def test_several_cases_selections_and_questions_without_time_have_none(tmp_path: Path) -> None:
    store = Store(tmp_path / "store.sqlite")
    assert moved.sheets(asked(HEAVY, Entry("pendulum")), store) == []
    assert moved.sheets(asked(Entry("moments-of-inertia")), store) == []
    assert moved.sheets(asked(Entry("time-reversal")), store) == []


def test_a_proof_that_takes_too_long_leaves_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(moved, "SECONDS", 0.5)
    (sheet,) = moved.sheets(asked(Entry("rigid-cluster")), Store(tmp_path / "store.sqlite"))
    assert sheet.numbers == ()
    assert "0.5 s of CPU time" in sheet.reason
    assert isinstance(sheet, Moved)
