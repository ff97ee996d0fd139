"""Parameters that change nothing in the setting asked for: they are told, and only they."""

import json
from pathlib import Path

import msgspec
import pytest
from typer.testing import CliRunner

from refdem.cli.app import app
from refdem.cli.without_effect import (
    at_defaults,
    is_same_truth,
    parameters_without_effect,
    sentences,
    unused,
)
from refdem.core import discovery
from refdem.core.store import Store
from refdem.core.truth import SampledTruth


def instance(case: str, **given: str):
    """A case at these parameters."""
    return discovery.case(case).at(**given)


def truth(value: float, radius: float = 1e-12) -> SampledTruth:
    """A truth of one quantity x that stays where it is."""
    return SampledTruth(
        t=[0.0, 1.0],
        values={"x": [value, value]},
        radii={"x": [radius, radius]},
        sensitivity=[1.0, 1.0],
        scalars={"period": (value, radius)},
        method="",
        witness="",
        until=2,
    )


def test_a_parameter_that_another_one_overrules_does_not_enter_the_scene():
    assert unused(instance("block-on-slope", angle="0.3", slope="0.1")) == ["slope"]
    assert unused(instance("block-on-slope", slope="0.1")) == []


def test_friction_is_not_felt_where_nothing_slips_and_is_where_something_does(tmp_path: Path):
    store = Store(tmp_path / "store.sqlite")
    duration = {"duration": "1", "samples": "8"}
    straight = instance("bouncing-ball", friction="0.3", **duration)
    assert parameters_without_effect(straight, store) == ["friction"]
    assert sentences(straight, store) == [
        "friction=0.3 changes nothing here, against its default 0: the certified motion is the same"
    ]
    oblique = instance("bouncing-ball", friction="0.3", velocity="1,0", **duration)
    assert parameters_without_effect(oblique, store) == []


def test_what_is_asked_of_the_clock_is_no_parameter_of_the_motion():
    asked = instance("pendulum", duration="1", samples="8", mass="2")
    assert list(at_defaults(asked)) == ["mass"]
    assert at_defaults(asked)["mass"].label == "pendulum[duration=1 samples=8]"


def test_truths_are_the_same_within_their_radii():
    scales = {"x": 1.0}
    assert is_same_truth(truth(1.0), truth(1.0), scales)
    assert is_same_truth(truth(1.0), truth(1.0 + 1e-12), scales)
    assert not is_same_truth(truth(1.0), truth(1.0 + 1e-11), scales)


@pytest.mark.parametrize(
    "changes",
    [
        {"until": 1},
        {"values": {"x": [1.0, 1.0 + 1e-11]}},
        {"values": {"y": [1.0, 1.0]}, "radii": {"y": [0.0, 0.0]}},
        {"scalars": {}},
        {"scalars": {"period": (2.0, 1e-12)}},
        # Values that are known so badly say nothing.
        {"radii": {"x": [1e-8, 1e-8]}},
    ],
)
def test_truths_that_differ_anywhere_are_not_the_same(changes):
    assert not is_same_truth(truth(1.0), msgspec.structs.replace(truth(1.0), **changes), {"x": 1.0})


def test_a_run_tells_it_also_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    asked = ["run", "bouncing-ball", "--set", "friction=0.3", "--set", "samples=8"]
    asked += ["--engine", "reference", "--jobs", "1", "--out", str(tmp_path / "report"), "--json"]
    answer = json.loads(CliRunner().invoke(app, asked, catch_exceptions=False).stdout)
    (sentence,) = answer["without_effect"]
    assert sentence.startswith(
        "bouncing-ball[friction=0.3 samples=8]: friction=0.3 changes nothing"
    )


@pytest.mark.parametrize(
    ("case", "given", "is_told"),
    [
        ("bouncing-ball", "friction=0.3", True),
        # A heavier pendulum swings alike, and its rod bears more.
        ("pendulum", "mass=3", False),
    ],
)
def test_certified_values_come_with_what_changes_none_of_them(case, given, is_told):
    asked = ["truth", case, "--set", given, "--at", "1", "--digits", "20"]
    done = CliRunner().invoke(app, asked, catch_exceptions=False)
    assert (f"{given} changes none of these values" in done.stderr) == is_told
    assert "changes" not in done.stdout
