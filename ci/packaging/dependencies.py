"""Prints what refdem needs, one requirement a line: its build, its dependencies and the extras
named as arguments. `engines` stands for all that adapters ask for: the extras that are named for
one, and the `requirements.in` beside one; `every` stands for those and all extras.

With --locked, that and all that it depends on, as requirements.lock pins it: a version, and the
digests of all files of that release, so that `pip install --require-hashes` takes nothing else.
"""

import re
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
NAME = re.compile(r"[A-Za-z0-9._-]+")
VIA = re.compile(r"^    # via (.*)$", re.MULTILINE)
"""How uv says which packages, or which file of requirements, ask for one."""


@dataclass(frozen=True)
class Locked:
    """A package in the lock: its lines there, and the names of the packages that depend on it."""

    name: str
    text: str
    asked_by: frozenset[str]


def plain(requirement: str) -> str:
    """The name of a requirement as indexes write it."""
    found = NAME.match(requirement)
    if found is None:
        raise SystemExit(f"{requirement!r} is no requirement")
    return re.sub(r"[-_.]+", "-", found[0]).lower()


def of_engines(optional: dict[str, list[str]]) -> list[str]:
    """The requirements of all adapters: an extra has the name of one, or its folder a file."""
    adapters = ROOT / "refdem" / "engines"
    found = []
    for extra, requirements in optional.items():
        if (adapters / extra).is_dir() or (adapters / f"{extra}.py").is_file():
            found += requirements
    for path in sorted(adapters.glob("*/requirements.in")):
        found += path.read_text().split("\n")
    return [line for line in found if line and not line.startswith("#")]


def wanted(extras: list[str]) -> list[str]:
    """The requirements of the build, of refdem and of some extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    optional = project["project"]["optional-dependencies"]
    found = [*project["build-system"]["requires"], *project["project"]["dependencies"]]
    for extra in extras:
        if extra in ("engines", "every"):
            found += of_engines(optional)
        else:
            found += optional[extra]
        if extra == "every":
            found += [line for lines in optional.values() for line in lines]
    # An extra that stands for others names refdem itself; theirs are there by their own names.
    return [line for line in dict.fromkeys(found) if plain(line) != "refdem"]


def locked(text: str) -> list[Locked]:
    """All packages of a lock file. Each begins a line; its further lines are indented."""
    found = []
    for block in re.split(r"^(?=\w)", text, flags=re.MULTILINE):
        if "==" not in block:
            continue
        names = VIA.search(block)
        if names:
            asking = names[1].split(", ")
        else:
            asking = []
        asked_by = frozenset(plain(name) for name in asking if not name.startswith("-r "))
        found.append(Locked(plain(block), VIA.sub("", block).rstrip(), asked_by))
    return found


def closure(requirements: list[str], packages: list[Locked]) -> list[Locked]:
    """The packages that requirements name, and all that these depend on."""
    known = {package.name for package in packages}
    names = {plain(requirement) for requirement in requirements}
    if not names <= known:
        missing = ", ".join(sorted(names - known))
        raise SystemExit(f"requirements.lock has no {missing}; run: make lock")
    while True:
        more = {package.name for package in packages if package.asked_by & names} - names
        if not more:
            return [package for package in packages if package.name in names]
        names |= more


if __name__ == "__main__":
    arguments = sys.argv[1:]
    requirements = wanted([name for name in arguments if name != "--locked"])
    if "--locked" in arguments:
        packages = locked((ROOT / "requirements.lock").read_text())
        print("\n".join(package.text for package in closure(requirements, packages)))
    else:
        print("\n".join(requirements))
