"""Bad input: one clear sentence, exit 2, no traceback, nothing lost."""

import os
import signal
import subprocess
import sys
from functools import partial

import pytest


def refdem(*arguments, **more):
    command = [sys.executable, "-c", "from refdem.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, **more)


@pytest.fixture(autouse=True)
def _own_store(tmp_path, monkeypatch):
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "pendulun"], "did you mean 'pendulum'"),
        (["run", "pendulum", "--engine", "mujoko"], "did you mean 'mujoco'"),
        (["run", "pendulum", "--set", "thet0=1"], "did you mean 'theta0'"),
        (["run", "pendulum", "--set", "theta0"], "name=value"),
        (["run", "pendulum", "--set", "mass=-1"], "> 0"),
        (["run", "pendulum", "--set", "mass=nan"], "finite"),
        (["run", "free-rigid-body", "--set", "inertia=1,1,9"], "triangle"),
        (["run", "free-rigid-body", "--set", "inertia=1,1"], "expected 3"),
        (["run", "free-rigid-body", "--set", "attitude=0,0,0,0"], "quaternion"),
        (
            ["run", "pendulum", "--engine", "reference", "--method", "rattel"],
            "did you mean 'rattle'",
        ),
        (["run", "pendulum", "--method", "rattel"], "did you mean 'rattle'"),
        (["run", "pendulum", "--step", "0"], "expected a finite number"),
        (["run", "pendulum", "--step", "nan"], "expected a finite number"),
        (["run", "pendulum", "--jobs", "-1"], "--jobs"),
        (["run", "pendulum", "--jobs", "0"], "--jobs"),
        (["run", "pendulum", "--scheduler", ""], "--scheduler is empty"),
        (["gate", "nowhere/refdem.toml"], "nowhere"),
        (["run", "pendulum", "--set", "theta0=1", "--set", "theta0=2"], "twice"),
        (["run", "pendulum", "--set", "theta0=1e400"], "between 1e-100 and 1e100"),
        (["run", "pendulum", "--set", "theta0="], "name=value"),
        (["run", "pendulum", "--set", "samples=2.5"], "whole"),
        (["run", "pendulum", "--set", "duration=1e-30"], "times tau"),
        (["run", "pendulum", "--set", "duration=1e90"], "times tau"),
        (["run", "pendulum", "--engine", "reference", "--step", "1e-300"], "expected at most"),
        (["run", "p\u00e9ndulo"], "is not a valid name"),
        (["run", ""], "is not a valid name"),
        (["truth", "pendulum", "--set", "mass=1e-400"], "between 1e-100 and 1e100"),
        (["smoke", ""], "no engine"),
        (["run", "--set", "mass=1"], "requires a case"),
        (["run", "--campaign", "mian"], "did you mean 'main'?"),
        (["run", "--campaign", "zzz"], "ends in .toml, was expected); known: full, gate, main"),
        (["run", "--campaign", "x" * 300 + ".toml"], "no campaign"),
        (["run", "--campaign", "a\0b.toml"], "no campaign"),
        (["gate", "x" * 300], "File name too long"),
        (["run", "pendulum", "--campaign", "nope"], "no campaign 'nope'"),
        (["certify", "--check", "pendulm"], "did you mean 'pendulum'"),
        (["gate", "--markdown", "nowhere/gate.md"], "--markdown cannot be written"),
        (["gate", "--sarif", "nowhere/gate.sarif"], "--sarif cannot be written"),
        (["gate", "--junit", "nowhere/gate.xml"], "--junit cannot be written"),
        (["run", "--campaign", "mine/of/mine.toml"], "no campaign 'mine/of/mine.toml'"),
        (["run", "pendulum; rm -rf /"], "is not a valid name"),
        (["truth", "pendulum", "--at", "-1"], "--at"),
        (["truth", "pendulum", "--at", "1e999"], "--at"),
        (["truth", "time-reversal"], "selection"),
        (["list", "casess"], "no case matches 'casess'; `refdem list cases`"),
        (["schema", "nothing"], "expected"),
        (["report", "nowhere"], "nowhere"),
    ],
)
def test_bad_input_is_one_clear_sentence(command_line, arguments, says):
    done = command_line(*arguments)
    assert done.returncode == 2, done.stderr
    assert says in done.stderr
    assert "Traceback" not in done.stderr


def test_an_engine_that_is_not_installed_is_named_with_what_to_install(tmp_path):
    (tmp_path / "blocked").mkdir()
    (tmp_path / "blocked" / "sitecustomize.py").write_text(
        "import importlib.util as u\nfind = u.find_spec\nu.find_spec = lambda n, p=None: None if n"
        " == 'mujoco' else find(n, p)\n"
    )
    done = refdem(
        "run",
        "pendulum",
        "--engine",
        "mujoco",
        env=os.environ | {"PYTHONPATH": str(tmp_path / "blocked")},
    )
    assert done.returncode == 2
    assert "not installed" in done.stderr
    assert "pip install" in done.stderr


def test_a_corrupt_store_costs_a_line_and_nothing_of_it_is_lost(command_line, tmp_path):
    store = tmp_path / "store.sqlite"
    store.write_bytes(b"garbage" * 1000)
    done = command_line(
        "run", "harmonic-oscillator", "--engine", "reference", "--out", str(tmp_path / "report")
    )
    assert done.returncode == 0, done.stderr
    assert "was damaged" in done.stderr
    assert (tmp_path / "store.sqlite.damaged").read_bytes() == b"garbage" * 1000


def test_a_folder_that_cannot_be_written_is_said_so_before_any_work(command_line, tmp_path):
    (tmp_path / "file").write_text("mine")
    done = command_line(
        "run",
        "harmonic-oscillator",
        "--engine",
        "reference",
        "--out",
        str(tmp_path / "file" / "report"),
    )
    assert done.returncode == 2
    assert "cannot be written" in done.stderr
    assert not (tmp_path / "store.sqlite").exists()


def test_a_reader_that_goes_away_is_neither_a_pass_nor_a_failure():
    command = [
        sys.executable,
        "-c",
        "from refdem.cli import main; main()",
        "list",
        "cases",
        "--json",
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as done:
        done.stdout.close()
        said = done.stderr.read()
    assert (done.returncode, said) == (141, b"")


def test_an_interrupted_run_ends_with_130_and_goes_on_where_it_was(tmp_path):
    case = (  # takes MuJoCo many seconds: the interrupt comes in time
        "intermediate-axis[duration=100]"
    )
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
    store = tmp_path / "store.sqlite"
    heard = partial(
        signal.signal, signal.SIGINT, signal.SIG_DFL
    )  # a shell in the background passes on that it is ignored
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heard
    ) as begun:
        for line in begun.stderr:
            if line.startswith("truths: 1 done"):
                begun.send_signal(signal.SIGINT)
                break
        said = begun.stderr.read()
    assert begun.returncode == 130
    assert "refdem: interrupted" in said
    assert "Traceback" not in said
    assert store.exists()
    again = refdem("run", case, "--engine", "reference", "--jobs", "1")
    assert again.returncode == 0, again.stderr
    assert "truths" not in again.stderr
