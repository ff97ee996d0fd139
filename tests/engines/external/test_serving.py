"""A program that stays alive: what it does wrong costs one request, says what happened, and what it
keeps from one request to the next is seen.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.outside import one_line
from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.external import serving
from refdem.errors import EngineError, HangError, UnsupportedError, UsageError
from tests.foreign.served import modes
from tests.processes import processes

SERVED = Path(__file__).parents[2] / "foreign" / "served"
PATIENCE = 120.0
"""Seconds within which processes and folders are gone, on any machine."""
METHODS = re.findall(r"^@method\ndef (\w+)", (SERVED / "program.py").read_text(), re.MULTILINE)


def described(folder: Path, start: str = "", more: str = "timeout = 600") -> Path:
    """The refdem.toml of the zoo in a folder."""
    words = [sys.executable, "program.py"]
    if start:
        words.append(start)
    names = ["good", *(name.replace("_", "-") for name in METHODS)]
    tables = "".join(
        f'[[engine.methods]]\nname = "{name}"\norder = 2\nsymplectic = true\nreversible = true\n'
        for name in names
    )
    path = folder / "refdem.toml"
    path.write_text(
        f'[engine]\nname = "small"\ncommand = {words!r}\nserve = true\n'
        f'supports = ["spring", "dimension:1"]\n{more}\n{tables}'
    )
    return path


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of the zoo; its programs end with the test."""
    folder = tmp_path / "small"
    folder.mkdir()
    shutil.copy(SERVED / "program.py", folder / "program.py")
    described(folder)
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "kept" / "store.sqlite"))
    yield folder
    serving.end_served()


def answer(folder: Path, method: str, steps: int = 16, mass: str = "1") -> tuple[Trajectory, Cost]:
    """Trajectory and cost of one run."""
    problem = discovery.case("harmonic-oscillator").at(samples="8", duration="2", mass=mass).problem
    request = Request(problem=problem, method=method, step=problem.interval / steps)
    return discovery.engine(str(folder / "refdem.toml")).run(request)


def ran(folder: Path, method: str, steps: int = 16, mass: str = "1") -> Trajectory:
    """The trajectory of one run."""
    trajectory, _ = answer(folder, method, steps, mass)
    return trajectory


