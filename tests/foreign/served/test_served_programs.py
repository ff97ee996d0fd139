"""Campaigns, gates and exports of programs that stay alive, in Python and C: the same records as of
one process a run, errors that cost one run, and nothing that is left running.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.processes import processes

HERE = Path(__file__).parent
PATIENCE = 120.0
"""Seconds within which a process is there or gone, on any machine."""
PYTHON = [sys.executable, "program.py"]
SERVED = "serve = true\n"
Command = Callable[..., "subprocess.CompletedProcess[str]"]


def described(folder: Path, command: list[str], *, more: str = SERVED, methods=("good",)) -> Path:
    """The refdem.toml of a program in `folder`."""
    tables = "".join(
        f'[[engine.methods]]\nname = "{name}"\norder = 2\nsymplectic = true\nreversible = true\n'
        for name in methods
    )
    path = folder / "refdem.toml"
    path.write_text(
        f'[engine]\nname = "springs"\ncommand = {json.dumps(command)}\n'
        f'supports = ["spring", "dimension:1"]\n{more}\n{tables}\n'
        '[gate]\ncases = ["harmonic-oscillator"]\nlevels = 3\n'
    )
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with both programs."""
    place = tmp_path / "springs"
    shutil.copytree(HERE.parent / "c", tmp_path / "c")
    shutil.copytree(HERE, place, ignore=shutil.ignore_patterns("__pycache__"))
    return place


@pytest.fixture
def refdem(tmp_path: Path, command_line: Command) -> Command:
    """The command line, with a store of the test's own."""
    environment = os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}

    def run(*words: str, **more: object) -> "subprocess.CompletedProcess[str]":
        return command_line(*words, env=environment, **more)

    return run


