"""Files of a report, each written whole or not at all."""

from pathlib import Path

from refdem.core.named_file import put, replace
from refdem.errors import StoreError


def written(path: Path, content: str | bytes) -> None:
    """Writes `content` to `path` atomically, through a temporary file beside it.

    Raises StoreError with a message that states what to do.
    """
    data = encoded(content)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace(path, data)
    except OSError as error:
        raise StoreError(
            f"cannot write {path}: {error.strerror or error}. Choose another folder with --out."
        ) from None


def encoded(content: str | bytes) -> bytes:
    """The bytes of a file with this content."""
    if isinstance(content, str):
        return content.encode("utf-8", "replace")
    return content


def written_to(path: Path, content: str | bytes, option: str) -> None:
    """Writes `content` to the path of an option, and replaces what is there; raises StoreError."""
    try:
        put(path, encoded(content))
    except OSError as error:
        raise StoreError(
            f"cannot write {path}: {error.strerror or error}. Choose another place with {option}."
        ) from None


def removed(path: Path) -> None:
    """Deletes a file of an earlier report, if it exists; raises StoreError."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise StoreError(
            f"cannot remove {path}: {error.strerror or error}. Choose another folder with --out."
        ) from None
