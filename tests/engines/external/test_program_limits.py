"""What a run of a program is asked and allowed: its command, its limits, and what a run costs."""

import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from refdem.core import discovery
from refdem.core.answer_csv import most_rows
from refdem.core.problem import Request
from refdem.engines.external import program as program_module
from refdem.engines.external.description import EngineTable, MethodTable
from refdem.engines.external.process import Limits, most_memory
from refdem.engines.external.program import Program

METHODS = [MethodTable(name="a", order=1)]
PROBLEM = discovery.case("harmonic-oscillator").at(samples="8", duration="2").problem


def asked(folder: Path, **table: Any) -> "partial[float]":
    """What a run asks for, before anything is run."""
    engine = EngineTable(name="small", methods=METHODS, **{"command": ["prog"]} | table)
    stages = Program(engine, folder / "refdem.toml")._stages(
        Request(problem=PROBLEM, method="a", step=PROBLEM.interval / 2), folder
    )
    found: partial[float] = next(stages)
    return found


def test_every_placeholder_becomes_the_path_of_its_file(tmp_path: Path) -> None:
    """Also within a word and twice. Other words in braces stay; a relative path becomes full."""
    (tmp_path / "prog").touch()
    words = [
        "prog",
        "{request}",
        "-o={trajectory}",
        "{events}:{events}",
        "{request_txt}",
        "{x}",
        "no",
    ]
    command, folder = asked(tmp_path, command=words).args
    assert folder == tmp_path
    assert command == [
        str(tmp_path / "prog"),
        str(tmp_path / "request.json"),
        f"-o={tmp_path / 'trajectory.csv'}",
        f"{tmp_path / 'events.csv'}:{tmp_path / 'events.csv'}",
        str(tmp_path / "request.txt"),
        "{x}",
        "no",
    ]
    assert (tmp_path / "request.json").is_file()
    assert (tmp_path / "request.txt").is_file()


@pytest.mark.parametrize(("given", "memory"), [(None, most_memory()), (0.5, 5 * 10**8), (2, 2e9)])
def test_limits_are_those_of_the_description_and_of_the_rows(
    tmp_path: Path, given: float | None, memory: float
) -> None:
    """A file may have 64 MiB and a KiB for each row."""
    limits = asked(tmp_path, timeout=7.0, memory=given).keywords["limits"]
    assert limits.timeout == 7.0
    assert limits.file_bytes == 2**26 + 1024 * most_rows(PROBLEM)
    assert limits.memory == memory


@pytest.mark.parametrize(
    ("code", "version"),
    [
        ("print('1.2.3'); print('more')", "1.2.3"),
        ("print(); print('  2.0  ')", "2.0"),
        ("import sys; print('3.1', file=sys.stderr)", "3.1"),
        ("import sys; print('a'); print('b', file=sys.stderr)", "a"),
        ("print('x' * 200)", "x" * 76 + " ..."),
        ("print('1.0'); raise SystemExit(1)", ""),
        ("pass", ""),
    ],
)
def test_a_version_is_the_first_line_that_is_said(tmp_path: Path, code: str, version: str) -> None:
    command = [sys.executable, "-I", "-S", "-c", code]
    table = EngineTable(name="small", command=["p"], methods=METHODS, version_command=command)
    assert Program(table, tmp_path / "refdem.toml").version() == version


def test_a_version_command_has_ten_seconds_64_mebibytes_a_file_and_four_gibibytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[Limits] = []
    monkeypatch.setattr(program_module, "run", lambda *given: told.append(given[-1]))
    table = EngineTable(name="small", command=["p"], methods=METHODS, version_command=["v"])
    with pytest.raises(AttributeError):
        Program(table, tmp_path / "refdem.toml").version()
    assert told == [Limits(timeout=10.0, file_bytes=2**26, memory=2**32)]


def test_a_program_without_a_version_command_has_no_version(tmp_path: Path) -> None:
    table = EngineTable(name="small", command=["p"], methods=METHODS)
    assert Program(table, tmp_path / "refdem.toml").version() == ""
