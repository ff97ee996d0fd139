"""Prints the files that belong in the wheel, one a line: all of one folder but what a build left
there.
"""

import sys
from pathlib import Path

KINDS = {
    ".py",
    ".pyi",
    ".c",
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

if __name__ == "__main__":
    for path in sorted(Path(sys.argv[1]).rglob("*")):
        if path.suffix in KINDS and "__pycache__" not in path.parts:
            print(path)
