"""Kept samples say the same as a new proof, are rounded outward, and are taken only where nothing
has changed.
"""

import shutil
from pathlib import Path
from random import Random

import pytest

from refdem.certification.reproof import damaged
from refdem.core import discovery
from refdem.core.truth import SampledTruth
from refdem.errors import StoreError
from refdem.planning import kept_truth as kept_truths
from refdem.planning.kept_truth import kept_truth, samples_key, truth_folder
from refdem.truth.certified import samples
from refdem.truth.certified.sources import digest_of
from refdem.truth.sampled import sampled

CASE = "harmonic-oscillator"


@pytest.fixture
def truth() -> SampledTruth:
    instance = discovery.case(CASE).at()
    return sampled(instance.truth(), instance.times.tolist())


@pytest.fixture
def folder(tmp_path: Path, truth: SampledTruth) -> Path:
    instance = discovery.case(CASE).at()
    home = tmp_path / "samples"
    home.mkdir()
    (home / f"{CASE}.jsonl").write_bytes(
        samples.line_of(instance.label, samples_key(instance), digest_of(CASE), truth)
    )
    return tmp_path


def test_what_is_kept_is_the_truth_rounded_outward(folder: Path, truth: SampledTruth) -> None:
    found = kept_truth(discovery.case(CASE).at(), folder)
    assert found is not None
    assert found.values == truth.values
    assert (found.until, found.t, found.method, found.printed) == (
        truth.until,
        truth.t,
        truth.method,
        truth.printed,
    )
    for name, radii in truth.radii.items():
        # sharp: exact arithmetic: radii as they are written and read
        assert all(
            old <= new <= 1.01 * old for new, old in zip(found.radii[name], radii, strict=True)
        )
    assert all(
        old <= new <= 1.01 * old
        for new, old in zip(found.sensitivity, truth.sensitivity, strict=True)
    )


def test_rounding_never_goes_down() -> None:
    for value in (
        0.0,
        1.0,
        9.994e-17,
        9.996e-17,
        5.5511151231257827e-17,
        1.0001,
        1.0049999,
        1.005,
        2.0**-1000,
        123456.0,
    ):
        assert value <= samples.rounded_up(value) <= value * 1.01


def test_other_parameters_times_or_code_are_proved_anew(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = discovery.case(CASE)
    assert kept_truth(case.at(mass="2"), folder) is None
    assert kept_truth(case.at(samples="63"), folder) is None
    monkeypatch.setattr(kept_truths, "digest_of", lambda case: "another")
    assert kept_truth(case.at(), folder) is None


def test_a_damaged_file_is_said_and_not_read(folder: Path) -> None:
    path = folder / "samples" / f"{CASE}.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"until":65', b'"until":64'))
    with pytest.raises(StoreError, match=r"line 1: .*make certify"):
        kept_truth(discovery.case(CASE).at(), folder)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(StoreError, match="make certify"):
        kept_truth(discovery.case(CASE).at(), folder)


def test_whatever_is_done_to_a_file_of_samples_is_a_store_error_or_changes_nothing(
    folder: Path,
) -> None:
    """Seeded: a bit flipped, a byte dropped or put in, the rest cut off; also in what is not the
    truth itself.
    """
    random = Random("spoiled samples")
    path = folder / "samples" / f"{CASE}.jsonl"
    whole = path.read_bytes()
    as_it_was = samples.kept(path.parent, CASE)
    told = []
    for _ in range(300):
        at = random.choice([random.randrange(300), random.randrange(len(whole))])
        flipped = whole[:at] + bytes([whole[at] ^ 1 << random.randrange(8)]) + whole[at + 1 :]
        dropped = whole[:at] + whole[at + 1 :]
        path.write_bytes(
            random.choice([flipped, dropped, whole[:at] + b"7" + whole[at:], whole[:at]])
        )
        try:
            assert samples.kept(path.parent, CASE) in (as_it_was, [])
        except StoreError as error:
            told.append(str(error))
    assert len(told) > 280
    assert all(f"{CASE}.jsonl, line " in one for one in told)


@pytest.mark.parametrize("old", ['"label":"', '"key":"', '"source":"', '"job":"', '"method":"'])
def test_every_member_of_a_line_is_under_its_digest(folder: Path, old: str) -> None:
    path = folder / "samples" / f"{CASE}.jsonl"
    path.write_text(path.read_text().replace(old, old + "0", 1))
    with pytest.raises(StoreError, match="line 1: the sha256"):
        samples.kept(path.parent, CASE)


def test_a_file_of_samples_that_is_gone_is_missed(tmp_path: Path) -> None:
    shutil.copytree(truth_folder(), tmp_path / "truth")
    assert damaged(tmp_path / "truth") == []
    (tmp_path / "truth" / "samples" / "two-spheres.jsonl").unlink()
    (found,) = damaged(tmp_path / "truth")
    assert "two-spheres.jsonl: missing" in found
