"""Where a command writes: looked at before any work is done, so that no result is lost for want of
a place.
"""

import tempfile
from pathlib import Path

from refdem.errors import StoreError


def refuse_unwritable(folder: Path) -> None:
    """Raises StoreError if a folder cannot be made or written.

    Others may be writing there at the same time.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise StoreError(
            f"folder {folder} cannot be written: {error.strerror}. Choose another with --out."
        ) from None


def refuse_unwritable_file(path: Path | None, option: str) -> None:
    """Raises StoreError if a file that an option names cannot be written; nothing is changed."""
    if path is None:
        return
    try:
        if path.exists():
            with path.open("ab"):
                pass
        else:
            with tempfile.TemporaryFile(dir=path.parent):
                pass
    except OSError as error:
        raise StoreError(
            f"{path} of {option} cannot be written: {error.strerror}. Choose another place."
        ) from None
