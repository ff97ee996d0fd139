"""What becomes of a store's connections: none is left open where the file cannot be used, and any
thread may collect what nobody closed.
"""

import gc
import os
import sqlite3
import sys
import threading
from pathlib import Path

import pytest

from refdem.core import store as store_module
from refdem.core.store import FORMAT, Store

BUSY = sqlite3.OperationalError("database is locked")
ILL = sqlite3.OperationalError("disk I/O error")
DAMAGED = sqlite3.DatabaseError("file is not a database")


def is_open(connection: sqlite3.Connection) -> bool:
    """Whether a connection can still be asked."""
    try:
        connection.execute("SELECT 1")
    except sqlite3.ProgrammingError:
        return False
    return True


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[sqlite3.Connection]:
    """All connections that are made from now on."""
    found: list[sqlite3.Connection] = []
    connect = sqlite3.connect

    def connected(*arguments: object, **options: object) -> sqlite3.Connection:
        found.append(connect(*arguments, **options))  # type: ignore[call-overload]
        return found[-1]

    monkeypatch.setattr(store_module.sqlite3, "connect", connected)
    monkeypatch.setattr(store_module, "PAUSE", 0.0)
    return found


def failing(monkeypatch: pytest.MonkeyPatch, *errors: Exception) -> None:
    """The table cannot be made the first times, each time for its reason; then it can."""
    prepare = store_module._prepare
    waiting = list(errors)

    def prepared(connection: sqlite3.Connection) -> None:
        if waiting:
            raise waiting.pop(0)
        prepare(connection)

    monkeypatch.setattr(store_module, "_prepare", prepared)


@pytest.mark.parametrize("errors", [(BUSY,), (BUSY, BUSY, BUSY), (DAMAGED,)], ids=str)
def test_attempts_before_the_one_that_opened_the_file_are_closed(
    tmp_path: Path,
    made: list[sqlite3.Connection],
    monkeypatch: pytest.MonkeyPatch,
    errors: tuple[Exception, ...],
) -> None:
    (tmp_path / "s.sqlite").touch()
    failing(monkeypatch, *errors)
    store = Store(tmp_path / "s.sqlite")
    assert store.is_usable
    assert list(map(is_open, made)) == [*(False for _ in errors), True]
    store.close()
    assert not any(map(is_open, made))


@pytest.mark.parametrize(
    ("patience", "error", "attempts"), [(1e9, ILL, 1), (-1.0, BUSY, 1)], ids=["ill", "busy"]
)
def test_a_file_that_cannot_be_used_leaves_no_connection(
    tmp_path: Path,
    made: list[sqlite3.Connection],
    monkeypatch: pytest.MonkeyPatch,
    patience: float,
    error: Exception,
    attempts: int,
) -> None:
    """What is no matter of waiting is not waited for; a file that stays busy is given up."""
    monkeypatch.setattr(store_module, "PATIENCE", patience)
    failing(monkeypatch, *[error] * (attempts + 1))
    assert not Store(tmp_path / "s.sqlite").is_usable
    assert len(made) == attempts
    assert not any(map(is_open, made))


def test_a_file_of_a_newer_format_leaves_no_connection(
    tmp_path: Path, made: list[sqlite3.Connection]
) -> None:
    Store(tmp_path / "s.sqlite").close()
    (first,) = made
    later = sqlite3.connect(tmp_path / "s.sqlite")
    later.execute(f"PRAGMA user_version={FORMAT + 1}")
    later.close()
    made.clear()
    assert not Store(tmp_path / "s.sqlite").is_usable
    assert not is_open(first)
    assert len(made) == 1
    assert not is_open(made[0])


def test_a_store_may_be_collected_by_another_thread_than_the_one_that_opened_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    wrong: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", wrong.append)
    monkeypatch.setattr(threading, "excepthook", wrong.append)
    stores = [Store(tmp_path / "s.sqlite")]
    stores[0].put("run", "a", b"data")
    connection = stores[0]._tally.connection
    assert connection is not None

    def collects() -> None:
        stores.clear()
        gc.collect()

    thread = threading.Thread(target=collects)
    thread.start()
    thread.join()
    assert wrong == []
    assert not is_open(connection)
    assert capfd.readouterr().err == ""
    assert Store(tmp_path / "s.sqlite").get("run", "a") == b"data"


def test_a_file_beside_the_store_that_is_cut_short_kills_no_reader(tmp_path: Path) -> None:
    """In WAL mode every process maps an index, and reading it ends with SIGBUS."""
    store = Store(tmp_path / "store.sqlite")
    store.put("run", "k", b"data")
    for beside in tmp_path.glob("store.sqlite-*"):
        os.truncate(beside, 0)
    assert store.get("run", "k") == b"data"
    store.close()


def test_a_store_that_an_older_refdem_left_in_wal_mode_is_read(tmp_path: Path) -> None:
    path = tmp_path / "store.sqlite"
    older = Store(path)
    older.put("run", "k", b"data")
    older._tally.connection.execute("PRAGMA journal_mode=WAL")
    older.close()
    store = Store(path)
    assert store.get("run", "k") == b"data"
    assert store._tally.connection.execute("PRAGMA journal_mode").fetchone() == ("truncate",)
    store.close()
