"""Reading a refdem.toml, and validation of its fields beyond their types."""

import difflib
import math
import re
from collections.abc import Iterator
from pathlib import Path, PurePath

from refdem.core.parameters import nearest
from refdem.core.reading import toml_as
from refdem.engines.external.description import Description, EngineTable, GateTable, MethodTable
from refdem.engines.external.features import FEATURES, SOLIDS
from refdem.errors import UsageError

YEAR = 366 * 86400.0
"""Seconds."""
LEAST_MEMORY = 0.001
"""Smallest memory limit [GB]: a program cannot start in less than a megabyte."""
MOST_MEMORY = 1e6
"""Largest memory limit [GB]."""
MOST_LEVELS = 10
"""Most refinement levels of a gate: ten halvings make the finest run 1000 times as long as the
first.
"""
PLACEHOLDERS = (
    "request",
    "request_txt",
    "trajectory",
    "trajectory_npy",
    "events",
    "sensitivities",
)
"""Names in braces that stand for files in a command."""
PLACEHOLDER = re.compile(r"\{(\w+)\}")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,63}")


Fault = tuple[str, object, str]
"""The name of a field, its value, and what was expected."""


def read(path: Path) -> Description:
    """The description in a refdem.toml; raises UsageError that names the fault."""
    description = toml_as(Description, path, "a refdem.toml that describes a program")
    for name, value, expected in nonsense(description.engine, description.gate):
        raise UsageError(f"{path}: {name} is {value!r}; expected {expected}")
    return description


def nonsense(engine: EngineTable, gate: GateTable) -> Iterator[Fault]:
    """Fields of the right type whose values are invalid."""
    yield from _of_command(engine)
    yield from _of_methods(engine)
    yield from _of_support(engine)
    yield from _of_limits(engine)
    yield from _of_gate(gate)


def _of_command(engine: EngineTable) -> Iterator[Fault]:
    """Faults in the name of the engine, its commands, and the files that belong to it."""
    if not NAME.fullmatch(engine.name):
        yield "engine.name", engine.name, "letters, digits, dots, dashes"
    if not engine.command or not engine.command[0]:
        yield "engine.command", engine.command, "the program and its arguments"
    if any("\0" in word for word in engine.command):
        yield "engine.command", engine.command, "words without NUL"
    slips = [word for word in engine.command if any(map(is_slip, PLACEHOLDER.findall(word)))]
    if slips:
        yield "engine.command", slips, f"{{name}} of a file: {', '.join(PLACEHOLDERS)}"
    named = [word for word in engine.command if set(PLACEHOLDER.findall(word)) & {*PLACEHOLDERS}]
    if engine.serve and named:
        expected = "no {name} of a file with serve = true: each request has its own, in its line"
        yield "engine.command", named, expected
    outside = [pattern for pattern in engine.inputs if not is_pattern_below(pattern)]
    if outside:
        expected = "patterns below the folder of refdem.toml, with ** only between slashes"
        yield "engine.inputs", outside, expected


def _of_methods(engine: EngineTable) -> Iterator[Fault]:
    """Faults in the names of the methods and in their claims."""
    names = [method.name for method in engine.methods]
    if not names or len(set(names)) < len(names):
        yield "engine.methods", names, "at least one [[engine.methods]], each name once"
    if not all(map(NAME.fullmatch, names)):
        yield "engine.methods", names, "names of letters, digits, dots, dashes"
    for method in engine.methods:
        yield from _of_claims(method)


def _of_claims(method: MethodTable) -> Iterator[Fault]:
    """Faults in the order of one method and in its error constant."""
    orders = [method.order, *method.order_with.values()]
    has_order = method.control == "step" and method.answers != "solid"
    if has_order and not all(1 <= order <= 20 for order in orders):
        yield f"order of {method.name}", orders, "the order that it claims, 1 to 20"
    if not 0 < method.constant < math.inf:
        yield f"constant of {method.name}", method.constant, "a number > 0"
    if method.constant != 1 and not method.constant_reason.strip():
        expected = "a constant_reason beside a constant that is not 1"
        yield f"constant of {method.name}", method.constant, expected


def _of_support(engine: EngineTable) -> Iterator[Fault]:
    """Faults in the features that the program supports."""
    named = set(engine.supports)
    for method in engine.methods:
        named.update(method.order_with)
    strange = sorted(named - FEATURES)
    if strange:
        expected = f"words that `refdem explain --features` lists; {nearest(strange[0], FEATURES)}"
        yield "engine.supports or order_with", strange, expected
    has_solids = bool(SOLIDS & set(engine.supports))
    mute = [method.name for method in engine.methods if method.answers == "solid"]
    if mute and not has_solids:
        expected = f"some of {', '.join(sorted(SOLIDS))} for method {', '.join(mute)}"
        yield "engine.supports", engine.supports, expected


def _of_limits(engine: EngineTable) -> Iterator[Fault]:
    """Faults in the limits on time [s] and memory [GB]."""
    for name in ("timeout", "start_timeout", "budget"):
        limit = getattr(engine, name)
        if not 0 < limit <= YEAR:
            yield f"engine.{name}", limit, "seconds > 0, at most a year"
    if not 0 <= engine.warm_up <= YEAR:
        yield "engine.warm_up", engine.warm_up, "seconds >= 0, at most a year"
    if not engine.serve and engine.warm_up > 0:
        expected = "0 without serve = true: only a program that stays alive says that it is warm"
        yield "engine.warm_up", engine.warm_up, expected
    if engine.memory is not None and not LEAST_MEMORY <= engine.memory <= MOST_MEMORY:
        yield "engine.memory", engine.memory, f"gigabytes, at least {LEAST_MEMORY:g}"


def _of_gate(gate: GateTable) -> Iterator[Fault]:
    """Faults in the levels, cases and baseline of the gate."""
    if not gate.baseline.strip() or not gate.baseline.isprintable():
        yield "gate.baseline", gate.baseline, "the path of a file"
    if not 1 <= gate.levels <= MOST_LEVELS:
        expected = f"a number of refinement levels, 1 to {MOST_LEVELS}"
        yield "gate.levels", gate.levels, expected
    twice = sorted({label for label in gate.cases if gate.cases.count(label) > 1})
    if twice:
        yield "gate.cases", twice, "each case once; these are listed twice"


def is_pattern_below(pattern: str) -> bool:
    """Whether `inputs` may have it: a pattern of pathlib's, below the folder."""
    if not pattern.strip() or "\0" in pattern:
        return False
    path = PurePath(pattern)
    return not path.is_absolute() and all("**" not in part or part == "**" for part in path.parts)


def is_slip(name: str) -> bool:
    """Whether a word in braces is probably a misspelt placeholder; other unknown words in braces
    are passed to the program as they are.
    """
    return name not in PLACEHOLDERS and bool(difflib.get_close_matches(name, PLACEHOLDERS, 1, 0.5))
