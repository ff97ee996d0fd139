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
from refdem.errors import StoreError
from refdem.report.jsonl import RECORDS, content

Files = dict[str, tuple[int, int]]
"""Size [bytes] and time of change [ns] by place in the folder."""


class _State(msgspec.Struct):
    """How a report was left: digests of its sheets, of its file of records and of what made it, and
    the state of its files.
    """

    sheets: str
    records: str | None
    maker: str
    files: Files


def stands(folder: Path, sheets: Sequence[Sheet], store: Store) -> bool:
    """True if the report in the folder was made of these sheets (how long they took apart) and
    it was not changed since.
    """
    state = _left(folder, store)
    return state is not None and state.sheets == _of_sheets(sheets) and _is_untouched(folder, state)


def is_as_left(folder: Path, store: Store) -> bool:
    """True if the report in the folder would be made of its own records again as it stands.

    The records are compared byte by byte, and not read.
    """
    state = _left(folder, store)
    if state is None or state.records is None:
        return False
    return state.records == _of_records(folder) and _is_untouched(folder, state)


def left(folder: Path, sheets: Sequence[Sheet], store: Store) -> None:
    """Keeps how a report has just been written."""
    state = _State(_of_sheets(sheets), _of_records(folder), _maker(folder), _files(folder))
    store.put("report", _text(folder.resolve()), msgspec.json.encode(state))


def _left(folder: Path, store: Store) -> _State | None:
    """How the report in a folder was left, None if that is unknown."""
    return store.read("report", _text(folder.resolve()), msgspec.json.Decoder(_State).decode)


def _is_untouched(folder: Path, state: _State) -> bool:
    """True if what makes reports is the same, and so are all files in the folder."""
    return state.maker == _maker(folder) and state.files == _files(folder)


def _of_sheets(sheets: Sequence[Sheet]) -> str:
    """The digest of all sheets but the times of the campaign."""
    others = [sheet for sheet in sheets if not isinstance(sheet, CampaignSheet)]
    names = [sheet.name for sheet in sheets if isinstance(sheet, CampaignSheet)]
    return hashlib.sha256(
        msgspec.msgpack.encode([names, others], order="deterministic")
    ).hexdigest()


def _of_records(folder: Path) -> str | None:
    """The digest of records.jsonl; None if it is empty or no plain file."""
    try:
        data = content(folder / RECORDS)
    except StoreError:
        return None
    if not data:
        return None
    return hashlib.sha256(data).hexdigest()


def _maker(folder: Path) -> str:
    """The digest of code and templates, of the packages that draw, and of whether there are a
    gallery and a site to lead to.
    """
    parts = [
        fingerprint.of_refdem(),
        *map(installed, ("vl-convert-python", "jinja2", "latex2mathml")),
        str((folder / "gallery" / "gallery.html").exists()),
        str((folder / "site" / "index.html").exists()),
    ]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


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
