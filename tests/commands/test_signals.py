"""However refdem is ended, what it started ends with it, and its exit status says which way it
was.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

PROGRAM = """
import os, subprocess, sys, time
sleeps = [sys.executable, "-c", "import time; time.sleep(600)", "{mark}"]
subprocess.Popen(sleeps, start_new_session=True)
open("{mark}", "a").close()
time.sleep(600)
"""
TOML = """
[engine]
name = "sleeper"
command = ["{python}", "program.py", "{{request}}", "{{trajectory}}"]
inputs = ["program.py"]
supports = ["spring"]
timeout = 300
[[engine.methods]]
name = "sleeps"
order = 2
[gate]
cases = ["harmonic-oscillator"]
"""
PATIENCE = 120.0
"""Seconds within which processes begin and end, on any machine."""


def marked(mark: str) -> list[str]:
    """Processes that have a word in their command line."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().split(b"\0")
        except OSError:
            continue
        if mark.encode() in words:
            found.append(path.parent.name)
    return found


def eventually(holds: Callable[[], object]) -> bool:
    """Whether something comes to hold while one can wait for it."""
    until = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > until:
            return False
        time.sleep(0.05)
    return True


@pytest.mark.parametrize(
    ("number", "status"),
    [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGKILL, -9)],
)
def test_a_gate_that_is_ended_leaves_no_process_and_no_folder(
    tmp_path: Path, number: signal.Signals, status: int
) -> None:
    mark = str(tmp_path / "begun")
    (tmp_path / "program.py").write_text(PROGRAM.format(mark=mark))
    (tmp_path / "refdem.toml").write_text(TOML.format(python=sys.executable))
    own = tmp_path / "temporary"
    own.mkdir()
    environment = os.environ | {"TMPDIR": str(own), "REFDEM_STORE": str(tmp_path / "store.sqlite")}
    command = [sys.executable, "-c", "from refdem.cli import main; main()", "gate", "--jobs", "2"]

    def as_by_a_shell() -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        # What runs the tests may ignore it, as `nohup` does, and refdem then goes on, as it should.
        signal.signal(signal.SIGHUP, signal.SIG_DFL)

    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, preexec_fn=as_by_a_shell
    ) as gate:
        assert eventually(lambda: Path(mark).exists() and marked(mark)), "the program has begun"
        gate.send_signal(number)
        _, said = gate.communicate(timeout=PATIENCE)
    assert gate.returncode == status
    assert b"Traceback" not in said
    assert eventually(lambda: not marked(mark)), "what the program started has ended"
    assert eventually(lambda: not list(own.glob("refdem-runs-*"))), "the folders of runs are gone"


def test_worker_processes_end_with_a_run_that_is_killed(tmp_path: Path) -> None:
    store = str(tmp_path / "store.sqlite")
    environment = os.environ | {"REFDEM_STORE": store}
    case = "intermediate-axis[duration=100]"  # takes its worker many seconds
    command = [
        sys.executable,
        "-c",
        "from refdem.cli import main; main()",
        "run",
        case,
        "--engine",
        "mujoco",
        "--jobs",
        "1",
    ]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, start_new_session=True
    ) as run:
        assert eventually(lambda: children(run.pid)), "a worker has begun"
        workers = children(run.pid)
        run.kill()
    assert eventually(lambda: not [pid for pid in workers if is_running(pid)]), (
        "the workers have ended"
    )


def children(parent: int) -> list[str]:
    """The worker processes of a process: those that Python has spawned."""
    found = []
    for path in Path("/proc").glob("[0-9]*/status"):
        try:
            is_child = f"PPid:\t{parent}\n" in path.read_text()
            is_worker = b"spawn_main" in (path.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if is_child and is_worker:
            found.append(path.parent.name)
    return found


def is_running(pid: str) -> bool:
    """Whether a process is there and has not ended."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


LOADING = """
import builtins, signal, sys
from refdem.cli import main
before = builtins.__import__


def interrupted(name, *given, **named):
    if name == "typer":
        signal.raise_signal({number})
    return before(name, *given, **named)


builtins.__import__ = interrupted
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
sys.argv = ["refdem", "list", "cases"]
main()
"""


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_an_interrupt_while_refdem_is_still_loading_is_one_sentence(
    number: signal.Signals, status: int
) -> None:
    code = LOADING.format(number=int(number))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (status, "")
    assert done.stderr.startswith("refdem: interrupted")
    assert done.stderr.count("\n") == 1
