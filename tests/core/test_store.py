"""The store keeps what is finished and says clearly when it cannot."""

import sqlite3
from contextlib import closing

import pytest

from refdem.core.store import Store
from refdem.errors import StoreError


def test_what_is_put_is_read_by_another_connection(tmp_path):
    Store(tmp_path / "s.sqlite").put("run", "k", b"data")
    assert Store(tmp_path / "s.sqlite").get("run", "k") == b"data"
    assert Store(tmp_path / "s.sqlite").get("truth", "k") is None


def test_a_corrupt_file_is_left_alone_and_said_to_be_corrupt(tmp_path):
    path = tmp_path / "s.sqlite"
    path.write_bytes(b"not a database" * 100)
    with pytest.raises(StoreError, match="Move the file away"):
        Store(path)
    assert path.read_bytes() == b"not a database" * 100


def test_a_store_of_another_format_is_refused(tmp_path):
    path = tmp_path / "s.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA user_version=99")
    with pytest.raises(StoreError, match="format 99"):
        Store(path)


def test_a_folder_that_cannot_be_made_is_said_so(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="cannot be used"):
        Store(tmp_path / "file" / "s.sqlite")


def test_what_is_too_large_is_not_kept_and_breaks_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("refdem.core.store.MOST", 10)
    store = Store(tmp_path / "s.sqlite")
    store.put("run", "a", b"0123456789")
    store.put("run", "b", b"0123456789a")
    assert store.get("run", "a") == b"0123456789"
    assert store.get("run", "b") is None
