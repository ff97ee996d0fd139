"""Prints the files that belong in the wheel, one a line: all of one folder but what a build left
there.
"""

import sys
from pathlib import Path

KINDS = {
    ".py",
    ".pyi",
    ".c",
    ".cpp",
    ".h",
    ".toml",
    ".csv",
    ".json",
    ".jsonl",
    ".html",
    ".in",
    ".css",
    ".js",
    ".md",
    ".txt",
    ".typed",
}
NAMES = {"Makefile"}

if __name__ == "__main__":
    for path in sorted(Path(sys.argv[1]).rglob("*")):
        is_source = path.suffix in KINDS or path.name in NAMES
        if is_source and "__pycache__" not in path.parts:
            print(path)
