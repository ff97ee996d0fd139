"""What the fields of a refdem.toml may say beyond their types."""

import difflib
import re
from collections.abc import Iterator
from pathlib import PurePath
from typing import TYPE_CHECKING, get_args, get_type_hints

from refdem.core.statics import SolidShape
from refdem.scene.elements import KINDS
from refdem.scene.elements.contact import Contact

if TYPE_CHECKING:
    from refdem.engines.external.description import EngineTable, GateTable, MethodTable

SOLIDS = {"solid:hollow", "solid:turned", "solid:about"} | {
    f"solid:{shape.__struct_config__.tag}" for shape in get_args(SolidShape)
}
"""Of mass properties: shapes, and what is done with them."""
BODIES = (
    "rotation",
    "tumbling",
    "fixed",
    "friction",
    "constraint",
    "shape:sphere",
    "shape:polyhedron",
)
DIMENSIONS = {"dimension:1", "dimension:2", "dimension:3"}
"""Of motion; a program that names none of them runs in all."""
FEATURES = {
    *BODIES,
    *DIMENSIONS,
    *KINDS,
    *SOLIDS,
    *(
        "slider:stribeck",
        "slider:belt",
        "spring:exponent",
        "spring:quadratic",
        "spring:cubic",
        "dashpot:van_der_pol",
    ),
    "contact:damping",
    "contact:friction",
    "contact:mindlin",
    "bodies_file",
    *(f"contact:{law}" for law in get_args(get_type_hints(Contact)["law"])),
}
"""What `supports` and `order_with` may name."""
YEAR = 366 * 86400.0
"""Seconds."""
PLACEHOLDERS = ("request", "request_txt", "trajectory", "events")
"""Names in braces that stand for files in a command."""
PLACEHOLDER = re.compile(r"\{(\w+)\}")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,63}")


def nonsense(engine: "EngineTable", gate: "GateTable") -> Iterator[tuple[str, object, str]]:
    """What is well typed and makes no sense: its name, what came, what was expected."""
    names = [m.name for m in engine.methods]
    strange = sorted(
        {*engine.supports, *(feature for m in engine.methods for feature in m.order_with)}
        - FEATURES
    )
    mute = [
        m.name for m in engine.methods if m.answers == "solid" and not SOLIDS & set(engine.supports)
    ]
    away = [pattern for pattern in engine.inputs if not is_pattern_below(pattern)]
    slips = [word for word in engine.command for name in PLACEHOLDER.findall(word) if is_slip(name)]
    twice = sorted({label for label in gate.cases if gate.cases.count(label) > 1})
    faults: list[tuple[str, object, bool, str]] = [
        (
            "engine.name",
            engine.name,
            bool(NAME.fullmatch(engine.name)),
            "letters, digits, dots, dashes",
        ),
        (
            "engine.command",
            engine.command,
            all(engine.command[:1]) and bool(engine.command),
            "the program and its arguments",
        ),
        (
            "engine.command",
            engine.command,
            not any("\0" in word for word in engine.command),
            "words without NUL",
        ),
        (
            "engine.methods",
            names,
            bool(names) and len(set(names)) == len(names),
            "at least one [[engine.methods]], each name once",
        ),
        (
            "engine.methods",
            names,
            all(NAME.fullmatch(name) for name in names),
            "names of letters, digits, dots, dashes",
        ),
        (
            "engine.supports or order_with",
            strange,
            not strange,
            f"features of {', '.join(sorted(FEATURES))}",
        ),
        (
            "engine.supports",
            engine.supports,
            not mute,
            f"some of {', '.join(sorted(SOLIDS))} for method {', '.join(mute)}",
        ),
        (
            "gate.levels",
            gate.levels,
            1 <= gate.levels <= 10,
            "a number of refinement levels, 1 to 10",
        ),
        (
            "engine.inputs",
            away,
            not away,
            "patterns below the folder of refdem.toml, with ** only between slashes",
        ),
        ("engine.command", slips, not slips, f"{{name}} of a file: {', '.join(PLACEHOLDERS)}"),
        ("gate.cases", twice, not twice, "each case once; these are there twice"),
    ]
    limits = {"timeout": engine.timeout, "budget": engine.budget}
    faults += [
        (f"engine.{name}", limit, 0 < limit <= YEAR, "seconds > 0, at most a year")
        for name, limit in limits.items()
    ]
    if engine.memory is not None:
        faults.append(
            (
                "engine.memory",
                engine.memory,
                0.001 <= engine.memory <= 1e6,
                "gigabytes, at least 0.001",
            )
        )
    for m in engine.methods:
        faults += _claims(m)
    yield from ((name, came, expected) for name, came, holds, expected in faults if not holds)


def is_pattern_below(pattern: str) -> bool:
    """Whether `inputs` may have it: a pattern of pathlib's, below the folder."""
    if not pattern.strip() or "\0" in pattern:
        return False
    path = PurePath(pattern)
    return not path.is_absolute() and all("**" not in part or part == "**" for part in path.parts)


def is_slip(name: str) -> bool:
    """Whether a word in braces is not known and looks like one that is; other words in braces are
    the program's own.
    """
    return name not in PLACEHOLDERS and bool(difflib.get_close_matches(name, PLACEHOLDERS, 1, 0.5))


def _claims(m: "MethodTable") -> list[tuple[str, object, bool, str]]:
    """Rules for the claims of one method: name, what came, whether it holds, what was expected."""
    orders = [m.order, *m.order_with.values()]
    reasoned = m.constant == 1 or bool(m.constant_reason.strip())
    return [
        (
            f"order of {m.name}",
            orders,
            m.control != "step"
            or m.answers == "solid"
            or all(1 <= order <= 20 for order in orders),
            "the order that it claims, 1 to 20",
        ),
        (f"constant of {m.name}", m.constant, 0 < m.constant < float("inf"), "a number > 0"),
        (
            f"constant of {m.name}",
            m.constant,
            reasoned,
            "a constant_reason beside a constant that is not 1",
        ),
    ]