def until_refused(folder: Path, method: str) -> None:
    """Runs a method again and again, for a while."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        ran(folder, method)


def until_gone(word: str) -> bool:
    """Whether processes with a word in their command line go away."""
    deadline = time.monotonic() + PATIENCE
    while processes(word) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not processes(word)


def test_every_method_of_the_zoo_is_tested() -> None:
    assert {name.replace("_", "-") for name in METHODS} == {
        *modes.ERRORS,
        *modes.LATER,
        *modes.SLOW,
        *modes.HARMLESS,
        *modes.KEEPING,
        *modes.OTHERS,
    }


def test_one_process_answers_many_requests_and_the_start_is_told_apart(small: Path) -> None:
    costs = [answer(small, "good", steps)[1] for steps in (16, 32, 64)]
    # The second was asked again in a process that is gone.
    assert len(processes(str(small / "program.py"))) == 1
    assert costs[0].setup > 0
    assert [cost.setup for cost in costs[1:]] == [0.0, 0.0]
    assert [cost.steps for cost in costs] == [128, 256, 512]


def test_the_right_trajectory_comes_back(small: Path) -> None:
    run = ran(small, "good")
    assert np.all(np.abs(run.position[:, 0, 0] - np.cos(run.t)) < 1e-4)
    assert np.all(run.attitude == [1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(("method", "says"), modes.ERRORS.items())
def test_what_goes_wrong_costs_one_request_and_says_so(
    small: Path, method: str, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("refdem.engines.external.program.SPARE", 2**22)
    described(small, more="timeout = 600\nmemory = 0.3")
    ran(small, "good")
    with pytest.raises(EngineError, match=says) as raised:
        ran(small, method)
    sentence = str(raised.value)
    assert one_line(sentence) == sentence
    place = Path(sentence.rpartition("kept in ")[2].rstrip(")"))
    assert (place / "request.json").read_bytes()
    # The next request finds a program.
    assert len(ran(small, "good", 32).t) == 9


@pytest.mark.parametrize(("method", "says"), modes.LATER.items())
def test_what_goes_wrong_between_requests_is_said_at_the_next(
    small: Path, method: str, says: str
) -> None:
    assert len(ran(small, method).t) == 9
    with pytest.raises(EngineError, match=says):
        ran(small, method, 32)
    assert len(ran(small, "good", 64).t) == 9


def test_a_hang_costs_its_request_and_leaves_nothing(small: Path) -> None:
    described(small, more="timeout = 1")
    with pytest.raises(HangError, match="still running after 1 s and was ended"):
        ran(small, "hangs")
    assert until_gone(f"grandchild of {small / 'program.py'}")
    described(small)
    assert len(ran(small, "good", 32).t) == 9


@pytest.mark.parametrize(("method", "says"), modes.SLOW.items())
def test_what_takes_too_long_costs_its_request(small: Path, method: str, says: str) -> None:
    described(small, more="timeout = 1\nwarm_up = 1")
    with pytest.raises(HangError, match=says):
        ran(small, method)
    described(small)
    assert len(ran(small, "good", 32).t) == 9


def test_memory_that_grows_from_request_to_request_is_seen(small: Path) -> None:
    described(small, more="timeout = 600\nmemory = 0.3")
    with pytest.raises(EngineError, match=r"GB of memory and was ended; expected at most 0\.3 GB"):
        until_refused(small, "takes-more-memory-each-time")
    assert len(ran(small, "good", 32).t) == 9


def test_a_program_that_takes_its_request_away_costs_its_request(small: Path) -> None:
    with pytest.raises(EngineError, match=r"wrote no trajectory\.csv"):
        ran(small, "takes-the-folder-of-its-request-away")
    assert len(ran(small, "good", 32).t) == 9


def test_a_request_that_is_interrupted_leaves_its_answer_to_nobody(small: Path) -> None:
    """As Ctrl-C does in a notebook, where the session goes on."""

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 1.0)
        with pytest.raises(KeyboardInterrupt):
            ran(small, "hangs")
    finally:
        signal.signal(signal.SIGALRM, before)
    assert until_gone(f"grandchild of {small / 'program.py'}")
    for steps in (16, 32):
        assert len(ran(small, "good", steps).t) == 9


def test_a_refusal_is_no_error_and_the_process_goes_on(small: Path) -> None:
    ran(small, "good")
    for steps in (16, 32):
        with pytest.raises(UnsupportedError, match=r"^no springs on Saturdays$"):
            ran(small, "refuses", steps)
    assert len(processes(str(small / "program.py"))) == 1


@pytest.mark.parametrize("method", modes.HARMLESS)
def test_what_hurts_nobody_is_judged_as_any_other(small: Path, method: str) -> None:
    described(small, more="timeout = 600\nwarm_up = 600")
    for steps in (16, 32):
        expected = ran(small, "good", steps)
        assert ran(small, method, steps).to_bytes() == expected.to_bytes()
    serving.end_served()
    assert until_gone(str(small / "program.py"))


def test_warming_up_is_no_stepping_and_has_its_own_limit(small: Path) -> None:
    described(small, more="timeout = 600\nwarm_up = 600")
    _, cost = answer(small, "warms-up")
    assert cost.setup >= 0.4
    assert cost.seconds < cost.setup


@pytest.mark.parametrize(
    ("start", "says"),
    [
        ("dies", r"exit status 1 before it was ready .*libphysics\.so\.3 is not there"),
        ("dies-after-half-a-line", r"status 4 before it was ready .*after half a line '\{\"rea'"),
        (
            "banner",
            r"wrote 'PHYSICS 3\.1 \(c\) 1999' as its first line; expected \{\"ready\": true",
        ),
        ("says-no", r"wrote '\{\"ready\": false\}' as its first line"),
        ("no-line-end", r"was not ready after 1 s .*after half a line '\{\"ready\": true\}'"),
        ("silent", r"was not ready after 1 s .*\{\"ready\": true\}.*`start_timeout`"),
    ],
)
def test_what_does_not_start_is_told_apart_and_not_started_for_ever(
    small: Path, start: str, says: str
) -> None:
    patience = 600
    if start in ("silent", "no-line-end"):
        patience = 1
    described(small, start, more=f"timeout = 600\nstart_timeout = {patience}")
    for _ in range(2):
        with pytest.raises(EngineError, match=says) as raised:
            ran(small, "good")
        assert "not started again" not in str(raised.value)
    with pytest.raises(EngineError, match=f"{says}.*it was not started again"):
        ran(small, "good")


def test_a_program_that_guesses_its_requests_is_refused(small: Path) -> None:
    described(small, "never-reads")
    with pytest.raises(EngineError, match="guessed"):
        ran(small, "good")
    with pytest.raises(EngineError, match=r"wrote '\{\"id\": \"2\""):
        ran(small, "good")


@pytest.mark.parametrize(
    ("start", "says"),
    [
        ("twice", r"wrote '\{\"ready\": true\}' as the answer to a request"),
        ("goes", "ended with exit status 6 and did not answer"),
    ],
)
def test_what_goes_wrong_when_it_is_ready_costs_each_request(
    small: Path, start: str, says: str
) -> None:
    described(small, start)
    for steps in (16, 32, 64):
        with pytest.raises(EngineError, match=says):
            ran(small, "good", steps)


def test_a_program_may_say_more_when_it_is_ready(small: Path) -> None:
    described(small, "more-words")
    assert len(ran(small, "good").t) == 9


def test_a_command_that_is_not_there_is_named(small: Path) -> None:
    (small / "program.sh").write_text("#!/no/such/interpreter\n")
    (small / "program.sh").chmod(0o700)
    toml = described(small)
    toml.write_text(re.sub("command = .*", 'command = ["./program.sh"]', toml.read_text()))
    with pytest.raises(EngineError, match=r"cannot be started: .*No such file"):
        ran(small, "good")


# State that is kept ---------------------------------------------------------------------------


@pytest.mark.parametrize(("method", "says"), modes.KEEPING.items())
def test_state_that_is_kept_is_seen(small: Path, method: str, says: str) -> None:
    ran(small, method)
    with pytest.raises(EngineError, match=f"keeps state .*{says}") as raised:
        ran(small, method, 32, mass="4")
    assert f"The request before it: method {method} on 1 body with" in str(raised.value)
    place = Path(str(raised.value).rpartition("kept in ")[2].rstrip(")"))
    before = Request.from_json((place / "request-before.json").read_bytes())
    assert before.problem.scene.bodies.mass[0] == 1.0


def test_state_that_only_another_order_shows_is_seen(small: Path) -> None:
    ran(small, "softens-after-a-small-mass", mass="4")
    with pytest.raises(EngineError, match="was asked again after this one, in a fresh process"):
        ran(small, "softens-after-a-small-mass", mass="0.25")


def test_what_never_gives_the_same_bits_is_told_apart_from_kept_state(small: Path) -> None:
    ran(small, "draws-lots")
    with pytest.raises(EngineError, match=r"differently in two fresh .*deterministic ="):
        ran(small, "draws-lots", 32)


def test_a_method_that_claims_no_determinism_is_not_held_to_it(small: Path) -> None:
    toml = described(small)
    text = toml.read_text().replace(
        'name = "draws-lots"\n', 'name = "draws-lots"\ndeterministic = false\n'
    )
    toml.write_text(text)
    ran(small, "draws-lots")
    assert len(ran(small, "draws-lots", 32).t) == 9


def test_a_program_that_has_changed_is_started_anew(small: Path) -> None:
    ran(small, "good")
    program = small / "program.py"
    program.write_text(program.read_text().replace("def good(asked):", "def other(asked):"))
    with pytest.raises(EngineError, match="NameError"):
        ran(small, "good")


# Limits of the description --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("start_timeout = 0", "engine.start_timeout is 0"),
        ("warm_up = -1.0", "engine.warm_up is -1"),
    ],
)
def test_a_limit_that_makes_no_sense_is_refused(small: Path, more: str, says: str) -> None:
    toml = described(small, more=more)
    with pytest.raises(UsageError, match=says):
        discovery.engine(str(toml))


def test_a_command_that_names_files_is_refused_of_a_program_that_stays_alive(small: Path) -> None:
    toml = described(small, start="{request}")
    with pytest.raises(UsageError, match=r"no \{name\} of a file with serve = true"):
        discovery.engine(str(toml))


def test_warming_up_is_refused_of_a_program_that_does_not_stay_alive(small: Path) -> None:
    toml = described(small, more="warm_up = 1")
    toml.write_text(toml.read_text().replace("serve = true\n", ""))
    with pytest.raises(UsageError, match=r"0 without serve = true"):
        discovery.engine(str(toml))


def test_a_folder_whose_name_has_a_quote_is_refused() -> None:
    with pytest.raises(UsageError, match="without quotes and backslashes: set TMPDIR"):
        serving.line_of("1", "good", {"request": '/tmp/a "b"/request.json'})


# Ends -----------------------------------------------------------------------------------------

RUNS = """
import sys
from refdem.core import discovery
from refdem.core.problem import Request
problem = discovery.case("harmonic-oscillator").at(samples="8").problem
for method in sys.argv[2:]:
    request = Request(problem=problem, method=method, step=problem.interval / 16)
    discovery.engine(sys.argv[1]).run(request)
    print("ran", method, flush=True)
