"""Prints the faults of the kill matrix that the files changed since a commit can touch:
ci/testing/touched_faults.py [COMMIT].

`all` where the change can touch every one of them, nothing where it can touch none, else their
names, separated by commas. Without a commit it is the point at which this branch left the main one;
if that cannot be determined, everything may have changed.
"""

import subprocess
import sys
from importlib import import_module
from pathlib import PurePosixPath

MAIN = ("origin/main", "origin/master", "main", "master")
JUDGES = (
    "core",
    "errors.py",
    "execution",
    "faults",
    "kills",
    "mechanics",
    "planning",
    "scene",
    "truth",
)
"""Parts of refdem that every fault goes through: settings, engine, truth, judgement."""


def base() -> str:
    """The commit at which this branch left the main one; empty on the main branch itself, which may
    hold many commits at once.
    """
    head = answer("rev-parse", "HEAD")
    for branch in MAIN:
        left = answer("merge-base", branch, "HEAD")
        if left and left != head:
            return left
    return ""


def answer(*question: str) -> str:
    """What git says, or nothing where it fails."""
    done = subprocess.run(["git", *question], capture_output=True, text=True)
    if done.returncode == 0:
        return done.stdout.strip()
    return ""


def touched(changed: list[str]) -> set[str] | None:
    """Names of faults, or None for all of them."""
    from refdem.faults.catalogue import faults
    from refdem.faults.settings import SETTINGS

    names: set[str] = set()
    for file in changed:
        parts = PurePosixPath(file).parts
        if parts[0] != "refdem" or len(parts) < 2:
            continue
        folder = parts[1]
        stem = PurePosixPath(file).stem
        if parts[1:3] == ("faults", "catalogue") and stem != "__init__":
            names |= {
                fault.name for fault in import_module(f"refdem.faults.catalogue.{stem}").FAULTS
            }
        elif folder == "checks" and not stem.startswith("_"):
            # A check is named with hyphens, its file with underscores.
            names |= {fault.name for fault in faults() if fault.sees[0].replace("-", "_") == stem}
        elif folder == "cases":
            settings = {
                name
                for name, setting in SETTINGS.items()
                if setting.case.replace("-", "_") in parts or in_file(setting.case, stem)
            }
            names |= {fault.name for fault in faults() if settings & set(fault.on)}
        elif folder in JUDGES or folder == "checks":
            return None
    return names


def in_file(case: str, stem: str) -> bool:
    """True if the case lives in a file of that name; what begins with _ is shared."""
    return case.replace("-", "_") == stem or stem.startswith("_")


def main() -> None:
    """Prints the answer on one line."""
    if len(sys.argv) > 1:
        since = sys.argv[1]
    else:
        since = base()
    if not since:
        print("all")
        return
    changed = answer("diff", "--name-only", since, "HEAD").split("\n")
    found = touched([file for file in changed if file])
    print("all" if found is None else ",".join(sorted(found)))


if __name__ == "__main__":
    main()
