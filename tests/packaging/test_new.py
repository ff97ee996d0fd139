"""One case, check, element, engine and kernel are added to a copy of the tree by `refdem new` and
taken away again: nothing else is edited, and all tests that look at every one of a kind hold for
the new one.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from refdem import kernels

ROOT = Path(__file__).parents[2]
COMMAND = "from refdem.cli import main; main()"
NAMES = {
    "case": "new-throw",
    "check": "new-line",
    "element": "new-pull",
    "engine": "new-hop",
    "kernel": "new-fall",
}
WRITTEN = {
    "refdem/cases/new_throw.py",
    "refdem/truth/witnesses/new_throw.py",
    "tests/cases/test_new_throw.py",
    "validation/margins/new-throw.toml",
    "refdem/checks/new_line.py",
    "refdem/faults/catalogue/new_line.py",
    "tests/checks/test_new_line.py",
    "refdem/scene/elements/new_pull.py",
    "tests/scene/elements/test_new_pull.py",
    "refdem/engines/new_hop.py",
    "tests/engines/test_new_hop.py",
    "refdem/kernels/new_fall.c",
    "refdem/kernels/new_fall_kernel.h",
    "refdem/solvers/new_fall.py",
    "tests/solvers/test_new_fall.py",
}
PROVED = {
    "validation/truth/certified/new-throw.jsonl",
    "validation/truth/certified/sha256sums.txt",
}
"""What `refdem certify` writes: the values of the case, and the sums of all files beside them."""
ABOUT_NONE = (
    *("attacks", "bench", "browser", "ci", "cli", "codes", "commands", "corpus", "documents"),
    *("faults_full", "foreign", "gallery", "gate", "layout", "matrix", "packaging", "report"),
    *("manual", "stress"),
)
"""Folders without tests of every case, check, engine or kernel; the pages of the manual are made by
a command of their own."""
CHOSEN = (
    "new_throw or new_line or new_pull or new_hop or new_fall"
    " or new-throw or new-line or new-pull or new-hop or new-fall or every_check_has"
    " or these_cases or every_case_has or every_case_with or every_method_answers or every_c_file"
    " or has_a_witness or full_has_everything"
)
"""The tests of the new ones, and those that hold lists against what is there."""


class Tree:
    """A copy of the tree, with the kernels that are built, in a repository of its own."""

    def __init__(self, place: Path) -> None:
        self.place = place
        listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        done = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True)
        for name in filter(None, done.stdout.split("\0")):
            if (ROOT / name).is_file():
                target = place / name
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, target)
        for built in kernels.folder().glob("_*.so"):
            shutil.copy(built, place / "refdem" / "kernels")
        # What mypy knows of the files that are the same, if `make lint` has asked it.
        if (ROOT / ".mypy_cache").is_dir():
            shutil.copytree(ROOT / ".mypy_cache", place / "build" / "mypy")
        self.said("git", "init", "--quiet")
        self.said("git", "add", "--all")
        self.said("git", *self.author, "commit", "--quiet", "--message", "as it was")

    author = ("-c", "user.name=test", "-c", "user.email=test@localhost")

    def said(self, *command: str) -> str:
        """What a command prints in the copy; it must end well."""
        binaries = str(Path(sys.executable).parent)
        environment = os.environ | {
            "PATH": os.pathsep.join([binaries, os.environ.get("PATH", "")]),
            "PYTHONPATH": str(self.place),
            "PYTHONDONTWRITEBYTECODE": "1",
            "REFDEM_STORE": str(self.place / "build" / "store.sqlite"),
        }
        done = subprocess.run(
            command, cwd=self.place, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{command}: {done.stdout[-8000:]}{done.stderr[-4000:]}"
        return done.stdout

    def refdem(self, *arguments: str) -> str:
        """What refdem, as it is in the copy, prints."""
        return self.said(sys.executable, "-P", "-c", COMMAND, *arguments)

    def changed(self) -> set[str]:
        """Files that are new, gone or another than they were."""
        lines = self.said("git", "status", "--porcelain", "--untracked-files=all").splitlines()
        return {line[3:] for line in lines}

    def built(self, family: str) -> None:
        """Builds one kernel beside its source, as ci/develop/build-in-place does with all."""
        self.said("meson", "setup", "build/dev")
        made = f"_{family}{sysconfig.get_config_var('EXT_SUFFIX')}"
        self.said("ninja", "-C", "build/dev", made)
        shutil.copy(self.place / "build" / "dev" / made, self.place / "refdem" / "kernels")

    def taken_away(self, names: Sequence[str]) -> None:
        """Removes files, and the kernels that were built from them."""
        for name in names:
            (self.place / name).unlink()
        for left in (self.place / "refdem" / "kernels").glob("_new_*.so"):
            left.unlink()


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tree]:
    place = tmp_path_factory.mktemp("tree")
    yield Tree(place)
    shutil.rmtree(place)


def test_what_is_new_is_found_by_all_tests_and_nothing_else_is_edited(tree: Tree) -> None:
    before = {kind: tree.refdem("list", f"{kind}s") for kind in ("case", "check", "engine")}
    for kind, name in NAMES.items():
        assert f"test_{name.replace('-', '_')}.py" in tree.refdem("new", kind, name)
    assert tree.changed() == WRITTEN
    sources = sorted(name for name in WRITTEN if name.endswith(".py"))
    tree.said("ruff", "check", *sources)
    tree.said("ruff", "format", "--check", *sources)
    in_c = sorted(name for name in WRITTEN if name.endswith((".c", ".h")))
    tree.said("clang-format", "--dry-run", "--Werror", *in_c)
    own = [name for name in sources if name.startswith("refdem/")]
    tree.said("mypy", "--strict", "--cache-dir", "build/mypy", *own)
    tree.built("new_fall")
    tree.refdem("certify", NAMES["case"], "--folder", "validation/truth")
    # No failure is to be explained: to rewrite the assertions of all tests took half of the time.
    plain = ("--assert=plain", "-p", "no:cacheprovider")
    pytest_ = (sys.executable, "-P", "-m", "pytest", "-q", *plain)
    folders = [
        str(path.relative_to(tree.place))
        for path in sorted((tree.place / "tests").iterdir())
        if path.is_dir() and path.name not in ABOUT_NONE
    ]
    said = tree.said(*pytest_, "--tb=short", *folders, "-k", CHOSEN)
    assert int(said.rpartition(" passed")[0].rpartition("\n")[2]) > 45, said
    assert tree.changed() == WRITTEN | PROVED

    tree.taken_away(sorted(WRITTEN))
    tree.said("git", "checkout", "--quiet", "--", "validation")
    tree.taken_away(["validation/truth/certified/new-throw.jsonl"])
    assert tree.changed() == set()
    for kind, said_before in before.items():
        assert tree.refdem("list", f"{kind}s") == said_before
