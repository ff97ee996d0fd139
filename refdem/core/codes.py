"""Codes by name: folders with a refdem.toml, in validation/codes and where REFDEM_CODES says."""

import os
import sys
from pathlib import Path

VARIABLE = "REFDEM_CODES"
"""The environment variable with folders of codes, separated as those of PATH are."""
DESCRIPTION = "refdem.toml"
"""The file that describes a code."""
FOLDER = Path("validation") / "codes"
"""Where a project has its codes, and an installed refdem its copies of their drivers."""
PACKAGE = Path(__file__).resolve().parents[1]


def places() -> list[Path]:
    """The folders whose subfolders are codes, the first to count first.

    Those of REFDEM_CODES; validation/codes beside the source of refdem; beside the environment that
    refdem is installed in, where `make field` puts programs; and inside the installed package.
    """
    named = [Path(word) for word in os.environ.get(VARIABLE, "").split(os.pathsep) if word]
    roots = [PACKAGE.parent, Path(sys.prefix).parent, PACKAGE]
    folders = [*named, *(root / FOLDER for root in roots)]
    there = [folder.resolve() for folder in folders if folder.is_dir()]
    return list(dict.fromkeys(there))


def descriptions() -> dict[str, Path]:
    """The refdem.toml of every code, by the name of its folder, sorted.

    Of two folders with one name the first place counts, as on PATH.
    """
    found: dict[str, Path] = {}
    for place in places():
        for path in sorted(place.glob(f"*/{DESCRIPTION}")):
            found.setdefault(path.parent.name, path)
    return dict(sorted(found.items()))


def searched() -> str:
    """The places where codes were looked for, as the end of a sentence."""
    return f"codes were looked for in {', '.join(map(str, places()))}"


def advice(description: Path) -> str:
    """What else to say of a code that is not installed: if its refdem.toml is the copy inside an
    installed refdem, no program can be beside it, and the project that has one is to be named.
    """
    if not description.is_relative_to(PACKAGE):
        return ""
    return (
        "; do so in a checkout of refdem, and run the refdem of its .venv or let"
        f" {VARIABLE} name its {FOLDER}; {searched()}"
    )
