"""The store: one SQLite file of finished runs, truths and charts; only the parent process writes
it.

It is a cache. A fault of it costs time and a line on standard error, never a campaign: an entry
whose digest does not match, or which does not decode, is dropped and made again; a file that is no
database is moved aside; where the disk is full or read-only, nothing more is kept.
"""

import hashlib
import os
import sqlite3
import sys
import time
import weakref
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import msgspec

from refdem.core.truth import SampledTruth
from refdem.errors import RefdemError

T = TypeVar("T")

FORMAT = 3
"""Version of the format of the file, which grows with every change that older readers cannot read.
"""
MOST = 250_000_000
"""Bytes of an entry, at most; SQLite takes 1e9."""
PATIENCE = 30.0
"""Seconds for which another process may hold the file."""
PAUSE = 0.05
"""Seconds between attempts to open a file that another process is making."""
UNREADABLE = (ValueError, KeyError, TypeError, RefdemError)
"""Errors of decoding an entry that another version of refdem wrote."""
FAULTS = (sqlite3.Error, UnicodeDecodeError)
"""Errors that SQLite raises; the second where its message quotes bytes of a damaged file."""
# A table with row numbers: without them, entries lie in the tree of the keys itself, and each
# search of it reads megabytes of those that it passes.
_TABLE = (
    "CREATE TABLE IF NOT EXISTS entries (kind TEXT, key TEXT, digest BLOB NOT NULL, data BLOB NOT"
    " NULL, PRIMARY KEY (kind, key))"
)
PAGE = 16384
"""Bytes of a page of the file: most runs are of this size, and large ones need fewer pages."""


def default_path() -> Path:
    """$REFDEM_STORE, or store.sqlite in the user's cache folder."""
    if "REFDEM_STORE" in os.environ:
        return Path(os.environ["REFDEM_STORE"])
    return cache_folder() / "store.sqlite"


