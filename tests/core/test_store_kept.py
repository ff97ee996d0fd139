"""What a store keeps can be read by the next version: the digest of an entry, the format and the
limits are those that the file has had.
"""

import hashlib
import sqlite3

import pytest

from refdem.core import store as stores
from refdem.core.store import Store, digest_of


def test_the_digest_of_an_entry_is_sixteen_bytes_of_blake2b_of_kind_key_and_data():
    whole = hashlib.blake2b(b"truth\0key\0data", digest_size=16)
    assert digest_of("truth", "key", b"data") == whole.digest()
    # The same as a number, so that a store of today can be read tomorrow.
    assert digest_of("truth", "key", b"data").hex() == "71b5c5066602b36e2a753dad2e6b5d1f"
    assert digest_of("truth", "keyd", b"ata") != digest_of("truth", "key", b"data")


def test_an_entry_that_was_written_by_hand_in_format_3_is_read(tmp_path):
    path = tmp_path / "store.sqlite"
    with sqlite3.connect(path) as by_hand:
        by_hand.execute(
            "CREATE TABLE entries (kind TEXT, key TEXT, digest BLOB NOT NULL, data BLOB NOT NULL,"
            " PRIMARY KEY (kind, key))"
        )
        row = ("run", "k", hashlib.blake2b(b"run\0k\0bytes", digest_size=16).digest(), b"bytes")
        by_hand.execute("INSERT INTO entries VALUES (?, ?, ?, ?)", row)
        by_hand.execute("PRAGMA user_version=3")
    by_hand.close()
    store = Store(path)
    assert store.get("run", "k") == b"bytes"
    store.close()


def test_bytes_up_to_the_most_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(stores, "MOST", 8)
    store = Store(tmp_path / "store.sqlite")
    for size, kept in ((8, True), (9, False)):
        store.put("run", str(size), b"x" * size)
        assert (store.get("run", str(size)) is not None) == kept
    store.close()


def test_a_closed_store_keeps_its_file_for_nobody(tmp_path):
    """A connection that stays open holds the file: on Windows it could not be removed."""
    path = tmp_path / "store.sqlite"
    store = Store(path)
    store.put("run", "k", b"x")
    connection = store._tally.connection
    store.close()
    assert not store.is_usable
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        connection.execute("SELECT 1")


def test_a_connection_to_a_file_that_cannot_be_prepared_is_closed(tmp_path, monkeypatch):
    opened = []
    connect = sqlite3.connect

    def noted(*given, **more):
        opened.append(connect(*given, **more))
        return opened[-1]

    def busy_once(connection):
        if len(opened) == 1:
            raise sqlite3.OperationalError("database is locked")
        prepare(connection)

    prepare = stores._prepare
    monkeypatch.setattr(stores.sqlite3, "connect", noted)
    monkeypatch.setattr(stores, "_prepare", busy_once)
    store = Store(tmp_path / "store.sqlite")
    assert store.is_usable
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        opened[0].execute("SELECT 1")
    store.close()

    def full(connection):
        raise sqlite3.OperationalError("disk I/O error")

    monkeypatch.setattr(stores, "_prepare", full)
    refused = Store(tmp_path / "other.sqlite")
    assert not refused.is_usable
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        opened[-1].execute("SELECT 1")
    refused.close()


def test_a_wait_for_another_process_ends_with_patience(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(stores, "PATIENCE", 0.0)

    def busy(connection):
        raise sqlite3.OperationalError("database is busy")

    monkeypatch.setattr(stores, "_prepare", busy)
    store = Store(tmp_path / "store.sqlite")
    assert not store.is_usable
    assert "cannot be used: database is busy" in capfd.readouterr().err
    store.close()
