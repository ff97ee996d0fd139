"""Prints the files that belong in the wheel, one a line: all of refdem/ and validation/ but what a build left there."""

from pathlib import Path

KINDS = {".py", ".c", ".h", ".toml", ".csv", ".json", ".html", ".css", ".js", ".md", ".txt", ".typed"}

if __name__ == "__main__":
    for folder in ("refdem", "validation"):
        for path in sorted(Path(folder).rglob("*")):
            if path.suffix in KINDS and "__pycache__" not in path.parts:
                print(path)
