"""The store: one SQLite file of finished runs, truths and charts; only the parent process writes
it.

It is a cache, and no fault of it ends a campaign: each is reported by a line on standard error. An
entry whose digest does not match, or that cannot be decoded, is deleted and computed again. A file
that is no database is renamed. If the disk is full or read-only, nothing more is stored.
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
"""Largest size of an entry [bytes]; the limit of SQLite is 1e9."""
PATIENCE = 30.0
"""Seconds to wait for a file that another process has locked."""
PAUSE = 0.05
"""Seconds between attempts to open a file that another process is creating."""
UNREADABLE = (ValueError, KeyError, TypeError, RefdemError)
"""Errors of decoding an entry that another version of refdem wrote."""
FAULTS = (sqlite3.Error, UnicodeDecodeError)
"""Errors that SQLite raises; the second where its message quotes bytes of a damaged file."""
# A table with row numbers. A table WITHOUT ROWID would store the data in the B-tree of the keys,
# and a search of that tree would read megabytes of data on its path.
_TABLE = (
    "CREATE TABLE IF NOT EXISTS entries (kind TEXT, key TEXT, digest BLOB NOT NULL, data BLOB NOT"
    " NULL, PRIMARY KEY (kind, key))"
)
PAGE = 16384
"""Page size of the file [bytes]: about the size of most runs; large runs need few pages."""


def default_path() -> Path:
    """$REFDEM_STORE, or store.sqlite in the user's cache folder."""
    if "REFDEM_STORE" in os.environ:
        return Path(os.environ["REFDEM_STORE"])
    return cache_folder() / "store.sqlite"


def cache_folder() -> Path:
    """The user's cache folder of refdem; it need not exist."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    if cache.startswith("~"):
        # "~" is not expanded for a user without an entry in the password database. A folder named
        # "~" in the working directory must not be created.
        cache = "/.cache"
    return Path(cache) / "refdem"


def digest_of(kind: str, key: str, data: bytes) -> bytes:
    """The BLAKE2b digest (16 bytes) of the kind, key and data of an entry."""
    # The data is added separately: concatenation would copy it.
    digest = hashlib.blake2b(f"{kind}\0{key}\0".encode(), digest_size=16)
    digest.update(data)
    return digest.digest()


class _UnfitError(Exception):
    """The file has another format, and is not changed."""


@dataclass
class _Tally:
    """The counts that are reported when the store is closed."""

    path: Path
    connection: sqlite3.Connection | None = None
    file: int | None = None
    """Inode of the opened file, to detect that another process has renamed it."""
    damaged: int = 0


class Store:
    """Results in a file, by kind and key.

    Every entry is a transaction of its own, so that entries that were written survive if the
    process is killed.
    """

    def __init__(self, path: Path) -> None:
        """Opens the store at `path`, or creates it; never raises (see the module docstring)."""
        self.path = path
        self._tally = _Tally(path)
        # The connection is closed with the object: Python 3.13 warns if it is not.
        self._finish = weakref.finalize(self, _finished, self._tally)
        self._open()

    @property
    def damaged(self) -> int:
        """The number of entries that were dropped because they were damaged."""
        return self._tally.damaged

    @property
    def is_usable(self) -> bool:
        """True if entries can be read and written; otherwise every result is computed again."""
        return self._tally.connection is not None

    def get(self, kind: str, key: str) -> bytes | None:
        """The bytes stored under (kind, key), or None."""
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
        """Stores bytes under (kind, key), unless there are more than MOST; these are recomputed
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
        """Deletes the entry (kind, key), if there is one."""
        if self._tally.connection is not None:
            with suppress(*FAULTS):
                self._tally.connection.execute(
                    "DELETE FROM entries WHERE kind=? AND key=?", (kind, key)
                )

    def truth(self, key: str) -> SampledTruth | None:
        """The sampled truth stored under a key, or None."""
        return self.read("truth", key, msgspec.msgpack.Decoder(SampledTruth).decode)

    def put_truth(self, key: str, truth: SampledTruth) -> None:
        """Stores a sampled truth under its key."""
        self.put("truth", key, msgspec.msgpack.encode(truth))

    def close(self) -> None:
        """Closes the file, and reports damaged entries."""
        self._finish()

    def _open(self) -> None:
        """Opens the file or creates it; a file that is no database is renamed first."""
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
        """Handles an `error` of SQLite: replaces a damaged file by a new one, or stops using the
        store if the file cannot be written.
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
        """Renames a damaged file and opens a new one, unless another process has done so."""
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
        """Deletes one damaged entry, and counts it."""
        self._tally.damaged += 1
        self.forget(kind, key)


def _connected(path: Path) -> sqlite3.Connection:
    """A connection to the file, with its table. Raises OSError, one of FAULTS, or _UnfitError for
    a file of another format.

    SQLite does not wait for a process that is creating the same file, so this function does, for up
    to PATIENCE seconds.
    """
    if path.exists() and not path.is_file():
        # SQLite would create journal files beside a device or pipe, and the device would be renamed
        # as a damaged file.
        raise _UnfitError("it is not a plain file")
    path.parent.mkdir(parents=True, exist_ok=True)
    until = time.monotonic() + PATIENCE
    while True:
        connection = sqlite3.connect(
            # The finalizer of the store may close the connection in another thread.
            path,
            timeout=PATIENCE,
            isolation_level=None,
            check_same_thread=False,
            # A cached statement would hold the data of its last entry in memory.
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
    """Creates the table; entries of an older format are deleted."""
    # A rollback journal instead of a write-ahead log (WAL): the index of a WAL is a memory-mapped
    # file, so that truncating it ends readers by SIGBUS, and it does not work on network file
    # systems.
    connection.execute(f"PRAGMA page_size={PAGE}")
    connection.execute("PRAGMA journal_mode=TRUNCATE")
    # Without synchronisation a power failure may damage entries, which are then deleted and
    # computed again. A killed process damages nothing.
    connection.execute("PRAGMA synchronous=OFF")
    connection.execute("BEGIN IMMEDIATE")
    # The format is read within the transaction. Read before it, the format could be missing in a
    # file that another process is creating, and the entries of that process would be deleted.
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
    """Closes the connection and reports the number of damaged entries on standard error."""
    if tally.connection is not None:
        with closing(tally.connection):
            tally.connection = None
    if tally.damaged:
        _say(f"store {tally.path}: {tally.damaged} damaged entries were dropped and recomputed")


def _say(text: str) -> None:
    """Writes one line to standard error, if there is a standard error."""
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"refdem: {text}", file=sys.stderr)