"""


def python(folder: Path, own: Path, *methods: str) -> "subprocess.Popen[str]":
    """A process that runs methods one after another, with a folder for temporary files."""
    own.mkdir()
    return subprocess.Popen(
        [sys.executable, "-c", RUNS, str(folder / "refdem.toml"), *methods],
        env=os.environ | {"TMPDIR": str(own)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def is_empty(folder: Path) -> bool:
    """Whether a folder gets empty."""
    deadline = time.monotonic() + PATIENCE
    while list(folder.iterdir()) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not list(folder.iterdir())


def test_a_killed_process_leaves_nothing_of_a_request_that_is_under_way(
    small: Path, tmp_path: Path
) -> None:
    running = python(small, tmp_path / "own", "good", "hangs")
    deadline = time.monotonic() + PATIENCE
    while not processes(f"grandchild of {small / 'program.py'}"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    running.kill()
    running.communicate()
    assert until_gone(str(small / "program.py"))
    assert is_empty(tmp_path / "own")


def test_a_killed_process_leaves_nothing_of_a_program_that_waits(
    small: Path, tmp_path: Path
) -> None:
    toml = str(small / "refdem.toml")
    waits = RUNS + "\nimport time\ntime.sleep(600)\n"
    own = tmp_path / "own"
    own.mkdir()
    running = subprocess.Popen(
        [sys.executable, "-c", waits, toml, "good"],
        env=os.environ | {"TMPDIR": str(own)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert running.stdout is not None
    assert running.stdout.readline() == "ran good\n"
    assert processes(str(small / "program.py"))
    running.kill()
    running.communicate()
    assert until_gone(str(small / "program.py"))
    assert is_empty(own)


def test_a_process_that_ends_lets_the_program_end_by_itself(small: Path, tmp_path: Path) -> None:
    program = small / "program.py"
    with program.open("a") as file:
        file.write(f'open("{tmp_path / "ended"}", "w").close()\n')
    running = python(small, tmp_path / "own", "good", "good")
    said, errors = running.communicate()
    assert running.returncode == 0, errors
    assert said.split() == ["ran", "good", "ran", "good"]
    assert (tmp_path / "ended").exists()
    assert until_gone(str(program))
    assert is_empty(tmp_path / "own")
