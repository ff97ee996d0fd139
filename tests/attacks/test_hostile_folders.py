"""Folders that somebody else gives to `refdem judge`: each damage is one clear line and the exit
status that the manual says; nothing outside of the folder is shown or written, and little memory is
taken.
"""

import json
import os
import re
import shutil
import socket
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from refdem.bench.memory import reset_peak, resident
from refdem.gate import baseline
from refdem.planning.exchange import FORMAT
from tests.planning.test_exchange import TOML, run

Command = Callable[..., "subprocess.CompletedProcess[str]"]
Damage = Callable[[Path], None]
SECRET = "swordfish"
"""A word that stands in files beside the folder alone."""
MOST_MEMORY = 400_000_000
"""Bytes that judging a folder may take beyond what the process had: a file of 64 MB is read whole,
and its text is decoded.
"""
ENDLESS = 2**36
"""Bytes of a file that is mostly a hole, so that it takes no place on the disk."""
DEEP = "[" * 100_000
REFUSED = 2
"""Exit status where the folder itself cannot be used."""
BROKEN = 3
"""Exit status where what came back of a run is an error."""


def first_run(folder: Path) -> Path:
    """The folder of the first run."""
    return sorted(path.parent for path in folder.glob("*/request.json"))[0]


def outside(folder: Path) -> Path:
    """The folder beside it, with files that tell a secret."""
    return folder.parent / "outside"


def writes(name: str, content: "str | bytes") -> Damage:
    """A file of the folder has another content."""

    def damage(folder: Path) -> None:
        path = folder / name
        path.unlink(missing_ok=True)
        if isinstance(content, str):
            content_bytes = content.encode()
        else:
            content_bytes = content
        path.write_bytes(content_bytes)

    return damage


def of_the_run(damage: Damage) -> Damage:
    """The same damage in the folder of the first run."""
    return lambda folder: damage(first_run(folder))


def answers(name: str, content: "str | bytes") -> Damage:
    """The first run comes back as another file, in place of its trajectory."""

    def damage(folder: Path) -> None:
        place = first_run(folder)
        (place / "trajectory.csv").unlink()
        writes(name, content)(place)

    return damage


def changed(name: str, change: "Callable[[bytes], bytes]") -> Damage:
    """A file of the folder is changed."""
    return lambda folder: writes(name, change((folder / name).read_bytes()))(folder)


def manifest(**fields: object) -> Damage:
    """Fields of the manifest have other values."""
    return changed("manifest.json", lambda before: json.dumps(json.loads(before) | fields).encode())


def endless(name: str) -> Damage:
    """A file is larger than any memory."""
    return lambda folder: os.truncate(_there(folder / name), ENDLESS)


def _there(path: Path) -> Path:
    path.touch()
    return path


def links(name: str, target: str) -> Damage:
    """A link has the place of a file or folder."""

    def damage(folder: Path) -> None:
        path = folder / name
        path.unlink(missing_ok=True)
        path.symlink_to(target)

    return damage


def baseline_of(ids: "list[str]", engine: str = "far") -> Damage:
    """There is a baseline of findings with these ids."""
    findings = [json.dumps({"id": name, "outcome": "pass"}).encode() for name in ids]
    header = {
        "format": baseline.FORMAT,
        "engine": engine,
        "version": "1",
        "why": "no reason",
        "findings": len(findings),
        "sha256": baseline.digest(findings),
    }
    content = b"\n".join([json.dumps(header).encode(), *findings]) + b"\n"
    return writes("far-baseline.jsonl", content)


def hard_links(name: str) -> Damage:
    """A file has a second name elsewhere."""
    return lambda folder: os.link(folder / name, folder.parent / "second name")


def pipe(name: str) -> Damage:
    """A pipe to which nobody writes has the place of a file."""

    def damage(folder: Path) -> None:
        (folder / name).unlink(missing_ok=True)
        os.mkfifo(folder / name)

    return damage


def door(folder: Path) -> None:
    """A socket has the place of the manifest."""
    (folder / "manifest.json").unlink()
    before = Path.cwd()
    os.chdir(folder)  # the path of a socket is short
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind("manifest.json")
    os.chdir(before)