def cache_folder() -> Path:
    """The user's cache folder of refdem; it need not exist."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    if cache.startswith("~"):
        # A user whom the system does not know has no home: not a folder named "~" in this one.
        cache = "/.cache"
    return Path(cache) / "refdem"


def digest_of(kind: str, key: str, data: bytes) -> bytes:
    """The digest of an entry: of its kind, its key and its bytes."""
    # Not of one sum of bytes, which is a copy of the data.
    digest = hashlib.blake2b(f"{kind}\0{key}\0".encode(), digest_size=16)
    digest.update(data)
    return digest.digest()


class _UnfitError(Exception):
    """The file has another format; it is left as it is."""


@dataclass
class _Tally:
    """The counts that are reported when the store is closed."""

    path: Path
    connection: sqlite3.Connection | None = None
    file: int | None = None
    """The inode that was opened: another process may have moved it aside since."""
    damaged: int = 0


class Store:
    """A file that keeps finished work by key.

    A transaction an entry: killed at any moment, what is finished stays.
    """

    def __init__(self, path: Path) -> None:
        """Opens the store at `path` or makes it; never raises, see the head of this module."""
        self.path = path
        self._tally = _Tally(path)
        # Python 3.13 warns of a connection that was not closed.
        self._finish = weakref.finalize(self, _finished, self._tally)
        self._open()

    @property
    def damaged(self) -> int:
        """The number of entries that were dropped because they were damaged."""
        return self._tally.damaged

    @property
    def is_usable(self) -> bool:
        """True if entries are read and kept; else everything is made anew."""
        return self._tally.connection is not None

    def get(self, kind: str, key: str) -> bytes | None:
        """The bytes kept under (kind, key), or None."""
        connection = self._tally.connection
        if connection is None:
            return None
        try:
            cursor = connection.execute(
                "SELECT digest, data FROM entries WHERE kind=? AND key=?", (kind, key)
            )
            row = cursor.fetchone()
        except FAULTS as error:
            self._failed(error)
            return None
        if row is None:
            return None
        digest, data = row
        if not isinstance(data, bytes) or digest != digest_of(kind, key, data):
            self._drop(kind, key)
            return None
        return data

    def read(self, kind: str, key: str, decode: Callable[[bytes], T]) -> T | None:
        """The result of `decode` on the bytes under (kind, key).

        None if there are none, or if `decode` fails: the entry is then dropped.
        """
        data = self.get(kind, key)
        if data is None:
            return None
        try:
            return decode(data)
        except UNREADABLE:
            self._drop(kind, key)
            return None

    def put(self, kind: str, key: str, data: bytes) -> None:
        """Keeps bytes under (kind, key), unless there are too many of them; these are recomputed
        when they are needed.
        """
        connection = self._tally.connection
        if connection is None or len(data) > MOST:
            return
        entry = (kind, key, digest_of(kind, key, data), data)
        try:
            connection.execute("INSERT OR REPLACE INTO entries VALUES (?, ?, ?, ?)", entry)
        except FAULTS as error:
            self._failed(error)

    def forget(self, kind: str, key: str) -> None:
        """Deletes what is kept under (kind, key), if anything is."""
        if self._tally.connection is not None:
            with suppress(*FAULTS):
                self._tally.connection.execute(
                    "DELETE FROM entries WHERE kind=? AND key=?", (kind, key)
                )

    def truth(self, key: str) -> SampledTruth | None:
        """The sampled truth kept under a key, or None."""
        return self.read("truth", key, msgspec.msgpack.Decoder(SampledTruth).decode)

    def put_truth(self, key: str, truth: SampledTruth) -> None:
        """Stores a sampled truth under its key."""
        self.put("truth", key, msgspec.msgpack.encode(truth))

    def close(self) -> None:
        """Closes the file, and reports damaged entries."""
        self._finish()

    def _open(self) -> None:
        """Opens the file or makes it; a file that is no database is moved aside first."""
        try:
            self._connect()
        except (_UnfitError, sqlite3.OperationalError, OSError) as error:
            _say(
                f"store {self.path} cannot be used: {error}. Nothing is stored; correct this, or"
                " set REFDEM_STORE to another file"
            )
        except FAULTS as error:
            self._renew(error)

    def _connect(self) -> None:
        """Opens the file; raises what `_connected` raises."""
        self._tally.connection = _connected(self.path)
        self._tally.file = _inode(self.path)

    def _failed(self, error: Exception) -> None:
        """Replaces a damaged file by a new one; works on without a store where SQLite cannot write.

        `error` is what SQLite raised.
        """
        connection = self._tally.connection
        self._tally.connection = None
        if connection is not None:
            with suppress(sqlite3.Error):
                connection.close()
        # Errors of the system (locked, full, read-only) are OperationalErrors; a damaged file is a
        # DatabaseError itself.
        if isinstance(error, sqlite3.OperationalError):
            _say(f"store {self.path} is no longer usable: {error}. Later results are not stored")
        else:
            self._renew(error)

    def _renew(self, error: Exception) -> None:
        """Moves a damaged file aside and opens a new one, unless another process already has."""
        aside = self.path.with_name(f"{self.path.name}.damaged")
        inode = _inode(self.path)
        is_renewed = self._tally.file is not None and inode != self._tally.file
        try:
            if not is_renewed:
                os.replace(self.path, aside)
                for suffix in ("-journal", "-wal", "-shm"):
                    self.path.with_name(self.path.name + suffix).unlink(missing_ok=True)
            self._connect()
        except (_UnfitError, *FAULTS, OSError) as second:
            _say(
                f"store {self.path} is damaged ({error}) and cannot be recreated: {second}. Nothing"
                " is stored"
            )
            return
        if is_renewed:
            return
        _say(
            f"store {self.path} was damaged ({error}); it is now {aside.name}, and its contents are"
            " recomputed"
        )

    def _drop(self, kind: str, key: str) -> None:
        """Deletes one entry from the store that is damaged."""
        self._tally.damaged += 1
        self.forget(kind, key)


def _connected(path: Path) -> sqlite3.Connection:
    """The open file with its table. Raises OSError, what FAULTS has, or _UnfitError for another
    format.

    SQLite does not wait for a process that is just making the same file, so this does.
    """
    if path.exists() and not path.is_file():
        # SQLite would make files beside a device, and such a file would be moved aside as damaged.
        raise _UnfitError("it is not a plain file")
    path.parent.mkdir(parents=True, exist_ok=True)
    until = time.monotonic() + PATIENCE
    while True:
        connection = sqlite3.connect(
            # What is left of a store may be closed by whatever thread collects it.
            path,
            timeout=PATIENCE,
            isolation_level=None,
            check_same_thread=False,
            # A statement that is kept for the next time keeps its last entry too.
            cached_statements=0,
        )
        try:
            _prepare(connection)
        except sqlite3.OperationalError as error:
            connection.close()
            is_busy = "locked" in str(error) or "busy" in str(error)
            if not is_busy or time.monotonic() > until:
                raise
            time.sleep(PAUSE)
        except BaseException:
            connection.close()
            raise
        else:
            return connection


def _inode(path: Path) -> int | None:
    """The inode number of the file that has this name now; None if there is none."""
    try:
        return path.stat().st_ino
    except OSError:
        return None


def _prepare(connection: sqlite3.Connection) -> None:
    """Makes the table; entries of an older format are dropped."""
    # A journal of its own, not WAL, whose index every process maps: who cuts that file short kills
    # the reader by SIGBUS, and it cannot be on a network's file system.
    connection.execute(f"PRAGMA page_size={PAGE}")
    connection.execute("PRAGMA journal_mode=TRUNCATE")
    # What a power failure damages is dropped and made again; a process that is killed damages
    # nothing.
    connection.execute("PRAGMA synchronous=OFF")
    connection.execute("BEGIN IMMEDIATE")
    # The format is read within the transaction: before it, another process that is making the same
    # file may still have to write it, and what that process kept meanwhile would be dropped.
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if version > FORMAT:
        connection.execute("ROLLBACK")
        raise _UnfitError(
            f"it has format {version}, of a newer refdem or another program; expected {FORMAT}"
        )
    if version < FORMAT:
        connection.execute("DROP TABLE IF EXISTS entries")
    connection.execute(_TABLE)
    connection.execute(f"PRAGMA user_version={FORMAT}")
    connection.execute("COMMIT")


def _finished(tally: _Tally) -> None:
    """Closes the connection and says in one line how many entries were damaged."""
    if tally.connection is not None:
        with closing(tally.connection):
            tally.connection = None
    if tally.damaged:
        _say(f"store {tally.path}: {tally.damaged} damaged entries were dropped and recomputed")


def _say(text: str) -> None:
    """One line on standard error, if there is one."""
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"refdem: {text}", file=sys.stderr)
