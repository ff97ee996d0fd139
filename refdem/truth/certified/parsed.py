"""What was read from files of Python, kept from process to process in the user's cache folder.

Parsing the files behind all truths takes most of a second, which every command would pay again. An
entry is found by the content of its file and by everything else on which the result depends, never
by a name or a date; a damaged one is dropped, and made again. Where nothing can be kept, all is
read each time.
"""

import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

from refdem.core.store import cache_folder

MOST = 4_000_000
"""Bytes of the file, at most: some ten thousand entries. A larger one is begun anew."""

FORMAT = b"refdem-parsed-1"
"""Sealed with each entry, so that one of another format counts as damaged."""

Parsed = tuple[str, tuple[str, ...]]
"""The digest of a file's code, and the names of the modules that it imports."""


def parsed(source: bytes, reader: str, parse: Callable[[bytes], Parsed]) -> Parsed:
    """`parse(source)`, or what was kept of it; `reader` names the version of `parse`."""
    key = hashlib.sha256(f"{reader}\0".encode() + source).hexdigest()
    path = cache_folder() / "parsed-sources.txt"
    entries = _entries(path)
    if key not in entries:
        entries[key] = parse(source)
        _keep(path, key, entries[key])
    return entries[key]


@cache
def _entries(path: Path) -> dict[str, Parsed]:
    """The sound entries of a file; this process adds its own."""
    found: dict[str, Parsed] = {}
    with suppress(OSError):
        for line in path.read_bytes().splitlines():
            # A line that another process is just writing, or that is damaged, has another seal.
            seal, _, entry = line.partition(b" ")
            if seal == _seal(entry):
                key, code, names = json.loads(entry)
                found[key] = (code, tuple(names))
    return found


def _keep(path: Path, key: str, read: Parsed) -> None:
    """Adds an entry to the file, in one write, so that processes do not write into one another's
    lines.
    """
    entry = json.dumps([key, *read]).encode()
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and path.stat().st_size > MOST:
            path.unlink()
        # The newline comes first as well: the line before may be torn.
        line = b"\n" + _seal(entry) + b" " + entry + b"\n"
        file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            os.write(file, line)
        finally:
            os.close(file)


def _seal(entry: bytes) -> bytes:
    """A digest of an entry in this format, as text."""
    return hashlib.blake2b(entry, digest_size=16, person=FORMAT).hexdigest().encode()
