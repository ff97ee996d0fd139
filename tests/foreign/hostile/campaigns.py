"""Campaigns over copies of hostile programs: their descriptions, one run of the command, and what
it must leave: findings, no folder, and nothing that a terminal or a log takes for a command.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent


def described(folder: Path, name: str, methods: "list[str]", limits: str) -> str:
    """The refdem.toml of a copy of the program."""
    place = folder / name
    place.mkdir()
    shutil.copy(HERE / "program.py", place / "program.py")
    words = [sys.executable, "program.py", "{request}", "{trajectory}", "{events}"]
    tables = "".join(f'[[engine.methods]]\nname = "{method}"\norder = 2\n' for method in methods)
    text = (
        f'[engine]\nname = "{name}"\ncommand = {json.dumps(words)}\n'
        f'supports = ["spring", "dimension:1"]\n{limits}\n{tables}'
    )
    (place / "refdem.toml").write_text(text)
    return str(place / "refdem.toml")


def run(folder: Path, engines: "list[str]") -> "subprocess.CompletedProcess[bytes]":
    """A short campaign over engines in two workers, whose report, store and temporary files lie in
    the folder.
    """
    temporary = folder / "temporary"
    temporary.mkdir()
    (folder / "own.toml").write_text(
        f'engines = {json.dumps(engines)}\nchecks = ["error", "determinism"]\nlevels = 3\n'
        'steps_per_tau = 64\n[[case]]\nid = "harmonic-oscillator"\n'
        'set = {samples = "8", duration = "2"}\n'
    )
    words = ["run", "--campaign", "own.toml", "--jobs", "2", "--out", str(folder / "report")]
    environment = os.environ | {
        "TMPDIR": str(temporary),
        "REFDEM_STORE": str(folder / "store.sqlite"),
        "GITHUB_ACTIONS": "true",
    }
    return subprocess.run(
        [sys.executable, "-c", "from refdem.cli import main; main()", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        timeout=3000,
        check=False,
    )


def findings_in(folder: Path) -> "dict[str, list[tuple[str, str]]]":
    """Outcome and sentence of every finding of a campaign by method."""
    found: dict[str, list[tuple[str, str]]] = {}
    for line in (folder / "report" / "records.jsonl").read_text().splitlines():
        sheet = json.loads(line)
        if sheet["type"] == "record":
            said = [(one["outcome"], one["sentence"]) for one in sheet["findings"]]
            found.setdefault(sheet["method"], []).extend(said)
    return found


def wait_for_folders(folder: Path, until: float) -> None:
    """Waits `until` then for all temporary folders of a campaign to be taken away.

    A worker that is killed just as it makes its folder leaves that to the next start of refdem.
    """
    sweep = "from refdem.engines.external.folders import sweep; sweep()"
    environment = os.environ | {"TMPDIR": str(folder / "temporary")}
    while still_there := list((folder / "temporary").iterdir()):
        assert time.monotonic() < until, still_there
        subprocess.run([sys.executable, "-c", sweep], env=environment, check=True)
        time.sleep(0.05)


def refuse_commands(folder: Path, said: bytes) -> None:
    """Fails if what a campaign `said`, or a page of its report, has a control character, a command
    to the log of a workflow, or a text that runs from right to left.
    """
    assert not re.search(rb"[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]", said)
    for line in said.decode().splitlines():
        assert not line.lstrip().startswith("::"), line
        assert "##[" not in line, line
        assert "\u202e" not in line, line
    for path in (folder / "report").rglob("*"):
        if path.suffix in (".html", ".md", ".csv", ".xml"):
            text = path.read_text()
            assert "\x1b" not in text, path
            assert "\u202e" not in text, path
