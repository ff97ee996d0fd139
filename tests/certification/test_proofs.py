"""The store is rebuilt where something changed, goes on after a kill, and is proved again by
overlap.
"""

import json
import os
from pathlib import Path

import pytest

from refdem.certification import proofs, reproof
from refdem.certification.proofs import Certification, Certified, stale, wanted_sets
from refdem.core.store import Store
from refdem.errors import UsageError
from refdem.truth import load
from refdem.truth.certified import reader, writing
from refdem.truth.certified.listing import listing

SETS = """
[[harmonic-oscillator]]
times = "1/3, 2"
sets = [{}, { mass = "2" }]

[[pendulum]]
times = "1/2"
sets = [{ theta0 = "0", thetadot0 = "1" }]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "sets.toml").write_text(SETS)
    return tmp_path


def certified(folder: Path, *cases: str, jobs: int = 1, cache: str = "store.sqlite") -> Certified:
    outcome = Certification(folder, Store(folder / cache), jobs).run(cases)
    assert outcome.problems == ()
    return outcome


def test_what_is_proved_is_kept_and_what_changed_is_proved_again(folder: Path) -> None:
    assert certified(folder).made == 3
    before = (folder / "certified" / "pendulum.jsonl").read_bytes()
    assert {one.label for one in load(folder=folder / "certified")} == {
        one.instance.label for one in wanted_sets(folder)
    }
    assert stale(folder) == []
    assert reproof.damaged(folder) == []
    assert certified(folder).made == 0
    (folder / "sets.toml").write_text(SETS.replace('mass = "2"', 'mass = "3"'))
    assert stale(folder) == ["harmonic-oscillator[mass=2]", "harmonic-oscillator[mass=3]"]
    assert certified(folder).made == 1
    assert stale(folder) == []
    assert (folder / "certified" / "pendulum.jsonl").read_bytes() == before


def test_a_pipe_in_place_of_the_list_of_sets_is_not_waited_for(folder: Path) -> None:
    (folder / "sets.toml").unlink()
    os.mkfifo(folder / "sets.toml")
    with pytest.raises(UsageError, match=r"sets\.toml: a pipe .* expected a list of sets"):
        wanted_sets(folder)


def test_with_an_empty_cache_what_is_in_the_folder_is_kept_and_what_is_stale_is_proved(
    folder: Path,
) -> None:
    (folder / "sets.toml").write_text('samples-of = ["harmonic-oscillator"]\n' + SETS)
    assert certified(folder).made > 3
    before = contents(folder)
    assert certified(folder, cache="empty-1.sqlite").made == 0
    assert contents(folder) == before
    spoil(folder / "certified" / "pendulum.jsonl")
    assert certified(folder, cache="empty-2.sqlite").made == 1
    assert contents(folder) == before
    spoil(folder / "samples" / "harmonic-oscillator.jsonl")
    made = certified(folder, cache="empty-3.sqlite").made
    assert made == len(before["samples", "harmonic-oscillator.jsonl"].splitlines())
    assert contents(folder) == before
    assert stale(folder) == []


def contents(folder: Path) -> dict[tuple[str, str], bytes]:
    """Every file of the store."""
    return {
        (home, path.name): path.read_bytes()
        for home in ("certified", "samples")
        for path in (folder / home).iterdir()
    }


def spoil(path: Path) -> None:
    """Changes the digest of the job in the first line that has one, as code that changed does."""
    text = path.read_text()
    assert '"job":"' in text
    path.write_text(text.replace('"job":"', '"job":"0', 1))


def test_a_job_is_another_one_when_anything_that_it_rests_on_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def digest(
        kind: str = "set", label: str = "pendulum", times: tuple[str, ...] = ("1",), mass: str = "1"
    ) -> str:
        return proofs.job_digest(kind, label, ("pendulum", {"mass": mass}, times))

    before = digest()
    others = [
        digest(kind="samples"),
        digest(label="another"),
        digest(times=("1", "2")),
        digest(mass="2"),
    ]
    monkeypatch.setattr(proofs, "digest_of", lambda case: "another truth")
    others.append(digest())
    monkeypatch.undo()
    monkeypatch.setattr(proofs, "digest_of_files", lambda paths: "another writer or witness")
    others.append(digest())
    assert len({before, *others}) == 7


def test_only_the_cases_asked_for_are_written(folder: Path) -> None:
    certified(folder)
    (folder / "certified" / "harmonic-oscillator.jsonl").write_text("mine\n")
    assert certified(folder, "pendulum").made == 0
    assert (folder / "certified" / "harmonic-oscillator.jsonl").read_text() == "mine\n"
    with pytest.raises(UsageError, match="no sets of case 'duffing'"):
        certified(folder, "duffing")


def test_a_killed_run_goes_on_where_it_was(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def killed(stage: str, done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    work = Certification(folder, Store(folder / "store.sqlite"), 1, progress=killed)
    with pytest.raises(KeyboardInterrupt):
        work.run()
    assert not (folder / "certified").exists()
    assert certified(folder).made == 1


def test_a_set_is_not_there_twice(folder: Path) -> None:
    (folder / "sets.toml").write_text(
        SETS + SETS.replace("pendulum", "duffing").replace("theta0", "x").split("[[duffing]]")[0]
    )
    with pytest.raises(UsageError, match="harmonic-oscillator is there twice"):
        wanted_sets(folder)


def test_what_a_new_proof_does_not_confirm_is_named(folder: Path) -> None:
    certified(folder)
    sets = load(folder=folder / "certified")
    assert list(reproof.contradictions(sets, jobs=1, progress=lambda *told: None)) == []
    path = folder / "certified" / "harmonic-oscillator.jsonl"
    text = path.read_text()
    line = next(line for line in text.splitlines() if line.startswith('["1/3","x"'))
    t, name, mid, radius, _ = json.loads(line)
    wrong = mid[:30] + str((int(mid[30]) + 1) % 10) + mid[31:]
    blocks = writing.blocks_in(
        text.replace(line, json.dumps([t, name, wrong, radius, None], separators=(",", ":")), 1)
    )
    path.write_text(
        writing.file_text("harmonic-oscillator", [writing.sealed(block) for block in blocks])
    )
    assert reproof.damaged(folder) == ["harmonic-oscillator.jsonl: not as sha256sums.txt has it"]
    listed = {name.name: name.read_text() for name in (folder / "certified").glob("*.jsonl")}
    (folder / "certified" / reader.LIST).write_text(listing(listed))
    (found,) = reproof.contradictions(
        load("harmonic-oscillator", folder=folder / "certified"),
        jobs=1,
        progress=lambda *told: None,
    )
    assert "harmonic-oscillator: x at 1/3" in found


def test_the_sample_has_every_case_and_method() -> None:
    sets = load()
    chosen = reproof.sample(sets, each=1, seed="1")
    assert {(one.case, one.method) for one in chosen} == {(one.case, one.method) for one in sets}
    assert len(chosen) == len({(one.case, one.method) for one in sets})
    assert [one.label for one in chosen] != [
        one.label for one in reproof.sample(sets, each=1, seed="2")
    ]


def test_a_witness_that_denies_stops_the_set(monkeypatch: pytest.MonkeyPatch) -> None:
    from refdem.truth.witnesses import cross_check, oscillators

    other = oscillators.of(
        lambda p: lambda t, x, v: -p["stiffness"] / p["mass"] * x * (1 + t * 10**-20),
        "mass",
        "stiffness",
    )
    monkeypatch.setattr(cross_check, "witnesses", lambda: {"harmonic-oscillator": other})
    found = json.loads(proofs.proved_set("harmonic-oscillator", {}, ("2",)))
    assert found["lines"] == []
    assert "does not confirm" in found["reason"]
