"""The store is a cache: what is wrong with it costs a line on stderr and time, never a verdict or a
campaign.
"""

import os
import random
import sqlite3
import subprocess
import sys
from contextlib import closing

import msgspec
import pytest

from refdem.core.store import FORMAT, Store, _prepare, default_path, digest_of


def test_what_is_put_is_read_by_another_connection(tmp_path):
    Store(tmp_path / "s.sqlite").put("run", "k", b"data")
    assert Store(tmp_path / "s.sqlite").get("run", "k") == b"data"
    assert Store(tmp_path / "s.sqlite").get("truth", "k") is None


def test_a_file_that_is_no_database_is_moved_aside_and_made_anew(tmp_path, capfd):
    path = tmp_path / "s.sqlite"
    path.write_bytes(b"not a database" * 100)
    store = Store(path)
    store.put("run", "k", b"data")
    assert store.get("run", "k") == b"data"
    assert (tmp_path / "s.sqlite.damaged").read_bytes() == b"not a database" * 100
    assert capfd.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("suffix", ["-journal", "-wal", "-shm"])
def test_what_lay_beside_a_damaged_file_is_taken_away_with_it(tmp_path, capfd, suffix):
    path = tmp_path / "s.sqlite"
    path.write_bytes(b"not a database" * 100)
    beside = tmp_path / f"s.sqlite{suffix}"
    beside.write_bytes(b"of the damaged one" * 1000)
    store = Store(path)
    store.put("run", "k", b"data")
    assert store.get("run", "k") == b"data"
    store.close()
    assert not beside.exists() or b"of the damaged one" not in beside.read_bytes()
    assert capfd.readouterr().err.count("\n") == 1


def test_a_store_of_a_newer_format_is_left_as_it_is(tmp_path, capfd):
    path = tmp_path / "s.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA user_version=99")
    store = Store(path)
    store.put("run", "k", b"data")
    assert store.get("run", "k") is None
    assert "format 99" in capfd.readouterr().err
    with closing(sqlite3.connect(path)) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (99,)


def test_entries_of_an_older_format_are_dropped(tmp_path):
    path = tmp_path / "s.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(
            "CREATE TABLE entries (kind TEXT, key TEXT, data BLOB, PRIMARY KEY (kind, key))"
        )
        connection.execute("INSERT INTO entries VALUES ('run', 'k', x'00')")
        connection.execute(f"PRAGMA user_version={FORMAT - 1}")
        connection.commit()
    store = Store(path)
    assert store.get("run", "k") is None
    store.put("run", "k", b"data")
    assert store.get("run", "k") == b"data"


def test_what_is_no_plain_file_is_left_alone_and_costs_the_store(tmp_path, capfd):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    for name in ("pipe", "link", "."):
        store = Store(tmp_path / name)
        store.put("run", "k", b"data")
        assert not store.is_usable
        assert "it is not a plain file" in capfd.readouterr().err
    assert sorted(os.listdir(tmp_path)) == ["link", "pipe"]


