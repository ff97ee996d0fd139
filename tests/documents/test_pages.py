"""Every block of code of every page of docs/ does what the page says, in an empty folder.

A block in front of which a page names a file ("Save this as `dem.cpp`:") becomes that file. Blocks
of `sh` are run in their order, and the lines of a block of `text` that follows are in what they
print, where `...` stands for anything. Python that is no file is run by itself, C is compiled, TOML
is read.
"""

import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md"))
BLOCK = re.compile(
    r"(?:as\s`([\w-]+\.\w+)`:\n\n)?^```(\w+|\{[\w-]+\})?[^\n]*\n(.*?)^```$", re.M | re.S
)
NO_CODE = ("{toctree}", "{raw}", "{eval-rst}", "{refdem-commands}", "{refdem-schema}")
C_PROGRAM = "#include <stdio.h>\n#include <unistd.h>\nint main(void) {{\n{}return !answers;\n}}\n"
"""A program around lines of C that make `answers`."""


@dataclass(frozen=True)
class Block:
    """A block of a page: the file that it is, if it is one, its language and its lines."""

    file: str
    language: str
    text: str


def blocks_of(text: str) -> list[Block]:
    """The blocks of a page, in their order; none is left out."""
    found = [Block(*(part or "" for part in block.groups())) for block in BLOCK.finditer(text)]
    assert 2 * len(found) == len(re.findall("^```", text, re.MULTILINE))
    return found


@dataclass
class Reader:
    """A stranger with an empty folder, who follows a page; `printed` is what the last block did."""

    folder: Path
    printed: str = ""

    def __post_init__(self) -> None:
        """Puts `refdem` and `python3` on the path of this reader alone: those of these tests."""
        tools = self.folder / ".tools"
        tools.mkdir()
        python = f'exec "{sys.executable}"'
        command = f'{python} -c "from refdem.cli import main; main()" "$@"'
        for name, line in {"refdem": command, "python3": f'{python} "$@"'}.items():
            (tools / name).write_text(f"#!/bin/sh\n{line}\n")
            (tools / name).chmod(0o755)
        self.environment = os.environ | {
            "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}",
            "REFDEM_STORE": str(tools / "store.sqlite"),
            "GITHUB_ACTIONS": "false",
            "COLUMNS": "200",
        }

    def run(self, *command: str, given: str = "") -> None:
        """Runs a command that must end well, and keeps what it printed."""
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=self.environment,
            input=given,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=300,
            check=False,
        )
        self.printed = done.stdout
        assert done.returncode == 0, f"{given}\n{done.stdout}"

    def follow(self, block: Block) -> None:
        """Does what a block says."""
        if block.file:
            (self.folder / block.file).write_text(block.text)
        elif block.language == "text":
            self.compare(block.text)
        elif block.language == "sh":
            self.run("bash", "-euo", "pipefail", "-s", given=block.text)
        elif block.language == "python":
            self.run(sys.executable, "-", given=block.text)
        elif block.language == "c":
            program = C_PROGRAM.format(block.text)
            self.run("cc", "-Wall", "-Werror", "-fsyntax-only", "-x", "c", "-", given=program)
        elif block.language == "toml":
            tomllib.loads(block.text)
        elif block.language == "yaml":
            yaml.safe_load(block.text)
        else:
            assert block.language in NO_CODE, f"a block of {block.language!r} cannot be run"

    def compare(self, shown: str) -> None:
        """Every line that a page shows is in what the block before it printed."""
        if not self.printed:
            return  # a command that is shown and not run here, in its own words
        said = " ".join(self.printed.split())
        for line in shown.splitlines():
            words = " ".join(line.split())
            pattern = r".*?".join(re.escape(part.strip()) for part in words.split("..."))
            assert re.search(pattern, said), f"{line!r} is not in\n{self.printed}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT / "docs").as_posix())
def test_a_page_does_what_it_says(page: Path, tmp_path: Path) -> None:
    reader = Reader(tmp_path)
    for block in blocks_of(page.read_text()):
        reader.follow(block)
        if block.language != "sh":
            reader.printed = ""


def test_links_between_files_lead_to_files() -> None:
    """Sphinx sees those of its pages, down to their sections; README is none of these."""
    listed = subprocess.run(
        ["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    for name in listed.stdout.split():
        for target in re.findall(r"\]\(([^)#\s]+)[^)\s]*\)", (ROOT / name).read_text()):
            if re.match(r"[a-z]+:", target):
                continue
            assert ((ROOT / name).parent / target).exists(), f"{name}: {target}"


def test_a_page_that_says_what_is_not_so_is_seen(tmp_path: Path) -> None:
    reader = Reader(tmp_path)
    reader.follow(Block("", "sh", "echo the gate is closed\n"))
    reader.follow(Block("", "text", "the ... closed\n"))
    with pytest.raises(AssertionError, match="the gate is open"):
        reader.follow(Block("", "text", "the gate is open\n"))
    with pytest.raises(AssertionError):
        reader.follow(Block("", "sh", "false\n"))
    for text, file in (("Save this as `a.py`:", "a.py"), ("as in `a.py`:", ""), ("`a`:", "")):
        (block,) = blocks_of(f"{text}\n\n```sh\nls\n```\n")
        assert block.file == file
    with pytest.raises(AssertionError, match="cannot be run"):
        reader.follow(Block("", "perl", "1;\n"))
