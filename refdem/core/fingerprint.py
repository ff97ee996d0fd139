"""Digests of all that can change a result: installed packages, files, and the machine."""

import hashlib
import os
import platform
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path


def of_files(paths: Iterable[Path]) -> str:
    """sha256 of the names and contents of files, in order of name."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(os.fsencode(path.name) + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


@cache
def version_of(name: str) -> str:
    """The version of an installed package. Its metadata are parsed once in a process: an engine
    asks for each of its methods.
    """
    return version(name)


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
    for parts in sorted(_files_below(root)):
        # Plain text instead of Path objects: refdem has more than a thousand files.
        path = os.path.join(*parts)
        content = _content(os.path.join(root, path))
        digest.update(f"{path}\0".encode() + hashlib.sha256(content).digest())
    return digest.hexdigest()


def _files_below(root: Path) -> Iterator[tuple[str, ...]]:
    """The parts of the relative path of every file that `of_tree` reads."""
    for folder, _, names in os.walk(root):
        above = Path(folder).relative_to(root).parts
        for name in names:
            is_left_out = name.startswith(".") or name.endswith(".pyc")
            if not is_left_out and os.path.isfile(os.path.join(folder, name)):
                yield *above, name


def _content(path: str) -> bytes:
    """The bytes of the file at this path."""
    with open(path, "rb") as file:
        return file.read()


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