def test_who_has_no_home_gets_no_folder_named_after_one(monkeypatch):
    for name in ("REFDEM_STORE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    assert default_path().is_absolute()


def test_a_folder_that_cannot_be_made_costs_the_store_and_nothing_else(tmp_path, capfd):
    (tmp_path / "file").write_text("")
    store = Store(tmp_path / "file" / "s.sqlite")
    store.put("run", "k", b"data")
    assert store.get("run", "k") is None
    assert not store.is_usable
    assert capfd.readouterr().err.startswith("refdem: store ")


def test_a_full_disk_costs_what_comes_after_it(tmp_path, capfd):
    store = Store(tmp_path / "s.sqlite")
    store.put("run", "a", b"data")
    store._tally.connection.execute("PRAGMA max_page_count=2")
    store.put("run", "b", bytes(10**6))
    store.put("run", "c", b"data")
    assert "full" in capfd.readouterr().err
    assert Store(tmp_path / "s.sqlite").get("run", "a") == b"data"
    assert Store(tmp_path / "s.sqlite").get("run", "c") is None


def test_what_is_too_large_is_not_kept_and_breaks_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("refdem.core.store.MOST", 10)
    store = Store(tmp_path / "s.sqlite")
    store.put("run", "a", b"0123456789")
    store.put("run", "b", b"0123456789a")
    assert store.get("run", "a") == b"0123456789"
    assert store.get("run", "b") is None


@pytest.mark.parametrize("seed", range(40))
def test_a_flipped_bit_anywhere_gives_the_same_bytes_or_none(tmp_path, seed):
    path = tmp_path / "s.sqlite"
    store = Store(path)
    wanted = {str(n): bytes([n]) * (200 * n + 1) for n in range(40)}
    for key, data in wanted.items():
        store.put("run", key, data)
    store._tally.connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    store.close()
    content = bytearray(path.read_bytes())
    place = random.Random(seed).randrange(8 * len(content))
    content[place // 8] ^= 1 << place % 8
    path.write_bytes(content)
    again = Store(path)
    found = {key: again.get("run", key) for key in wanted}
    assert {key for key, data in found.items() if data is not None and data != wanted[key]} == set()
    again.put("run", "1", wanted["1"])
    assert again.get("run", "1") == wanted["1"]


def test_damaged_entries_are_counted_in_one_line(tmp_path, capfd):
    store = Store(tmp_path / "s.sqlite")
    for key in "abc":
        store.put("run", key, b"data")
    store._tally.connection.execute("UPDATE entries SET data=x'0102' WHERE key != 'c'")
    assert [store.get("run", key) for key in "abc"] == [None, None, b"data"]
    store.close()
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "2 damaged entries" in said


def test_an_entry_under_another_key_is_no_entry(tmp_path):
    store = Store(tmp_path / "s.sqlite")
    store.put("run", "a", b"data")
    store._tally.connection.execute("UPDATE entries SET key='b'")
    assert store.get("run", "b") is None
    assert digest_of("run", "a", b"data") != digest_of("run", "b", b"data")


def test_what_does_not_decode_is_dropped(tmp_path):
    store = Store(tmp_path / "s.sqlite")
    store.put("run", "a", msgspec.msgpack.encode({"x": 1}))
    decode = msgspec.msgpack.Decoder(list[int]).decode
    assert store.read("run", "a", decode) is None
    assert store.get("run", "a") is None
    assert store.damaged == 1


def test_many_processes_may_make_one_store_at_once(tmp_path):
    code = (
        "import sys; from pathlib import Path; from refdem.core.store import Store; "
        "store = Store(Path(sys.argv[1])); store.put('run', sys.argv[2], b'data'); "
        "assert store.get('run', sys.argv[2]) == b'data'"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "new" / "s.sqlite")]
    running = [subprocess.Popen([*command, str(n)], stderr=subprocess.PIPE) for n in range(8)]
    said = [process.communicate()[1] for process in running]
    assert said == [b""] * 8
    store = Store(tmp_path / "new" / "s.sqlite")
    assert [store.get("run", str(n)) for n in range(8)] == [b"data"] * 8


def test_what_another_process_kept_while_both_made_the_file_stays(tmp_path):
    path = tmp_path / "s.sqlite"

    class Overtaken(sqlite3.Connection):
        """A connection that another process overtakes just before its transaction."""

        def execute(self, sql, *parameters):
            if sql == "BEGIN IMMEDIATE":
                other = Store(path)
                other.put("run", "a", b"data")
                other.close()
            return super().execute(sql, *parameters)

    with closing(sqlite3.connect(path, isolation_level=None, factory=Overtaken)) as connection:
        _prepare(connection)
    assert Store(path).get("run", "a") == b"data"


def test_a_file_that_another_process_made_anew_is_not_moved_aside(tmp_path, capfd):
    path = tmp_path / "s.sqlite"
    stores = [Store(path), Store(path)]
    damage = sqlite3.DatabaseError("database disk image is malformed")
    stores[0]._failed(damage)
    stores[0].put("run", "a", b"data")
    stores[1]._failed(damage)
    assert stores[1].get("run", "a") == b"data"
    assert stores[0].get("run", "a") == b"data"
    assert capfd.readouterr().err.count("was damaged") == 1
