"""Codes by name: folders with a refdem.toml, in validation/codes and where REFDEM_CODES says."""

import os
from pathlib import Path

VARIABLE = "REFDEM_CODES"
"""The environment variable with folders of codes, separated as those of PATH are."""
DESCRIPTION = "refdem.toml"
"""The file that describes a code."""
PACKAGE = Path(__file__).resolve().parents[1]


def places() -> list[Path]:
    """The folders whose subfolders are codes: those of REFDEM_CODES come first, then
    validation/codes, which is inside the installed package or beside the source.
    """
    named = [Path(word) for word in os.environ.get(VARIABLE, "").split(os.pathsep) if word]
    shipped = [root / "validation" / "codes" for root in (PACKAGE, PACKAGE.parent)]
    return [folder.resolve() for folder in (*named, *shipped) if folder.is_dir()]


def descriptions() -> dict[str, Path]:
    """The refdem.toml of every code, by the name of its folder, sorted.

    Of two folders with one name the first place counts, as on PATH.
    """
    found: dict[str, Path] = {}
    for place in places():
        for path in sorted(place.glob(f"*/{DESCRIPTION}")):
            found.setdefault(path.parent.name, path)
    return dict(sorted(found.items()))
