"""The spool: the packed trajectories of a campaign, in a temporary file until they are judged."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO

from refdem.errors import StoreError

IN_MEMORY = 16_000_000
"""Bytes that a spool holds in memory; with more it is a file."""


class Spool:
    """Bytes by key, for as long as `file` is open."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._places: dict[str, tuple[int, int]] = {}
        """Offset and length of each entry."""

    def keep(self, key: str, data: bytes | memoryview) -> None:
        """Keeps bytes under a key; raises StoreError if the file cannot be written."""
        try:
            offset = self._file.seek(0, os.SEEK_END)
            self._file.write(data)
            self._file.flush()
        except OSError as error:
            raise StoreError(
                f"the folder of temporary files {tempfile.gettempdir()} cannot be written:"
                f" {error.strerror}; expected room for all trajectories of the campaign: set TMPDIR"
                " to another folder"
            ) from None
        self._places[key] = offset, len(data)

    def size(self, key: str) -> int:
        """The number of bytes that are kept under a key; raises KeyError if there are none."""
        return self._places[key][1]

    def read(self, key: str) -> bytes:
        """The bytes that are kept under a key; raises KeyError if there are none."""
        offset, length = self._places[key]
        self._file.seek(offset)
        return self._file.read(length)


@contextmanager
def spool() -> Iterator[Spool]:
    """An empty spool for this context.

    Its file has no name, so that nothing remains if the process is killed.
    """
    with tempfile.SpooledTemporaryFile(max_size=IN_MEMORY) as file:
        yield Spool(file)
