"""The zoo of tests/foreign/hostile with a refdem.toml beside it: one misbehaviour a method."""

import shutil
import sys
from pathlib import Path

import pytest

from tests.foreign.hostile import modes

HOSTILE = Path(__file__).parents[2] / "foreign" / "hostile"
METHODS = ("good", *modes.MODES)


def described(
    folder: Path,
    *,
    command: str = "",
    more: str = "",
    methods: "list[str] | tuple[str, ...]" = METHODS,
) -> Path:
    """A refdem.toml in `folder` for the program there."""
    words = (
        command
        or f'["{sys.executable}", "program.py", "{{request}}", "{{trajectory}}", "{{events}}"]'
    )
    tables = [
        f'[[engine.methods]]\nname = "{name}"\norder = 2\nsymplectic = true\nreversible ='
        ' true\nconserves = ["momentum"]\n'
        for name in methods
    ]
    text = (
        f'[engine]\nname = "small"\ncommand = {words}\nsupports = ["spring",'
        f' "dimension:1"]\ntimeout = 600\n{more}\n'
    )
    path = folder / "refdem.toml"
    path.write_text(text + "\n".join(tables))
    return path


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the small program; failed runs are kept beside a store of its own."""
    folder = tmp_path / "small"
    folder.mkdir()
    shutil.copy(HOSTILE / "program.py", folder / "program.py")
    described(folder, more=f'version_command = ["{sys.executable}", "program.py", "--version"]')
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "kept" / "store.sqlite"))
    return folder
