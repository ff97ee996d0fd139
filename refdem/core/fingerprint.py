"""Digests of all that can change a result: installed packages, files, and the machine."""

import hashlib
import platform
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path


def of_files(paths: Iterable[Path]) -> str:
    """sha256 of the names and contents of files, in order of name."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


@cache
def of_package(name: str) -> str:
    """sha256 of an installed package's version and RECORD, which holds the digest of every file in it."""
    try:
        found = distribution(name)
    except PackageNotFoundError:
        return "missing"
    return hashlib.sha256(f"{found.version}\0{found.read_text('RECORD') or ''}".encode()).hexdigest()


@cache
def of_source(*folders: str) -> str:
    """sha256 of refdem's own Python files in these folders or files below refdem/."""
    root = Path(__file__).parents[1]
    files = [p for folder in folders for p in ([root / folder] if folder.endswith(".py") else (root / folder).rglob("*.py"))]
    return of_files(files)


@cache
def of_machine() -> str:
    """sha256 of what the processor can do: bits are only claimed equal on one kind of machine."""
    flags = ""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        flags = next((line for line in cpuinfo.read_text().splitlines() if line.startswith(("flags", "Features"))), "")
    return hashlib.sha256(f"{platform.machine()}\0{flags}".encode()).hexdigest()