def leads_the_run_to(name: str) -> Damage:
    """The folder of the first run is a link to a folder outside, which has a file of that name."""

    def damage(folder: Path) -> None:
        place = first_run(folder)
        target = outside(folder)
        shutil.copy(place / "request.json", target / "request.json")
        (target / name).write_text(f"{SECRET},{SECRET}\n")
        shutil.rmtree(place)
        place.symlink_to(target)

    return damage


def run_is_a_file(folder: Path) -> None:
    """A file has the place of a run's folder."""
    place = first_run(folder)
    shutil.rmtree(place)
    place.write_text("here was a run")


def array(change: "Callable[[bytes], bytes]", dtype: str = "<f8") -> Damage:
    """The first run comes back as an array in NumPy's format, changed."""

    def damage(folder: Path) -> None:
        place = first_run(folder)
        csv = place / "trajectory.csv"
        rows = np.genfromtxt(csv, delimiter=",", skip_header=1).astype(dtype)
        csv.unlink()
        np.save(place / "trajectory.npy", rows)
        changed("trajectory.npy", change)(place)

    return damage


def nothing(folder: Path) -> None:
    """No damage."""


def odd_names(folder: Path) -> None:
    """Names beside those of refdem that a terminal, a shell or a log may take for commands."""
    for name in ("a\nb", "\x1b[2J", "-rf", " ", "\u202e", "x" * 255, "::error::", "$(touch y)"):
        (folder / name).touch()
    Path(os.fsdecode(os.fsencode(folder) + b"/\xff\xfe")).touch()


def commands(folder: Path) -> None:
    """The description names commands, which would leave a file if they were run."""
    words = json.dumps(["touch", str(outside(folder) / "was run")])
    toml = folder / "far.toml"
    text = toml.read_text()
    text = re.sub("command = .*", f"command = {words}\nversion_command = {words}", text)
    toml.write_text(text)


def engine_here(folder: Path) -> None:
    """The manifest names an engine of refdem, whose answers would be judged in place of those that
    came back.
    """
    shutil.copy(folder / "far.toml", folder / "pymunk.toml")
    manifest(versions={"pymunk": "1"})(folder)


def many_programs(folder: Path) -> None:
    """The manifest names a hundred thousand programs."""
    manifest(versions={f"p{number}": "1" for number in range(100_000)})(folder)


