"""Digests of all that can change a result: installed packages, files, and the machine."""

import hashlib
import os
import platform
import sys
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path


def of_files(paths: Iterable[Path]) -> str:
    """sha256 of the names and contents of files, in order of name."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(os.fsencode(path.name) + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


@cache
def of_package(name: str) -> str:
    """sha256 of an installed package's version and RECORD, which holds the digest of every file in
    it.
    """
    try:
        package = distribution(name)
    except PackageNotFoundError:
        return "missing"
    return hashlib.sha256(
        f"{package.version}\0{package.read_text('RECORD') or ''}".encode()
    ).hexdigest()


@cache
def of_source(*folders: str) -> str:
    """sha256 of refdem's own Python files in these folders or files below refdem/."""
    root = Path(__file__).parents[1]
    files: list[Path] = []
    for folder in folders:
        if folder.endswith(".py"):
            files.append(root / folder)
        else:
            files += (root / folder).rglob("*.py")
    return of_files(files)


def of_module(name: str) -> str:
    """sha256 of the files of the package that an imported module belongs to, or of its own file
    where it is alone.

    For a module without a file (typed at a prompt) it is the digest of the name alone.
    """
    digest = hashlib.sha256(name.encode())
    outermost = sys.modules[name.partition(".")[0]]
    folders = [Path(folder) for folder in getattr(outermost, "__path__", [])]
    for folder in sorted(folders):
        digest.update(of_tree(folder).encode())
    file = getattr(outermost, "__file__", None)
    if file and not folders:
        digest.update(of_files([Path(file)]).encode())
    return digest.hexdigest()


def of_tree(root: Path) -> str:
    """sha256 of the relative paths and contents of all files below a folder.

    Hidden files and Python's caches are left out.
    """
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if path.is_file() and not path.name.startswith(".") and path.suffix != ".pyc":
            digest.update(
                f"{path.relative_to(root)}\0".encode() + hashlib.sha256(path.read_bytes()).digest()
            )
    return digest.hexdigest()


@cache
def of_refdem() -> str:
    """sha256 of refdem as it is installed: code, kernels, templates."""
    return of_tree(Path(__file__).parents[1])


@cache
def of_machine() -> str:
    """sha256 of the processor's architecture and features: equal bits are claimed only for machines
    on which these agree.
    """
    flags = ""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = cpuinfo.read_text().splitlines()
        # The line is called "flags" on x86 and "Features" on ARM; every core has the same one.
        feature_lines = (line for line in lines if line.startswith(("flags", "Features")))
        flags = next(feature_lines, "")
    return hashlib.sha256(f"{platform.machine()}\0{flags}".encode()).hexdigest()
