"""Checks that the output of a command can be written. They are made before any work, so that no
result is lost.
"""

import tempfile
from pathlib import Path

from refdem.core.named_file import refuse_full
from refdem.errors import StoreError


def refuse_unwritable(folder: Path, option: str = "--out") -> None:
    """Raises StoreError if a folder, which an option or argument names, cannot be made or written.

    Other processes may write to it at the same time.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise StoreError(
            f"folder {folder} cannot be written: {why}. Choose another with {option}."
        ) from None


def refuse_unwritable_file(path: Path | None, option: str) -> None:
    """Raises StoreError if a file that an option names cannot be written; nothing is changed."""
    if path is None:
        return
    try:
        if path.exists():
            refuse_full(path)
        else:
            with tempfile.TemporaryFile(dir=path.parent):
                pass
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise StoreError(
            f"{path} of {option} cannot be written: {why}. Choose another place."
        ) from None
