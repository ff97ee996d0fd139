"""A file in the user's cache folder: what takes long to make, and is the same wherever the same
versions are installed.

The first line seals name and content: a file that is damaged is made again. Where nothing can be
kept, it is made each time.
"""

import hashlib
from collections.abc import Callable
from contextlib import suppress

from refdem.core.named_file import replace, sweep
from refdem.core.store import cache_folder


def kept_file(name: str, made: Callable[[], bytes]) -> bytes:
    """The content kept under a name, or that of `made()`, which is then kept. The name must contain
    all that decides the content.
    """
    path = cache_folder() / name
    with suppress(OSError):
        seal, _, content = path.read_bytes().partition(b"\n")
        if seal == _seal(name, content):
            return content
    content = made()
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        sweep(path.parent.glob(".*"))
        # Another process finds the whole file or none.
        replace(path, _seal(name, content) + b"\n" + content)
    return content


def _seal(name: str, content: bytes) -> bytes:
    """A digest of name and content, as text."""
    return hashlib.blake2b(name.encode() + b"\0" + content, digest_size=16).hexdigest().encode()
