"""A starter for a program in some language: a driver that works, its helper, refdem.toml and a file
for continuous integration.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from string import Template

from refdem.core.outside import one_line
from refdem.core.parameters import nearest
from refdem.engines.external.sense import NAME
from refdem.errors import StoreError, UsageError

TEMPLATES = Path(__file__).parent / "templates" / "init"
COMMON = {
    "refdem.toml": "refdem.toml.in",
    ".github/workflows/refdem-gate.yml": "refdem-gate.yml.in",
}
"""Templates that every starter has."""
HEADER = {"refdem_driver.h": "refdem_driver.h.in"}
"""The helper of C and of C++."""
MADE = ["./driver"]
"""The command of a starter that is compiled."""
BUILD = "      - name: Build the program\n        run: make\n"


@dataclass(frozen=True)
class Starter:
    """One language: its files and their templates, the command, what belongs to the program, and
    the compiler that it needs.
    """

    files: dict[str, str]
    command: list[str]
    inputs: list[str]
    compiler: str = ""


STARTERS = {
    "python": Starter(
        files={
            "driver.py": "python/driver.py.in",
            "refdem_driver.py": "python/refdem_driver.py.in",
        },
        command=["python3", "driver.py"],
        inputs=["*.py"],
    ),
    "c": Starter(
        files={"driver.c": "c/driver.c.in", "Makefile": "c/Makefile.in", **HEADER},
        command=MADE,
        inputs=["*.c", "*.h"],
        compiler="gcc",
    ),
    "cpp": Starter(
        files={"driver.cpp": "cpp/driver.cpp.in", "Makefile": "cpp/Makefile.in", **HEADER},
        command=MADE,
        inputs=["*.cpp", "*.h"],
        compiler="g++",
    ),
    "fortran": Starter(
        files={
            "driver.f90": "fortran/driver.f90.in",
            "refdem_driver.f90": "fortran/refdem_driver.f90.in",
            "Makefile": "fortran/Makefile.in",
        },
        command=MADE,
        inputs=["*.f90"],
        compiler="gfortran",
    ),
    "javascript": Starter(
        files={
            "driver.js": "javascript/driver.js.in",
            "refdem_driver.js": "javascript/refdem_driver.js.in",
        },
        command=["node", "driver.js"],
        inputs=["*.js"],
    ),
    "rust": Starter(
        files={
            "driver.rs": "rust/driver.rs.in",
            "refdem_driver.rs": "rust/refdem_driver.rs.in",
            "Makefile": "rust/Makefile.in",
        },
        command=MADE,
        inputs=["*.rs"],
        compiler="rustc",
    ),
}


def written(language: str, name: str, folder: Path) -> list[Path]:
    """Writes the files of a starter into a folder, and gives their places.

    Raises UsageError, before anything is written, for an unknown language, a name that no program
    can have, and a file that exists already.
    """
    if language not in STARTERS:
        raise UsageError(f"--language {language!r}: {nearest(language, list(STARTERS))}")
    refuse_bad_name(name)
    starter = STARTERS[language]
    texts = {
        folder / place: text_of(template, name, starter)
        for place, template in (starter.files | COMMON).items()
    }
    there = [path for path in texts if path.exists() or path.is_symlink()]
    if there:
        raise UsageError(f"{one_line(str(there[0]))} exists already; choose another folder")
    try:
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
    except OSError as error:
        raise StoreError(
            f"{one_line(str(folder))} cannot be written: {error.strerror}; choose another folder"
        ) from None
    return list(texts)


def refuse_bad_name(name: str) -> None:
    """Raises UsageError for what cannot be the name of a program in a refdem.toml."""
    if not NAME.fullmatch(name):
        raise UsageError(
            f"--name {one_line(name, 80)!r} cannot be used; expected letters, digits and . _ + -"
        )


def text_of(template: str, name: str, starter: Starter) -> str:
    """A template with the name, command and inputs of a starter."""
    build = ""
    if starter.compiler:
        build = BUILD
    return Template((TEMPLATES / template).read_text(encoding="utf-8")).substitute(
        name=name,
        command=json.dumps(starter.command),
        inputs=json.dumps(starter.inputs),
        build=build,
    )


def name_of(folder: Path) -> str:
    """A name for the program of a folder: that of the folder, as far as a program may have it."""
    name = re.sub(r"[^A-Za-z0-9._+-]+", "-", folder.resolve().name).strip("-._+")[:64]
    return name or "mydem"


def next_commands(language: str) -> list[str]:
    """What to run in the folder after `written`."""
    commands = ["refdem smoke refdem.toml", "refdem gate"]
    if STARTERS[language].compiler:
        commands.insert(0, "make")
    return [*commands, 'refdem gate --bless --why "first baseline"']
