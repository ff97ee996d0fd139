"""A report of which nothing has changed is not written again: what it was made of, and how its
files were left, is in the store.
"""

import hashlib
from collections.abc import Sequence
from importlib.metadata import version as installed
from pathlib import Path

import msgspec

from refdem.core import fingerprint
from refdem.core.finding import CampaignSheet, Sheet
from refdem.core.store import Store

Files = dict[str, tuple[int, int]]
"""Size [bytes] and time of change [ns] by place in the folder."""


class _State(msgspec.Struct):
    """How a report was left: a digest of what it was made of, and the state of its files."""

    made_of: str
    files: Files


def stands(folder: Path, sheets: Sequence[Sheet], store: Store) -> bool:
    """True if the report in the folder was made of these sheets (how long they took apart) and
    nobody has touched it since.
    """
    state = store.read("report", _text(folder.resolve()), msgspec.json.Decoder(_State).decode)
    return (
        state is not None
        and state.made_of == _made_of(folder, sheets)
        and state.files == _files(folder)
    )


def left(folder: Path, sheets: Sequence[Sheet], store: Store) -> None:
    """Keeps how a report has just been written."""
    state = _State(_made_of(folder, sheets), _files(folder))
    store.put("report", _text(folder.resolve()), msgspec.json.encode(state))


def _made_of(folder: Path, sheets: Sequence[Sheet]) -> str:
    others = [sheet for sheet in sheets if not isinstance(sheet, CampaignSheet)]
    names = [sheet.name for sheet in sheets if isinstance(sheet, CampaignSheet)]
    under = [
        fingerprint.of_refdem(),
        *map(installed, ("altair", "vl-convert-python", "jinja2", "latex2mathml")),
    ]
    parts = [names, others, under, (folder / "gallery" / "gallery.html").exists()]
    return hashlib.sha256(msgspec.msgpack.encode(parts, order="deterministic")).hexdigest()


def _text(path: Path) -> str:
    """A path as UTF-8 can have it: names of files may hold any bytes."""
    return str(path).encode("utf-8", "backslashreplace").decode("utf-8")


def _files(folder: Path) -> Files:
    """Every file of the folder and of the folders of a report in it."""
    files: Files = {}
    for part in (".", "cases", "figures", "assets"):
        for path in (folder / part).glob("*"):
            if path.is_file():
                state = path.stat()
                name = _text(path.relative_to(folder))
                files[name] = (state.st_size, state.st_mtime_ns)
    return files
