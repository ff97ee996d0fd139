"""What fuzzing has found, and the tools that find: ci/fuzz, and the inputs in tests/corpus."""

import random

import fuzz
import fuzz_bytes
import fuzz_targets
import pytest


@pytest.fixture(scope="module")
def targets(tmp_path_factory):
    """What is fuzzed, by name."""
    return {one.name: one for one in fuzz_targets.targets(tmp_path_factory.mktemp("seeds"))}


NAMES = [
    "scenes",
    "requests",
    "trajectories",
    "derivatives",
    "events",
    "solids",
    "descriptions",
    "campaigns",
    "deviations",
    "manifests",
    "baselines",
    "lists",
    "records",
    "stores",
    "commands",
]


def test_every_target_is_tried(targets):
    assert list(targets) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_every_input_of_the_corpus_is_refused_by_a_sentence_or_answered_rightly(
    targets, name, tmp_path
):
    for data in [*targets[name].seeds, *targets[name].corpus]:
        targets[name].ends(data, tmp_path)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "commands"])
def test_good_inputs_are_taken(targets, name, tmp_path):
    for data in targets[name].seeds:
        assert targets[name].ends(data, tmp_path) == ""


def test_the_same_seed_makes_the_same_inputs(targets):
    def made():
        draw = random.Random(7)
        return [fuzz_bytes.mutated(targets["scenes"].seeds, draw) for _ in range(200)]

    assert made() == made()


def broken(_, __):
    raise KeyError("lost")


@pytest.mark.parametrize("judge", [broken, "careless"])
def test_a_traceback_and_what_is_ignored_are_findings_and_are_kept(tmp_path, monkeypatch, judge):

    def careless(data, _):
        fuzz_targets.kept({"a": 1, "lost": data.decode()}, {"a": 1})

    monkeypatch.setattr(fuzz_targets, "CORPUS", tmp_path / "corpus")
    target = fuzz_targets.Target("own", [b"seed"], careless if judge == "careless" else judge)
    run = fuzz.Fuzz([target], tmp_path, grows=False)
    run.tried(target, b"input")
    run.tried(target, b"other")
    assert run.tallies["own"].findings.total() == 2
    assert len(run.tallies["own"].findings) == 1
    (kept,) = (tmp_path / "corpus" / "own").iterdir()
    assert kept.read_bytes() == b"input"


def test_an_input_that_never_ends_is_a_finding(tmp_path, monkeypatch):

    def endless(_, __):
        while True:
            pass

    monkeypatch.setattr(fuzz, "HANGING", 1)
    monkeypatch.setattr(fuzz_targets, "CORPUS", tmp_path / "corpus")
    target = fuzz_targets.Target("own", [b"seed"], endless)
    run = fuzz.Fuzz([target], tmp_path, grows=False)
    run.tried(target, b"input")
    (name,) = run.tallies["own"].findings
    assert name.startswith("HangError")
