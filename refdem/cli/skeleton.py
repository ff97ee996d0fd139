"""New files of refdem from templates: a case, a check, an element, an engine, or a kernel with its
solver."""

import keyword
import re
import textwrap
from dataclasses import dataclass
from pathlib import Path
from string import Template

from refdem.errors import UsageError

TEMPLATES = Path(__file__).parent / "templates" / "new"
LONGEST = 24
"""Most characters of a name, so that lines of the templates stay within 100 columns."""
COLUMNS = 100
"""Columns of a line of code, as pyproject.toml sets them for ruff."""
MARKS = ("pyproject.toml", "meson.build", "refdem/cases", "refdem/kernels", "tests")
"""Files that identify the root of refdem's own source tree."""
ARGUMENTS = (
    "(int64_t bodies, const double *gravity, const double *position, const double *velocity,"
    " double t0, int64_t samples, const double *t, double *out_position, double *out_velocity)"
)
"""The signature of the function of a new kernel; its line breaks depend on the length of the name.
"""


@dataclass(frozen=True)
class Skeleton:
    """One kind of thing that can be added.

    `files` gives the place of every template, in which {name} and {module} stand for the name;
    `homes` are the folders in which no file or folder may have the name already; `then` are the
    commands that come next.
    """

    files: dict[str, str]
    homes: tuple[str, ...]
    then: tuple[str, ...]


SKELETONS = {
    "case": Skeleton(
        files={
            "case.py.in": "refdem/cases/{module}.py",
            "case_witness.py.in": "refdem/truth/witnesses/{module}.py",
            "case_margins.toml.in": "validation/margins/{name}.toml",
            "case_test.py.in": "tests/cases/test_{module}.py",
        },
        homes=("refdem/cases",),
        then=(
            "pytest tests/cases/test_{module}.py",
            "refdem certify {name} --folder validation/truth",
            "refdem manual reports",
        ),
    ),
    "check": Skeleton(
        files={
            "check.py.in": "refdem/checks/{module}.py",
            "check_fault.py.in": "refdem/faults/catalogue/{module}.py",
            "check_test.py.in": "tests/checks/test_{module}.py",
        },
        homes=("refdem/checks",),
        then=("pytest tests/checks/test_{module}.py", "refdem manual reports"),
    ),
    "element": Skeleton(
        files={
            "element.py.in": "refdem/scene/elements/{module}.py",
            "element_test.py.in": "tests/scene/elements/test_{module}.py",
        },
        homes=("refdem/scene/elements",),
        then=("pytest tests/scene/elements/test_{module}.py", "refdem new case NAME"),
    ),
    "engine": Skeleton(
        files={
            "engine.py.in": "refdem/engines/{module}.py",
            "engine_test.py.in": "tests/engines/test_{module}.py",
        },
        homes=("refdem/engines",),
        then=("pytest tests/engines/test_{module}.py", "refdem smoke {name}"),
    ),
    "kernel": Skeleton(
        files={
            "kernel.c.in": "refdem/kernels/{module}.c",
            "kernel_header.h.in": "refdem/kernels/{module}_kernel.h",
            "solver.py.in": "refdem/solvers/{module}.py",
            "solver_test.py.in": "tests/solvers/test_{module}.py",
        },
        homes=("refdem/solvers", "refdem/kernels"),
        then=("make develop", "pytest tests/solvers/test_{module}.py"),
    ),
}


def written(kind: str, name: str, root: Path) -> list[Path]:
    """Writes the files of a new thing into the tree at `root`, and gives their places.

    Raises UsageError, before anything is written, for an unknown kind, a name that is no identifier
    or is taken, and a folder that is no source tree of refdem. No file is ever overwritten.
    """
    skeleton = skeleton_of(kind)
    refuse_bad_name(name)
    refuse_other_tree(root)
    module = name.replace("-", "_")
    refuse_taken_name(kind, skeleton, name, root)
    texts = {
        root / place.format(name=name, module=module): text_of(template, name)
        for template, place in skeleton.files.items()
    }
    for path in texts:
        if path.exists():
            raise UsageError(f"{path} exists already; choose another name")
    for path, text in texts.items():
        path.parent.mkdir(exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    return list(texts)


def next_commands(kind: str, name: str) -> list[str]:
    """What to run after `written`."""
    module = name.replace("-", "_")
    return [command.format(name=name, module=module) for command in skeleton_of(kind).then]


def skeleton_of(kind: str) -> Skeleton:
    """The skeleton of a kind; raises UsageError for an unknown one."""
    if kind not in SKELETONS:
        raise UsageError(f"new got {kind!r}; expected one of {', '.join(SKELETONS)}")
    return SKELETONS[kind]


def refuse_bad_name(name: str) -> None:
    """Raises UsageError for what cannot be the name of a module and of a command's argument."""
    is_formed = re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name) is not None
    if not is_formed or not 2 <= len(name) <= LONGEST:
        raise UsageError(
            f"the name {name[:80]!r} cannot be used; expected 2 to {LONGEST} small letters and"
            " digits, beginning with a letter, words joined by hyphens: bouncing-ball"
        )
    if keyword.iskeyword(name) or name == "external":
        raise UsageError(f"the name {name!r} is reserved; choose another")


def refuse_other_tree(root: Path) -> None:
    """Raises UsageError for a folder that is not the root of a tree of refdem."""
    try:
        missing = [mark for mark in MARKS if not (root / mark).exists()]
    except OSError as error:
        raise UsageError(f"--package {str(root)[:80]!r}: {error.strerror}") from None
    if missing:
        raise UsageError(
            f"{root} is not a source tree of refdem: it has no {missing[0]}; run this command in"
            " the root of a checkout, or name the root with --package"
        )


def refuse_taken_name(kind: str, skeleton: Skeleton, name: str, root: Path) -> None:
    """Raises UsageError if a file, a folder or a method of the reference has the name."""
    module = name.replace("-", "_")
    for home in skeleton.homes:
        taken = [path for path in (root / home).glob(f"{module}*") if path.stem == module]
        if taken:
            raise UsageError(f"there is a {kind} {name!r} already: {taken[0]}; choose another name")
    if kind == "kernel":
        # A method may be in a file of another name.
        for path in sorted((root / "refdem/solvers").glob("*.py")):
            if f'name="{name}"' in path.read_text(encoding="utf-8"):
                raise UsageError(f"{path} has a method {name!r} already; choose another name")


def text_of(template: str, name: str) -> str:
    """A template with the name in every form in which it is needed."""
    module = name.replace("-", "_")
    words = name.split("-")
    name_class = "".join(word.capitalize() for word in words)
    title = " ".join(words).capitalize()
    source = Template((TEMPLATES / template).read_text(encoding="utf-8"))
    return source.substitute(
        name=name,
        module=module,
        upper=module.upper(),
        name_class=name_class,
        title=title,
        declaration=signature(module, ";"),
        definition=signature(module, ""),
    )


def signature(module: str, end: str) -> str:
    """The function of a new kernel in lines as clang-format breaks them."""
    begin = f"int refdem_{module}"
    indent = " " * (len(begin) + 1)
    text = f"{begin}{ARGUMENTS}{end}"
    # No line may begin with the star of a pointer's name, nor end between a type and its name.
    joined = re.sub(
        r"(const )?(double|int64_t) (?=[*a-z])", lambda m: m[0].replace(" ", "\0"), text
    )
    lines = textwrap.wrap(
        joined, COLUMNS, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return "\n".join(lines).replace("\0", " ")
