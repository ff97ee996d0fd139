"""refdem.toml: what a program says of itself, its claims and its gate."""

import re
import tomllib
from pathlib import Path, PurePath
from typing import Literal, get_args, get_type_hints

import msgspec

from refdem.core.deviation import Deviation
from refdem.core.engine import Method
from refdem.errors import UsageError
from refdem.scene.elements import KINDS
from refdem.scene.elements.contact import Contact

Law = Literal["energy", "momentum", "angular-momentum", "constraint"]
BODIES = ("rotation", "tumbling", "fixed", "friction", "constraint", "shape:sphere", "shape:polyhedron")
DIMENSIONS = {"dimension:1", "dimension:2", "dimension:3"}
"""Of motion; a program that names none of them runs in all."""
FEATURES = {
    *BODIES,
    *DIMENSIONS,
    *KINDS,
    "contact:damping",
    "contact:friction",
    *(f"contact:{law}" for law in get_args(get_type_hints(Contact)["law"])),
}
"""What `supports` and `order_with` may name."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,63}")


class MethodTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One method of the program and its claims."""

    name: str
    summary: str = ""
    control: Literal["step", "tolerance", "exact"] = "step"
    order: int = 0
    order_with: dict[str, int] = {}
    constant: float = 1.0
    constant_reason: str = ""
    conserves: list[Law] = []
    reversible: bool = False
    symplectic: bool = False
    backward: bool = False
    complete_state: bool = True
    deterministic: bool = True

    def method(self, engine: "EngineTable") -> Method:
        """The method as the checks know it; a staggered one cannot go on from its end state."""
        fields = msgspec.structs.asdict(self)
        fields["conserves"] = frozenset(self.conserves)
        fields["complete_state"] = self.complete_state and engine.velocity_time == "synchronous"
        return Method(**fields, precision=engine.precision, velocity_time=engine.velocity_time)


class EngineTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The program: its command (never a shell), what belongs to it, what it can do."""

    name: str
    command: list[str]
    methods: list[MethodTable]
    inputs: list[str] = []
    version_command: list[str] = []
    supports: list[str] = []
    precision: Literal["double", "single"] = "double"
    velocity_time: Literal["synchronous", "minus-half-step"] = "synchronous"
    timeout: float = 60.0
    budget: float = 600.0


class GateTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What its gate runs: cases (none: all that the program supports), levels, baseline."""

    cases: list[str] = []
    levels: int = 4
    baseline: str = "refdem-baseline.jsonl"


class Description(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The whole file."""

    engine: EngineTable
    gate: GateTable = GateTable()
    expected: list[Deviation] = []


def read(path: Path) -> Description:
    """The description in a refdem.toml; raises UsageError that names the fault."""
    try:
        text = path.read_text(encoding="utf-8")
        found = msgspec.convert(tomllib.loads(text), Description)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}; expected a refdem.toml that describes a program") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, msgspec.ValidationError) as error:
        raise UsageError(f"{path}: {error}") from None
    _refuse(found.engine, path)
    return found


def _refuse(engine: EngineTable, path: Path) -> None:
    """Raises UsageError for what is well typed and makes no sense."""
    names = [m.name for m in engine.methods]
    strange = sorted({*engine.supports, *(feature for m in engine.methods for feature in m.order_with)} - FEATURES)
    away = [pattern for pattern in engine.inputs if not pattern or PurePath(pattern).is_absolute()]
    faults: list[tuple[str, object, bool, str]] = [
        ("engine.name", engine.name, bool(NAME.fullmatch(engine.name)), "letters, digits, dots, dashes"),
        ("engine.command", engine.command, all(engine.command[:1]) and bool(engine.command), "the program and its arguments"),
        ("engine.command", engine.command, not any("\0" in word for word in engine.command), "words without NUL"),
        ("engine.methods", names, bool(names) and len(set(names)) == len(names), "at least one [[engine.methods]], each name once"),
        ("engine.methods", names, all(NAME.fullmatch(name) for name in names), "names of letters, digits, dots, dashes"),
        ("engine.supports or order_with", strange, not strange, f"features of {', '.join(sorted(FEATURES))}"),
        ("engine.inputs", away, not away, "patterns below the folder of refdem.toml"),
    ]
    limits = {"timeout": engine.timeout, "budget": engine.budget}
    faults += [(f"engine.{name}", limit, 0 < limit < float("inf"), "seconds > 0") for name, limit in limits.items()]
    for m in engine.methods:
        orders = [m.order, *m.order_with.values()]
        holds = m.control != "step" or all(1 <= order <= 20 for order in orders)
        faults.append((f"order of {m.name}", orders, holds, "the order that it claims, 1 to 20"))
        faults.append((f"constant of {m.name}", m.constant, 0 < m.constant < float("inf"), "a number > 0"))
        reasoned = m.constant == 1 or bool(m.constant_reason.strip())
        faults.append((f"constant of {m.name}", m.constant, reasoned, "a constant_reason beside a constant that is not 1"))
    for name, came, holds, expected in faults:
        if not holds:
            raise UsageError(f"{path}: {name} is {came!r}; expected {expected}")
