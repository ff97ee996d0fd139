"""Files in the user's cache folder, for content that takes long to compute and depends on its name
only.

The first line of a file is a digest of name and content. A file whose digest does not match is
computed again. If the folder cannot be written, the content is computed at every call.
"""

import hashlib
from collections.abc import Callable
from contextlib import suppress

from refdem.core.named_file import replace, sweep
from refdem.core.store import cache_folder


def kept_file(name: str, made: Callable[[], bytes]) -> bytes:
    """The content of the cached file `name`, or `made()`, which is then written to the cache.

    `name` must contain everything on which the content depends, such as versions.
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
        # The file is replaced atomically, so that other processes never read part of it.
        replace(path, _seal(name, content) + b"\n" + content)
    return content


def _seal(name: str, content: bytes) -> bytes:
    """The hexadecimal BLAKE2b digest of name and content."""
    return hashlib.blake2b(name.encode() + b"\0" + content, digest_size=16).hexdigest().encode()