MANIFESTS: "dict[str, tuple[Damage, str]]" = {
    "no manifest": (lambda folder: (folder / "manifest.json").unlink(), "No such file"),
    "half of it": (changed("manifest.json", lambda text: text[: len(text) // 2]), "truncated"),
    "nothing in it": (writes("manifest.json", ""), "truncated"),
    "no text": (writes("manifest.json", b'{"refdem": "\xff\xfe"}'), "manifest.json: "),
    "UTF-16": (
        changed("manifest.json", lambda text: text.decode().encode("utf-16")),
        "manifest.json: ",
    ),
    "brackets without end": (writes("manifest.json", DEEP), "manifest.json: "),
    "endless manifest": (endless("manifest.json"), "more than 67108864 bytes"),
    "a list": (writes("manifest.json", "[1, 2]"), "Expected `object`, got `array`"),
    "an unknown field": (manifest(shell="rm -rf ~"), "unknown field `shell`"),
    "a newer format": (
        manifest(format=FORMAT + 1),
        f"has format {FORMAT + 1}; expected {FORMAT}",
    ),
    "a format beyond all integers": (
        writes("manifest.json", '{"format": %s}' % ("9" * 5000)),
        "manifest.json",
    ),
    "no levels": (manifest(levels=0), "levels"),
    "levels below nothing": (manifest(levels=-3), "levels"),
    "a billion levels": (manifest(levels=10**9), "levels"),
    "no cases": (manifest(case=[]), "names no case"),
    "no programs": (manifest(versions={}), "names no program"),
    "many programs": (many_programs, "p0.toml"),
    "another case": (manifest(case=[{"id": "perpetuum-mobile"}]), "perpetuum-mobile"),
    "a case of escapes": (manifest(case=[{"id": "\x1b[2J\n::error::"}]), "refdem: "),
    "a case outside": (manifest(case=[{"id": "../outside/secret.toml"}]), "refdem: "),
    "an unknown parameter": (
        manifest(case=[{"id": "harmonic-oscillator", "set": {"sword": "1"}}]),
        "sword",
    ),
    "a billion samples": (
        manifest(case=[{"id": "harmonic-oscillator", "set": {"samples": "1000000000"}}]),
        "samples",
    ),
    "a duration without end": (
        manifest(case=[{"id": "harmonic-oscillator", "set": {"duration": "1e300"}}]),
        "duration",
    ),
    "no number": (
        manifest(case=[{"id": "harmonic-oscillator", "set": {"duration": "nan"}}]),
        "duration",
    ),
    "a hard link": (hard_links("manifest.json"), "expected a plain file"),
    "a link to nothing": (links("manifest.json", "nowhere"), "expected a plain file"),
    "a link to itself": (links("manifest.json", "manifest.json"), "expected a plain file"),
    "a link to a device": (links("manifest.json", "/dev/zero"), "expected a plain file"),
    "a door": (door, "expected a plain file"),
    "no description": (lambda folder: (folder / "far.toml").unlink(), "far.toml"),
    "half a description": (
        changed("far.toml", lambda text: text[: text.index(b'", "{request}')]),
        "far.toml: ",
    ),
    "a description of no text": (writes("far.toml", b"\xff\xfe\x00"), "far.toml: "),
    "an endless description": (endless("far.toml"), "more than 67108864 bytes"),
    "a description of another": (
        changed("far.toml", lambda text: text.replace(b'"far"', b'"near"')),
        "describes 'near'; expected 'far'",
    ),
    "a description of an engine here": (
        changed("far.toml", lambda text: text.replace(b'"far"', b'"reference"')),
        "describes 'reference'; expected 'far'",
    ),
    "an engine here for the program": (engine_here, "describes 'far'; expected 'pymunk'"),
    "endless answers": (endless("far-answers.jsonl"), "more than 67108864 bytes"),
    "a baseline by a link": (
        links("far-baseline.jsonl", "../outside/secret.txt"),
        "expected a plain file",
    ),
    "a baseline by a pipe": (pipe("far-baseline.jsonl"), "expected a plain file"),
    "an endless baseline": (endless("far-baseline.jsonl"), "more than 67108864 bytes"),
    "a baseline that nests": (writes("far-baseline.jsonl", DEEP), "far-baseline.jsonl, line 1"),
    "a baseline of another": (baseline_of([], engine="near"), "is that of 'near'"),
    "a baseline whose ids do not print": (
        baseline_of(["a/far/leapfrog/error/\x1b[2J"]),
        "characters that do not print",
    ),
    "answers by a link of odd name": (
        links("\x1b[2Janswers.jsonl", "../outside/secret.txt"),
        "expected a plain file",
    ),
}
"""What refdem cannot use at all."""

RUNS: "dict[str, tuple[Damage, str]]" = {
    "half a trajectory": (
        of_the_run(changed("trajectory.csv", lambda text: text[: len(text) // 2])),
        r"columns; expected 15|rows; expected",
    ),
    "an endless trajectory": (of_the_run(endless("trajectory.csv")), "trajectory.csv"),
    "no text in it": (of_the_run(writes("trajectory.csv", b"\xff\xfe" * 99)), "line 1 is"),
    "a line without end": (
        of_the_run(writes("trajectory.csv", "t,body" * 10**6)),
        "a row of more than 131072 characters",
    ),
    "escapes in its header": (
        of_the_run(writes("trajectory.csv", "\x1b[2J::error::\u202e\n")),
        r"line 1 is '\?\[2J",
    ),
    "endless events": (of_the_run(endless("events.csv")), "events.csv"),
    "events by a pipe": (of_the_run(pipe("events.csv")), "events.csv is a link, a pipe"),
    "events by a link": (
        of_the_run(links("events.csv", "../../outside/secret.txt")),
        "events.csv cannot be read|events.csv is a link",
    ),
    "a trajectory of two names": (of_the_run(hard_links("trajectory.csv")), "is a link, a pipe"),
    "a run that is a file": (run_is_a_file, "not exported yet"),
    "a run that is a link to refusals": (leads_the_run_to("unsupported.txt"), "is a link"),
    "a run that is a link to a trajectory": (leads_the_run_to("trajectory.csv"), "is a link"),
    "a run that is a link to events": (leads_the_run_to("events.csv"), "is a link"),
    "two answers": (
        of_the_run(lambda place: shutil.copy(place / "trajectory.csv", place / "trajectory.npy")),
        "there are trajectory.csv and trajectory.npy",
    ),
    "half an array": (array(lambda data: data[: len(data) // 2]), "bytes after its header"),
    "half a header": (array(lambda data: data[:20]), "no array in NumPy's format"),
    "an array of objects": (
        array(lambda data: data.replace(b"'<f8'", b"'|O' ")),
        "expected float64",
    ),
    "an array of a trillion rows": (
        array(
            lambda data: re.sub(rb"\((\d+), 15\), }( {11})", rb"(\g<1>00000000000, 15), }", data)
        ),
        "rows; expected",
    ),
    "an array of half the precision": (array(lambda data: data, "<f4"), "float32 of shape"),
    "an array whose header is code": (
        array(lambda data: data.replace(b"'<f8'", b"exit()")),
        "no array in NumPy's format",
    ),
    "an array of negative rows": (
        array(lambda data: re.sub(rb"\(\d", b"(-", data)),
        "rows; expected|no array in NumPy's format",
    ),
    "an array with more behind it": (array(lambda data: data + b"more"), "bytes after its header"),
    "an array in place of text": (
        answers("trajectory.csv", b"\x93NUMPY\x01\x00v\x00"),
        "line 1 is",
    ),
}
"""What costs its own run an error."""

HARMLESS: "dict[str, Damage]" = {
    "nothing": nothing,
    "commands": commands,
    "inputs outside": changed(
        "far.toml", lambda text: text.replace(b"supports", b'inputs = ["../*"]\nsupports')
    ),
    "odd names": odd_names,
    "a pipe beside": pipe("beside"),
    "a link beside": links("beside", "../outside/secret.txt"),
    "endless file beside": endless("beside.bin"),
    "answers of no text": writes("far-answers.jsonl", b"\xff\xfe\n"),
    "answers that nest": writes("far-answers.jsonl", DEEP),
    "answers of others": writes("far-answers.jsonl", '{"id": "../outside", "failed": "no"}\n'),
    "answers that are no objects": writes("far-answers.jsonl", '[1]\n"far"\n1e999\nNaN\n'),
    "a list of runs that lies": writes("runs.txt", "../outside\n/etc\n"),
}
"""Judged as a good folder is."""


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory, command_line: Command) -> Path:
    """A folder that came back with the right trajectories."""
    above = tmp_path_factory.mktemp("folders")
    (above / "refdem.toml").write_text(TOML)
    words = ["export", "good", "harmonic-oscillator", "--engine", "refdem.toml", "--levels", "3"]
    for _ in range(2):
        done = command_line(*words, cwd=above, env=environment(above))
        assert done.returncode == 0, done.stderr
        for request in (above / "good").glob("*/request.json"):
            run(request.parent)
    return above / "good"


def environment(folder: Path) -> "dict[str, str]":
    """That of this process, with a store of the tests' own."""
    return os.environ | {"REFDEM_STORE": str(folder / "store.sqlite")}


@pytest.fixture
def judged(
    exported: Path, tmp_path: Path, command_line: Command
) -> "Callable[[Damage], subprocess.CompletedProcess[str]]":
    """Judges a copy of the good folder after a damage, and sees that nothing else is touched."""

    def judge(damage: Damage) -> "subprocess.CompletedProcess[str]":
        folder = tmp_path / "given"
        shutil.copytree(exported, folder)
        beside = outside(folder)
        beside.mkdir()
        (beside / "secret.txt").write_text(SECRET)
        damage(folder)
        before = listing(tmp_path)
        reset_peak()
        start = resident("VmHWM")
        done = command_line(
            "judge", "given", "--out", "report", cwd=tmp_path, env=environment(exported.parent)
        )
        assert resident("VmHWM") - start < MOST_MEMORY
        shown = done.stdout + done.stderr
        assert "Traceback" not in shown
        assert "internal error of refdem" not in shown
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f\u202e]", shown), shown
        assert SECRET not in shown
        reports = [path for path in (tmp_path / "report").rglob("*") if path.is_file()]
        assert not [path for path in reports if SECRET.encode() in path.read_bytes()]
        assert listing(tmp_path) == before
        return done

    return judge


def listing(above: Path) -> "dict[str, tuple[int, int]]":
    """Size and time of change of everything there but the report."""
    found = {}
    for folder, _, files in os.walk(above):
        for name in files:
            path = os.path.join(folder, name)
            status = os.lstat(path)
            found[path] = (status.st_size, status.st_mtime_ns)
    report = str(above / "report")
    return {path: state for path, state in found.items() if not path.startswith(report)}


@pytest.mark.parametrize("name", MANIFESTS)
def test_a_folder_that_cannot_be_used_is_one_line(judged, name: str) -> None:
    damage, says = MANIFESTS[name]
    done = judged(damage)
    assert (done.returncode, done.stdout) == (REFUSED, ""), done.stderr
    assert re.fullmatch(r"refdem: .*\n", done.stderr), done.stderr
    assert re.search(says, done.stderr), done.stderr


@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_cannot_be_used_is_one_error(judged, name: str) -> None:
    damage, says = RUNS[name]
    done = judged(damage)
    assert done.returncode == BROKEN, done.stdout + done.stderr
    assert re.search(says, done.stdout), done.stdout


@pytest.mark.parametrize("name", HARMLESS)
def test_what_refdem_does_not_need_is_passed_over(judged, name: str) -> None:
    done = judged(HARMLESS[name])
    assert done.returncode == 0, done.stdout + done.stderr


IDS = [
    "../../../outside/far/leapfrog/error/x",
    "/etc/passwd/far/leapfrog/error/x",
    "<script>alert(1)</script>/far/leapfrog/error/x",
    "::error::pendulum/far/leapfrog/##[error]/x",
    "nul/../reference/leapfrog/error/x",
    f"{'long' * 1000}/far/leapfrog/error/x",
]
"""Ids of findings that a report may take neither for paths nor for markup or commands."""


def test_hostile_names_in_a_baseline_are_findings_that_are_absent(judged, tmp_path: Path) -> None:
    done = judged(baseline_of(IDS))
    assert done.returncode == 1, done.stdout + done.stderr
    assert done.stdout.count("ABSENT") == len(IDS)
    assert "the gate of far is closed" in done.stdout
    assert not [line for line in done.stdout.splitlines() if line.startswith("::")]
    assert "##[" not in done.stdout
    pages = list((tmp_path / "report").rglob("*.html"))
    assert pages
    assert not [page for page in pages if "<script>alert" in page.read_text()]


PLANTED = {
    "far.toml": "planted",
    "runs.txt": "planted",
    "RUN": ".",
    "RUN/request.json": "planted",
    "RUN/request.txt": "planted",
}
"""What a second export writes, and where outside a link in its place leads; RUN is a run that goes
on from one that came back.
"""


@pytest.mark.parametrize("place", PLANTED)
def test_a_second_export_writes_through_no_link(
    exported: Path, tmp_path: Path, command_line: Command, place: str
) -> None:
    folder = tmp_path / "given"
    shutil.copytree(exported, folder)
    (later,) = later_runs(folder)
    shutil.rmtree(folder / later)
    link = folder / place.replace("RUN", later)
    link.parent.mkdir(exist_ok=True)
    link.unlink(missing_ok=True)
    outside(folder).mkdir()
    link.symlink_to(outside(folder) / PLANTED[place])
    above = exported.parent
    words = ["export", str(folder), "harmonic-oscillator", "--engine", "refdem.toml"]
    done = command_line(*words, "--levels", "3", cwd=above, env=environment(above))
    assert "Traceback" not in done.stderr
    assert list(outside(folder).iterdir()) == []
    if place != "RUN":
        # The export wrote here: a file has taken the place of the link.
        assert link.is_file()
        assert not link.is_symlink()


def later_runs(folder: Path) -> "list[str]":
    """The runs that the second export waited for: only it could write them, for they start where
    another one ended.
    """
    return (folder / "runs.txt").read_text().splitlines()
