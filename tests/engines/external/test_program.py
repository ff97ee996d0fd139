"""A program as an engine: what it says is read, and whatever it does wrong is one clear error."""

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.outside import one_line
from refdem.core.problem import Request
from refdem.core.trajectory import Event, Trajectory
from refdem.engines.external.kept import MOST_BYTES, MOST_FOLDERS
from refdem.engines.external.supervisor import remove
from refdem.errors import EngineError, UnsupportedError, UsageError
from tests.foreign.hostile import modes

HOSTILE = Path(__file__).parents[2] / "foreign" / "hostile"
WITHOUT_FOLDER = ("takes-its-folder-away", "puts-a-link-in-place-of-its-folder")


def ran(folder: Path, method: str) -> Trajectory:
    """The trajectory of a run of the small program."""
    problem = discovery.case("harmonic-oscillator").at(samples="8", duration="2").problem
    trajectory, cost = discovery.engine(str(folder / "refdem.toml")).run(
        Request(problem=problem, method=method, step=problem.interval / 16)
    )
    assert cost.steps == 128
    return trajectory


def gone(word: str) -> bool:
    """No process of that word is there any more; one that was killed takes a moment to go."""
    deadline = time.monotonic() + 60
    while processes(word) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not processes(word)


def processes(word: str) -> list[Path]:
    """Processes whose command line has the word."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            command = path.read_bytes().split(b"\0")
        except OSError:
            continue
        if word.encode() in command:
            found.append(path)
    return found


def test_what_a_program_writes_is_its_trajectory(small: Path) -> None:
    run = ran(small, "good")
    assert np.all(np.abs(run.position[:, 0, 0] - np.cos(run.t)) < 1e-4)
    assert np.all(run.attitude == [1.0, 0.0, 0.0, 0.0])
    assert run.events == (Event(0.5, "turn", 0),)


@pytest.mark.parametrize(("method", "says"), modes.ERRORS.items())
def test_a_broken_run_says_what_happened_and_where_its_output_is(
    small: Path, method: str, says: str
) -> None:
    limit(small, "timeout = 600\nmemory = 0.5")
    with pytest.raises(EngineError, match=says) as raised:
        ran(small, method)
    sentence = str(raised.value)
    assert one_line(sentence) == sentence
    if method not in WITHOUT_FOLDER:
        place = Path(sentence.rpartition("kept in ")[2].rstrip(")"))
        assert (place / "request.json").read_bytes()
        assert (place / "request.txt").read_text().startswith("format 1\n")


@pytest.mark.parametrize(("method", "says"), modes.SLOW.items())
def test_what_never_ends_is_ended(small: Path, method: str, says: str) -> None:
    limit(small, "timeout = 0.5")
    with pytest.raises(EngineError, match=says):
        ran(small, method)


@pytest.mark.parametrize(("method", "says"), modes.REFUSALS.items())
def test_a_refusal_is_no_error(small: Path, method: str, says: str) -> None:
    with pytest.raises(UnsupportedError, match=says):
        ran(small, method)


@pytest.mark.parametrize("method", modes.HARMLESS)
def test_what_hurts_nobody_is_judged_as_any_other(small: Path, method: str) -> None:
    assert np.array_equal(ran(small, method).position, ran(small, "good").position)


def limit(folder: Path, words: str) -> None:
    """Gives the program other limits."""
    toml = folder / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", words))


def test_exit_status_77_is_a_refusal_with_the_last_line_of_stderr(small: Path) -> None:
    with pytest.raises(UnsupportedError, match=r"^no springs on Saturdays$"):
        ran(small, "refuses")


def test_a_program_that_hangs_is_ended_with_its_children(small: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", "timeout = 0.5"))
    with pytest.raises(EngineError, match=r"still running after 0\.5 s and was ended"):
        ran(small, "hangs")
    assert gone(f"grandchild of {small / 'program.py'}")


@pytest.mark.parametrize(
    ("method", "count"), [("leaves", "1"), ("session", "3"), ("forks", "3"), ("breeds", r"\d+")]
)
def test_what_a_program_leaves_running_is_ended_and_said(
    small: Path, method: str, count: str
) -> None:
    with pytest.raises(
        EngineError, match=f"left {count} of its processes running, which were ended"
    ):
        ran(small, method)
    assert not processes(f"grandchild of {small / 'program.py'}")


@contextmanager
def made_in(place: Path, _: str) -> Iterator[Path]:
    """The folder of a run at another place."""
    folder = place / "run"
    folder.mkdir()
    try:
        yield folder
    finally:
        remove(folder)


@pytest.mark.parametrize("method", ["deep", "locked"])
def test_folders_that_are_hard_to_take_away_are_taken_away(
    small: Path, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = small.parent / "temporary"
    own.mkdir()
    monkeypatch.setattr("refdem.engines.external.program.run_folder", partial(made_in, own))
    ran(small, method)
    assert list(own.iterdir()) == []


def test_a_program_that_takes_all_memory_is_ended_before_the_machine_is(small: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", "timeout = 600\nmemory = 0.5"))
    said = r"took .* GB of memory and was ended; expected at most 0\.5 GB"
    with pytest.raises(EngineError, match=said):
        ran(small, "devours")


def test_memory_that_is_only_reserved_does_not_count(small: Path) -> None:
    # The address sanitizer of C compilers reserves 15 TB; programs built with it must be judged.
    trajectory = ran(small, "reserves")
    assert len(trajectory.t) == 9


def test_a_program_dies_with_the_process_that_runs_it_and_leaves_no_folder(
    small: Path, tmp_path: Path
) -> None:
    own = tmp_path / "temporary"
    own.mkdir()
    code = (
        "import sys; from refdem.core import discovery; from refdem.core.problem import Request;"
        " problem = discovery.case('harmonic-oscillator').at(samples='8').problem;"
        " discovery.engine(sys.argv[1]).run(Request(problem=problem, method='hangs',"
        " step=problem.interval / 16))"
    )
    environment = os.environ | {"TMPDIR": str(own)}
    running = subprocess.Popen(
        [sys.executable, "-c", code, str(small / "refdem.toml")], env=environment
    )
    deadline = time.monotonic() + 60
    while not processes(f"grandchild of {small / 'program.py'}"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    running.kill()
    running.wait()
    assert gone(f"grandchild of {small / 'program.py'}")
    while list(own.iterdir()):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_version_command_has_limits_too(small: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(re.sub(r"version_command = .*", 'version_command = ["yes"]', toml.read_text()))
    assert discovery.engine(str(toml)).version().startswith("files ")


def test_children_left_behind_by_a_run_that_fails_are_ended(small: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("timeout = 600", "timeout = 0.5"))
    with pytest.raises(EngineError):
        ran(small, "hangs")
    assert gone(f"grandchild of {small / 'program.py'}")


def test_a_program_that_floods_the_disk_is_stopped_and_little_of_it_is_kept(
    small: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("refdem.engines.external.program.SPARE", 2**22)
    with pytest.raises(EngineError, match="SIGXFSZ: a file grew too large") as raised:
        ran(small, "floods")
    place = Path(str(raised.value).rpartition("kept in ")[2].rstrip(")"))
    assert (place / "big").stat().st_size == MOST_BYTES


def test_only_the_newest_failed_runs_are_kept(small: Path, tmp_path: Path) -> None:
    for _ in range(MOST_FOLDERS + 3):
        with pytest.raises(EngineError):
            ran(small, "silent")
    assert len(list((tmp_path / "kept" / "failed-runs").iterdir())) == MOST_FOLDERS


def test_a_driver_whose_program_is_not_there_is_said_to_be_missing(small: Path) -> None:
    toml = small / "refdem.toml"
    for program, is_missing in (("nowhere", True), ("python3", False)):
        toml.write_text(
            '[engine]\nname = "small"\ncommand = ["python3", "driver.py"]\n'
            f'version_command = ["{program}", "--version"]\n'
            '[[engine.methods]]\nname = "a"\norder = 1\n'
        )
        reason = discovery.engine(str(toml)).missing()
        assert (reason is not None) == is_missing
        assert reason is None or reason.startswith("nowhere does not exist or is not executable")


def test_a_missing_and_an_unrunnable_program_are_said_to_be_missing(small: Path) -> None:
    toml = small / "refdem.toml"
    for word in ("./nowhere", "./program.py"):
        toml.write_text(
            f'[engine]\nname = "small"\ncommand = ["{word}"]\n[[engine.methods]]\nname = "a"\norder'
            " = 1\n"
        )
        engine = discovery.engine(str(toml))
        assert "does not exist or is not executable" in (engine.missing() or "")
        problem = discovery.case("harmonic-oscillator").at(samples="8").problem
        with pytest.raises(EngineError, match="cannot be started"):
            engine.run(Request(problem=problem, method="a", step=problem.interval))


def test_a_rebuilt_program_with_the_same_version_has_another_fingerprint(small: Path) -> None:
    def seen() -> tuple[str, str]:
        engine = discovery.engine(str(small / "refdem.toml"))
        return engine.version(), engine.fingerprint(engine.methods[0])

    before = seen()
    assert seen() == before
    program = small / "program.py"
    program.write_text(program.read_text().replace("v -= 0.5 * h * rate", "v += 0.5 * h * rate"))
    after = seen()
    assert (before[0], after[0]) == ("1.0", "1.0")
    assert before[1] != after[1]


def test_inputs_are_part_of_the_fingerprint_and_must_exist(small: Path) -> None:
    toml = small / "refdem.toml"
    toml.write_text(toml.read_text().replace("[engine]\n", '[engine]\ninputs = ["src/**/*.c"]\n'))
    engine = discovery.engine(str(toml))
    with pytest.raises(UsageError, match=r"refdem\.toml: .*matches no file"):
        engine.fingerprint(engine.methods[0])
    other = small / "second.toml"
    other.write_text(toml.read_text())
    engine_of_other = discovery.engine(str(other))
    with pytest.raises(UsageError, match=r"second\.toml: .*matches no file"):
        engine_of_other.fingerprint(engine_of_other.methods[0])
    (small / "src" / "deep").mkdir(parents=True)
    (small / "src" / "deep" / "a.c").write_text("one")
    before = engine.fingerprint(engine.methods[0])
    (small / "src" / "deep" / "a.c").write_text("two")
    assert engine.fingerprint(engine.methods[0]) != before


def test_a_scene_that_supports_does_not_name_is_refused(small: Path) -> None:
    engine = discovery.engine(str(small / "refdem.toml"))
    hanging = discovery.case("harmonic-oscillator").at(gravity="1").problem
    assert "uniform_gravity" in (engine.unsupported_motion(hanging, engine.methods[0]) or "")
    assert (
        engine.unsupported_motion(
            discovery.case("harmonic-oscillator").at().problem, engine.methods[0]
        )
        is None
    )


def test_a_program_moved_elsewhere_is_found_from_there(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.move(small, tmp_path / "with blanks $HOME; x")
    monkeypatch.chdir(tmp_path / "with blanks $HOME; x")
    assert len(ran(Path(), "good").t) == 9
