"""The list of the files of a folder of the store, as reader.py checks it."""

from collections.abc import Mapping

from refdem.truth.certified.writing import sums


def listing(files: Mapping[str, str]) -> str:
    """The text of sha256sums.txt for files, text by name: their number as a comment, which
    `sha256sum -c` passes over, and a digest each.
    """
    return f"# {len(files)} files\n{sums(files)}"
