"""refdem explain: a proof has a limit, and what it certified until then is kept."""

from pathlib import Path
from typing import get_args

import pytest

from refdem.cli.explain import command
from refdem.engines.external.description import Law
from refdem.engines.external.features import FEATURES, KEPT, MEANINGS
from refdem.errors import UsageError


def test_a_proof_that_is_not_done_in_its_time_is_told_and_the_rest_is_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    # Two rods that tumble for 200 s: no proof gets there within days.
    command("double-pendulum", engine=["reference"], set=["duration=200"], timeout=1.0)
    shown = capsys.readouterr().out
    assert "of 65 samples: the proof ended in a hang" in shown
    assert "reference/rod-chain: " in shown


def test_what_is_proved_once_is_read_the_next_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    for times in range(2):
        command("pendulum", engine=["reference"], set=["theta0=0.3", "duration=1"])
        said = capsys.readouterr()
        assert "reference/exact-pendulum: " in said.out
        assert ("truths: 1 done" in said.err) == (times == 0)


def test_a_reason_that_refuses_several_methods_is_told_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    command("pendulum", engine=["reference"], set=["theta0=0.3", "duration=1"])
    shown = capsys.readouterr().out
    refused = [line for line in shown.splitlines() if "not supported" in line]
    (rod,) = [line for line in refused if "an element of kind rod (" in line]
    assert "exact-coulomb" in rod
    assert "exact-free-body" in rod
    assert "finer runs only where these do not decide: order, reversal, symmetry" in shown


def test_every_word_of_supports_and_conserves_has_a_meaning(
    capsys: pytest.CaptureFixture[str],
) -> None:
    command("", features=True)
    shown = capsys.readouterr().out
    assert MEANINGS.keys() == FEATURES
    assert KEPT.keys() == set(get_args(Law))
    for name, meaning in (MEANINGS | KEPT).items():
        assert f"  {name:32}{meaning}" in shown.splitlines()
    assert max(map(len, shown.splitlines())) <= 110


@pytest.mark.parametrize(("case", "features"), [("", False), ("pendulum", True)])
def test_a_case_or_the_words_are_asked_for(case: str, features: bool) -> None:
    with pytest.raises(UsageError, match=r"expected a case .* or --features alone"):
        command(case, features=features)
