"""Codes by name: folders with a refdem.toml, in validation/codes and those in REFDEM_CODES."""

import os
import sys
from pathlib import Path

VARIABLE = "REFDEM_CODES"
"""Environment variable that lists folders of codes, separated like those in PATH."""
DESCRIPTION = "refdem.toml"
"""The file that describes a code."""
FOLDER = Path("validation") / "codes"
"""The folder of codes in a project; an installed refdem has copies of their drivers in it."""
PACKAGE = Path(__file__).resolve().parents[1]


def places() -> list[Path]:
    """The existing folders whose subfolders are codes, in decreasing precedence.

    These are the folders listed in REFDEM_CODES, then validation/codes beside the source of refdem,
    beside the environment in which refdem is installed (`make field` puts programs there), and
    inside the installed package.
    """
    named = [Path(word) for word in os.environ.get(VARIABLE, "").split(os.pathsep) if word]
    roots = [PACKAGE.parent, Path(sys.prefix).parent, PACKAGE]
    folders = [*named, *(root / FOLDER for root in roots)]
    there = [folder.resolve() for folder in folders if folder.is_dir()]
    return list(dict.fromkeys(there))


def descriptions() -> dict[str, Path]:
    """The path of the refdem.toml of every code, by the name of its folder, sorted by name.

    If several places have a folder of the same name, the first place takes precedence, as in PATH.
    """
    found: dict[str, Path] = {}
    for place in places():
        for path in sorted(place.glob(f"*/{DESCRIPTION}")):
            found.setdefault(path.parent.name, path)
    return dict(sorted(found.items()))


def searched() -> str:
    """The places that were searched for codes, as the end of a sentence."""
    return f"codes were looked for in {', '.join(map(str, places()))}"


def advice(description: Path) -> str:
    """Advice to append to the message that the program of a code is not installed; may be empty.

    If `description`, the path of its refdem.toml, lies inside an installed refdem, no program can
    be beside it, and the advice is to use a checkout of refdem.
    """
    if not description.is_relative_to(PACKAGE):
        return ""
    return (
        "; do so in a checkout of refdem, and run the refdem of its .venv or let"
        f" {VARIABLE} name its {FOLDER}; {searched()}"
    )
