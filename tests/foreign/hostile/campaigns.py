"""Campaigns over copies of the hostile program: their descriptions, and one run of the command."""

import json
import os
import shutil
import subprocess
import sys
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
