"""A page says of its case what the case, the checks and the store say."""

from refdem.core import discovery
from refdem.manual.pages import page
from refdem.truth import load


def test_a_page_has_parameters_quantities_truth_and_checks() -> None:
    case = discovery.case("pendulum")
    sets = load("pendulum")
    found = page(case, sets)
    assert [p.name for p in found.parameters][:2] == ["mass", "length"]
    assert [q.name for q in found.quantities] == ["theta", "thetadot", "x", "y", "rod_force"]
    assert found.scalars[0].mid.startswith("2.1388650815945205866255")
    assert found.truth.values == sum(len(one.values) for one in sets)
    assert found.truth.witnessed == found.truth.values
    assert not found.truth.has_no_witness
    applied = {check.name for check in found.checks}
    assert {"error", "energy", "constraint"} <= applied
    assert all(check.kills for check in found.checks)
    assert "stop" not in applied


def test_a_page_of_a_case_without_sets_says_how_it_would_be_proved() -> None:
    found = page(discovery.case("rotations"), [])
    assert found.truth.sets == 0
    assert found.truth.method
    assert found.slips


def test_a_truth_that_nobody_witnesses_is_shown_as_such(monkeypatch) -> None:
    from refdem.manual import pages
    from refdem.truth.closed_forms.pendulum import Pendulum

    monkeypatch.setattr(pages, "witnesses", dict)
    monkeypatch.setattr(Pendulum, "witness", "none")
    assert page(discovery.case("pendulum"), []).truth.has_no_witness
