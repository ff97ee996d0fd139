"""Whether a report is up to date, so that it need not be written again: the store holds digests of
its inputs and the state of its files.
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
    """The state of a report when it was written: digests of its sheets, of its file of records and
    of the code that made it, and the state of its files.
    """

    sheets: str
    records: str | None
    maker: str
    files: Files


def is_current(folder: Path, sheets: Sequence[Sheet], store: Store) -> bool:
    """True if the report in the folder was made of these sheets and is unmodified.

    Times in the sheets are not compared.
    """
    state = _kept_state(folder, store)
    return (
        state is not None
        and state.sheets == _digest_of_sheets(sheets)
        and _is_unmodified(folder, state)
    )


def is_up_to_date(folder: Path, store: Store) -> bool:
    """True if the report in the folder is up to date with its own records.

    The digest of the records is compared; they are not parsed.
    """
    state = _kept_state(folder, store)
    if state is None or state.records is None:
        return False
    return state.records == _digest_of_records(folder) and _is_unmodified(folder, state)


def keep_state(folder: Path, sheets: Sequence[Sheet], store: Store) -> None:
    """Stores the state of a report that has just been written."""
    state = _State(
        _digest_of_sheets(sheets),
        _digest_of_records(folder),
        _digest_of_code(folder),
        _files(folder),
    )
    store.put("report", _text(folder.resolve()), msgspec.json.encode(state))


def _kept_state(folder: Path, store: Store) -> _State | None:
    """The stored state of the report in a folder, None if there is none."""
    return store.read("report", _text(folder.resolve()), msgspec.json.Decoder(_State).decode)


def _is_unmodified(folder: Path, state: _State) -> bool:
    """True if the code that makes reports and all files in the folder are unchanged."""
    return state.maker == _digest_of_code(folder) and state.files == _files(folder)


def _digest_of_sheets(sheets: Sequence[Sheet]) -> str:
    """The digest of all sheets but the times of the campaign."""
    others = [sheet for sheet in sheets if not isinstance(sheet, CampaignSheet)]
    names = [sheet.name for sheet in sheets if isinstance(sheet, CampaignSheet)]
    return hashlib.sha256(
        msgspec.msgpack.encode([names, others], order="deterministic")
    ).hexdigest()


def _digest_of_records(folder: Path) -> str | None:
    """The digest of records.jsonl; None if it is empty or no plain file."""
    try:
        data = content(folder / RECORDS)
    except StoreError:
        return None
    if not data:
        return None
    return hashlib.sha256(data).hexdigest()


def _digest_of_code(folder: Path) -> str:
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
    """A path as valid UTF-8; file names may hold any bytes."""
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
