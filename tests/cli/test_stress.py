"""The command from end to end: exit status, JSON, pages; programs with a refdem.toml; crashes and
hangs that cost one point.
"""

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
import typer

from refdem.cli.schema import command as schema
from refdem.cli.stress import command, status
from refdem.errors import UsageError
from refdem.stress.record import MethodSweep, Point, StressRecord, read

DEFAULT: dict[str, Any] = {
    "require": False,
    "longest": 5.0,
    "timeout": 20.0,
    "jobs": 1,
    "json": False,
    "method": "",
    "case": None,
}
PROGRAM = """
import os, sys, time
asked = dict(line.split(maxsplit=1) for line in open(sys.argv[1]))
h, k = float(asked["step"]), float(asked["scene.elements.0.stiffness"])
x, v = float(asked["scene.bodies.0.position.0"]), float(asked["scene.bodies.0.velocity.0"])
if k > 1e7:
    os.abort()
if k > 1e5:
    time.sleep(600)
with open(sys.argv[2], "w") as out:
    print("t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz", file=out)
    for n in range(int(asked["times.count"])):
        for _ in range(int(asked["stride"]) if n else 0):
            v -= h / 2 * k * x
            x += h * v
            v -= h / 2 * k * x
        print(asked[f"times.{n}"].strip(), 0, x, 0, 0, v, 0, 0, *[""] * 7, sep=",", file=out)
"""
TOML = f"""
[engine]
name = "springs"
command = ["{sys.executable}", "springs.py", "{{request_txt}}", "{{trajectory}}"]
inputs = ["springs.py"]
supports = ["spring"]
timeout = 6
[[engine.methods]]
name = "verlet"
order = 2
symplectic = true
"""


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))


@pytest.fixture
def ended(tmp_path: Path) -> Callable[..., int]:
    def run(**options: Any) -> int:
        with pytest.raises(typer.Exit) as end:
            command(out=tmp_path / "out", **(DEFAULT | options))
        return end.value.exit_code

    return run


def test_a_stress_test_writes_its_record_and_its_pages(
    ended: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        ended(
            engine=["reference"],
            battery=["step-limit"],
            method="velocity-verlet",
            case=["harmonic-oscillator"],
        )
        == 0
    )
    record = read(tmp_path / "out" / "stress.json")
    (result,) = record.results
    assert (result.holds, result.breaks, result.kept) == (0.99, 1.01, True)
    assert "holds to 0.99" in capsys.readouterr().out
    text = (tmp_path / "out" / "stress.md").read_text()
    assert "| 0.99 | fail at 1.01, but" not in text
    assert "fail at 1.01" in text
    assert "spec-stress-step-limit" in (tmp_path / "out" / "stress.html").read_text()
    assert (tmp_path / "out" / "figures" / "stress-step-limit.svg").read_text().startswith("<svg")


def test_the_record_is_what_the_schema_says(
    ended: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    schema("stress")
    shown = json.loads(capsys.readouterr().out)
    assert {"results", "batteries"} <= set(shown["$defs"]["StressRecord"]["properties"])
    ended(
        engine=["reference"],
        battery=["step-limit"],
        method="rk4",
        case=["harmonic-oscillator"],
        json=True,
    )
    msgspec.json.decode(capsys.readouterr().out, type=StressRecord)


def test_a_program_is_stressed_by_its_refdem_toml_and_a_crash_or_a_hang_costs_one_point(
    ended: Callable[..., int], tmp_path: Path
) -> None:
    (tmp_path / "springs.py").write_text(PROGRAM)
    (tmp_path / "refdem.toml").write_text(TOML)
    asked = {
        "engine": [str(tmp_path / "refdem.toml")],
        "battery": ["stiffness"],
        "case": ["harmonic-oscillator"],
    }
    assert ended(**asked) == 0
    harder, softer = read(tmp_path / "out" / "stress.json").results
    assert [point.verdict for point in harder.points] == ["pass", "pass", "error", "error", "error"]
    assert "still running" in harder.points[2].sentence
    assert "still running" not in harder.points[4].sentence
    assert softer.holds == 1e-12
    assert ended(**asked, require=True) == 3


def test_what_has_no_sweep_is_refused_with_what_there_is(ended: Callable[..., int]) -> None:
    with pytest.raises(UsageError, match="no sweep of stiffness is on captured-mass"):
        ended(engine=["reference"], battery=["stiffness"], case=["captured-mass"])
    with pytest.raises(UsageError, match="did you mean 'stiffness'"):
        ended(engine=["reference"], battery=["stifness"])


def test_general_sweeps_are_put_on_any_motion(ended: Callable[..., int], tmp_path: Path) -> None:
    assert ended(engine=["reference"], battery=["frame"], case=["captured-mass[speed=2]"]) == 0
    record = read(tmp_path / "out" / "stress.json")
    assert {result.sweep for result in record.results} >= {
        "far away: captured-mass[speed=2]",
        "turned: captured-mass[speed=2]",
    }
    assert all(result.required is None for result in record.results)


@pytest.mark.parametrize(("verdict", "expected"), [("fail", 1), ("undecided", 1), ("error", 3)])
def test_exit_status(verdict: Any, expected: int) -> None:
    points = [Point(point="1", verdict=verdict)]
    result = MethodSweep(
        battery="b",
        sweep="l",
        label="c",
        along="x",
        engine="e",
        version="",
        method="m",
        is_reference=True,
        points=points,
        kept=False,
    )
    record = StressRecord(refdem="0", longest=1.0, batteries=[], results=[result])
    assert status(record) == expected


@pytest.mark.parametrize("verdict", ["fail", "error", "pass"])
def test_a_breaking_point_that_nobody_promised_is_no_failure(verdict: Any) -> None:
    points = [Point(point="1", verdict=verdict)]
    result = MethodSweep(
        battery="b",
        sweep="l",
        label="c",
        along="x",
        engine="e",
        version="",
        method="m",
        is_reference=True,
        points=points,
        kept=None,
    )
    assert status(StressRecord(refdem="0", longest=1.0, batteries=[], results=[result])) == 0


def test_a_file_that_is_no_record_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"No such file .* expected a stress\.json"):
        read(tmp_path / "stress.json")
    os.mkfifo(tmp_path / "pipe.json")
    with pytest.raises(UsageError, match=r"a pipe .* expected a stress\.json"):
        read(tmp_path / "pipe.json")
    (tmp_path / "stress.json").write_text("{}")
    with pytest.raises(UsageError, match="not a record of a stress test"):
        read(tmp_path / "stress.json")
