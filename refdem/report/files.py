"""Files of a report, each written whole or not at all."""

import os
from pathlib import Path

from refdem.errors import StoreError


def written(path: Path, content: str | bytes) -> None:
    """Puts `content` at `path`, through a file beside it; raises StoreError that says what to
    do.
    """
    if isinstance(content, str):
        data = content.encode("utf-8", "replace")
    else:
        data = content
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.write_bytes(data)
        beside.replace(path)
    except OSError as error:
        if path.parent.is_dir():
            beside.unlink(missing_ok=True)
        raise StoreError(
            f"cannot write {path}: {error.strerror or error}. Choose another folder with --out."
        ) from None


def removed(path: Path) -> None:
    """Takes away a file of an earlier report, if it is there; raises StoreError."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise StoreError(
            f"cannot remove {path}: {error.strerror or error}. Choose another folder with --out."
        ) from None
