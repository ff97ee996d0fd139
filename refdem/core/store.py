"""The store: one SQLite file of finished runs, truths and charts; only the parent process writes it."""

import os
import sqlite3
import weakref
from pathlib import Path

import msgspec

from refdem.core.truth import SampledTruth
from refdem.errors import StoreError

FORMAT = 1
MOST = 250_000_000
"""Bytes of an entry, at most; SQLite takes 1e9."""
_TABLES = "CREATE TABLE IF NOT EXISTS entries (kind TEXT, key TEXT, data BLOB NOT NULL, PRIMARY KEY (kind, key)) WITHOUT ROWID"


def default_path() -> Path:
    """$REFDEM_STORE, or store.sqlite in the user's cache folder."""
    if "REFDEM_STORE" in os.environ:
        return Path(os.environ["REFDEM_STORE"])
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(cache) / "refdem" / "store.sqlite"


class Store:
    """Finished work by key. A transaction an entry: killed at any moment, what is finished stays."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(path, timeout=30, isolation_level=None)
            weakref.finalize(self, self._connection.close)  # Python 3.13 warns of a connection that nobody closed
            self._connection.execute("PRAGMA journal_mode=WAL")
            self._connection.execute("PRAGMA synchronous=NORMAL")
            (version,) = self._connection.execute("PRAGMA user_version").fetchone()
            if version not in (0, FORMAT):
                raise StoreError(f"store {path} has format {version}; expected {FORMAT}. Move it away or set REFDEM_STORE.")
            self._connection.execute(_TABLES)
            self._connection.execute(f"PRAGMA user_version={FORMAT}")
        except (sqlite3.Error, OSError) as error:
            raise self._unusable(error) from None

    def _unusable(self, error: Exception) -> StoreError:
        return StoreError(f"store {self.path} cannot be used: {error}. Move the file away (it can be made again) or set REFDEM_STORE.")

    def get(self, kind: str, key: str) -> bytes | None:
        """The bytes kept under (kind, key), or None."""
        try:
            row = self._connection.execute("SELECT data FROM entries WHERE kind=? AND key=?", (kind, key)).fetchone()
        except sqlite3.Error as error:
            raise self._unusable(error) from None
        return row[0] if row else None

    def put(self, kind: str, key: str, data: bytes) -> None:
        """Keeps bytes under (kind, key), unless there are too many of them: those are made again when they are asked for."""
        if len(data) > MOST:
            return
        try:
            self._connection.execute("INSERT OR REPLACE INTO entries VALUES (?, ?, ?)", (kind, key, data))
        except sqlite3.Error as error:
            raise self._unusable(error) from None

    def truth(self, key: str) -> SampledTruth | None:
        """The sampled truth kept under a key, or None."""
        data = self.get("truth", key)
        return msgspec.msgpack.decode(data, type=SampledTruth) if data else None

    def put_truth(self, key: str, truth: SampledTruth) -> None:
        """Keeps a sampled truth."""
        self.put("truth", key, msgspec.msgpack.encode(truth))

    def close(self) -> None:
        """Closes the file."""
        self._connection.close()