def compiled(folder: Path) -> str:
    """The C program."""
    flags = ["-std=c11", "-D_DEFAULT_SOURCE", "-O1", "-Wall", "-Wextra", "-Werror"]
    command = ["gcc", *flags, "-o", "springs", "springs.c", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return "./springs"


def records(folder: Path) -> list[dict[str, Any]]:
    """The findings in a report, without the seconds that runs took."""
    found = []
    for line in (folder / "records.jsonl").read_text().splitlines():
        sheet = json.loads(line)
        if sheet["type"] != "record":
            continue
        for finding in sheet["findings"]:
            for level in finding["levels"]:
                del level["seconds"]
        found.append({name: sheet[name] for name in ("label", "method", "findings")})
    return found


@pytest.mark.parametrize("language", ["python", "c"])
def test_a_program_that_stays_alive_has_the_records_of_one_that_does_not(
    folder: Path, refdem: Command, language: str
) -> None:
    served = PYTHON
    files = ["{request}", "{trajectory}"]
    if language == "c":
        served = [compiled(folder)]
        files = ["{request_txt}", "{trajectory}"]
    found = []
    for name, command, more in (("served", served, SERVED), ("not", [*served, *files], "")):
        described(folder, command, more=more)
        done = refdem("gate", "--out", name, "--jobs", "2", cwd=folder)
        # There is no baseline yet, so the gate is closed.
        assert done.returncode == 1, done.stdout + done.stderr
        assert "so the gate fails" in done.stdout
        found.append(records(folder / name))
    assert found[0] == found[1]
    assert {finding["outcome"] for record in found[0] for finding in record["findings"]} == {"pass"}


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_crash_costs_its_run_and_a_leak_is_an_error_of_the_method_that_has_it(
    folder: Path, refdem: Command, jobs: str
) -> None:
    methods = ("good", "crashes", "keeps-velocity", "prints", "half-a-line", "refuses")
    described(folder, PYTHON, methods=methods)
    words = ["harmonic-oscillator", "--engine", "refdem.toml", "--out", "report", "--jobs", jobs]
    done = refdem("run", *words, cwd=folder)
    # 3 where nothing but runs failed: what a method keeps may be seen before it is judged.
    assert done.returncode in (1, 3), done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    outcomes = {
        record["method"]: {finding["outcome"] for finding in record["findings"]}
        for record in records(folder / "report")
    }
    assert outcomes["good"] == {"pass"}
    assert outcomes["refuses"] == {"unsupported"}
    for method in ("crashes", "prints", "half-a-line"):
        assert outcomes[method] == {"error"}
    assert "error" in outcomes["keeps-velocity"]
    # The thread that asked ends its program when it ends itself.
    deadline = time.monotonic() + PATIENCE
    while processes(str(folder / "program.py")):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_what_leaks_is_not_read_from_the_store(folder: Path, refdem: Command) -> None:
    described(folder, PYTHON, methods=("keeps-velocity",))
    words = ["run", "harmonic-oscillator", "--engine", "refdem.toml", "--out", "report"]
    for _ in range(2):
        done = refdem(*words, "--jobs", "1", cwd=folder)
        assert "springs keeps state from one request to the next" in done.stdout
        assert "0 read from the store" in done.stdout


def test_smoke_and_a_blessed_gate_work(folder: Path, refdem: Command) -> None:
    described(folder, [compiled(folder)])
    smoke = refdem("smoke", "refdem.toml", cwd=folder)
    assert smoke.returncode == 0, smoke.stdout
    bless = refdem("gate", "--bless", "--why", "first", cwd=folder)
    assert bless.returncode == 0, bless.stdout + bless.stderr
    gate = refdem("gate", cwd=folder)
    assert (gate.returncode, gate.stdout.splitlines()[-1]) == (0, "the gate of springs is open")


def test_runs_that_are_in_the_store_start_no_program(folder: Path, refdem: Command) -> None:
    described(folder, PYTHON)
    started = folder / "started"
    program = folder / "program.py"
    program.write_text(f'open("{started}", "w").close()\n{program.read_text()}')
    words = ["run", "harmonic-oscillator", "--engine", "refdem.toml", "--out", "report"]
    assert refdem(*words, cwd=folder).returncode == 0
    started.unlink()
    assert refdem(*words, cwd=folder).returncode == 0
    assert not started.exists()


def test_an_export_runs_in_one_process_and_is_judged(
    folder: Path, refdem: Command, tmp_path: Path
) -> None:
    described(folder, [compiled(folder)])
    told = ""
    # The second export has the runs that go on from the end of others.
    for _ in range(2):
        told = refdem("export", str(tmp_path / "runs"), cwd=folder).stdout
        line = told.splitlines()[-1].partition(" < ")
        command = line[0].rpartition(": ")[2]
        requests, _, answers = line[2].partition(" > ")
        with (tmp_path / "runs" / requests).open() as file, (tmp_path / answers).open("a") as out:
            subprocess.run(
                command.split(), stdin=file, stdout=out, cwd=tmp_path / "runs", check=True
            )
    shutil.copy(tmp_path / answers, tmp_path / "runs" / answers)
    judged = refdem("judge", str(tmp_path / "runs"), "--out", "report", cwd=folder)
    assert judged.returncode == 0, judged.stdout + judged.stderr
    refdem("gate", "--out", "gate", cwd=folder)
    assert records(folder / "report") == records(folder / "gate")


def test_a_refusal_comes_back_from_elsewhere(folder: Path, refdem: Command, tmp_path: Path) -> None:
    described(folder, PYTHON, methods=("refuses", "fails"))
    refdem("export", str(tmp_path / "runs"), cwd=folder)
    with (tmp_path / "runs" / "springs-requests.jsonl").open() as requests:
        done = subprocess.run(
            [sys.executable, str(folder / "program.py")],
            stdin=requests,
            capture_output=True,
            cwd=tmp_path / "runs",
            check=True,
        )
    (tmp_path / "runs" / "springs-answers.jsonl").write_bytes(b"a banner\n" + done.stdout)
    refdem("judge", str(tmp_path / "runs"), "--out", "report", cwd=folder)
    sentences = {
        record["method"]: record["findings"][0]["sentence"] for record in records(folder / "report")
    }
    assert "no springs on Saturdays" in sentences["refuses"]
    assert "the solver diverged at t = 3" in sentences["fails"]


def test_a_program_without_requests_ends_well(folder: Path) -> None:
    for command in (PYTHON, [compiled(folder)]):
        done = subprocess.run(
            command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, check=True
        )
        assert done.stdout == b'{"ready": true}\n'


@pytest.mark.parametrize("after", [1, 3, 6])
def test_a_killed_gate_leaves_nothing_running(
    folder: Path, command_line: Command, tmp_path: Path, after: int
) -> None:
    program = folder / "program.py"
    log = folder / "log"
    log.write_text("")
    read = "        asked = json.loads(line)\n"
    slowly = f'        open("{log}", "a").write("asked")\n        time.sleep(0.05)\n'
    program.write_text(program.read_text().replace(read, read + slowly))
    described(folder, PYTHON)
    own = tmp_path / "own"
    own.mkdir()
    environment = os.environ | {
        "TMPDIR": str(own),
        "REFDEM_STORE": str(tmp_path / "store.sqlite"),
    }
    words = ["-c", "from refdem.cli import main; main()", "gate", "--jobs", "2"]
    gate = subprocess.Popen(
        [sys.executable, *words],
        cwd=folder,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    deadline = time.monotonic() + PATIENCE
    while log.read_text().count("asked") < after:
        assert time.monotonic() < deadline
        assert gate.poll() is None
        time.sleep(0.005)
    gate.send_signal(signal.SIGKILL)
    gate.wait()
    while processes(str(program)) or list(own.iterdir()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
