"""Processes of this machine, found by a word in their command lines."""

from pathlib import Path


def processes(word: str) -> list[str]:
    """Numbers of the processes whose command line has the word."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if word.encode() in path.read_bytes():
                found.append(path.parent.name)
        except OSError:
            # It has ended since it was listed.
            continue
    return found
