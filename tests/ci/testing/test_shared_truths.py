"""Truths that the tests of a session share: proved once, by the code that is there."""

from pathlib import Path

import msgspec
import pytest
from shared_truths import SharedTruths, proved_once

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.execution import worker
from refdem.planning import in_process, truths


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, str]]:
    """Parameters of the proofs that are made."""
    proofs = []
    prove = worker.sampled_truth

    def counted(case: str, given: dict[str, str]) -> bytes:
        proofs.append(given)
        return prove(case, given)

    monkeypatch.setattr(worker, "sampled_truth", counted)
    return proofs


@pytest.fixture
def instance() -> Instance:
    """One of which no truth comes with refdem."""
    return discovery.case("harmonic-oscillator").at(mass="3", samples="8", duration="1")


def test_a_truth_is_proved_once_and_is_the_one_that_is_proved_alone(
    tmp_path: Path, instance: Instance, asked: list[dict[str, str]]
) -> None:
    first = proved_once(tmp_path, instance)
    again = proved_once(tmp_path, instance)
    assert asked == [dict(instance.p.given)]
    alone = worker.sampled_truth(instance.case.id, instance.p.given)
    assert msgspec.msgpack.encode(first) == msgspec.msgpack.encode(again) == alone
    assert first is not again  # what a test does to one, the next does not see


def test_other_parameters_and_other_code_are_proved_anew(
    tmp_path: Path,
    instance: Instance,
    asked: list[dict[str, str]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    proved_once(tmp_path, instance)
    proved_once(tmp_path, discovery.case("harmonic-oscillator").at(mass="3"))
    assert len(asked) == 2
    monkeypatch.setattr(truths, "_of_case", lambda instance: "other code")
    proved_once(tmp_path, instance)
    assert len(asked) == 3


def test_what_was_begun_and_not_ended_is_proved_by_the_next(
    tmp_path: Path, instance: Instance, asked: list[dict[str, str]]
) -> None:
    place = tmp_path / truths.truth_key(instance)
    place.with_suffix(".unfinished").write_bytes(b"half")
    place.with_suffix(".lock").touch()
    assert proved_once(tmp_path, instance).until == len(instance.times)
    assert len(asked) == 1


def test_a_test_that_changes_code_gets_none(
    request: pytest.FixtureRequest, tmp_path: Path, instance: Instance
) -> None:
    shared = SharedTruths(tmp_path)
    assert shared.available(instance) is None
    shared.pytest_runtest_setup(request.node)
    assert shared.available(instance) is not None
    request.node.fixturenames.append("monkeypatch")
    shared.pytest_runtest_setup(request.node)
    assert shared.available(instance) is None


def test_the_tests_of_this_session_share_theirs(request: pytest.FixtureRequest) -> None:
    shared = request.config.pluginmanager.get_plugin("shared-truths")
    assert in_process.kept_truth == shared.available
