"""refdem.toml: what a program says of itself, its claims and its gate."""

import tomllib
from pathlib import Path
from typing import Literal

import msgspec

from refdem.core.deviation import Deviation
from refdem.core.engine import Method
from refdem.errors import UsageError


class MethodTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One method of the program and its claims."""

    name: str
    summary: str = ""
    control: Literal["step", "tolerance", "exact"] = "step"
    order: int = 0
    order_with: dict[str, int] = {}
    constant: float = 1.0
    constant_reason: str = ""
    conserves: list[str] = []
    reversible: bool = False
    symplectic: bool = False
    backward: bool = False
    complete_state: bool = True
    deterministic: bool = True

    def method(self, precision: Literal["double", "single"], *, staggered: bool) -> Method:
        """The method as the checks know it; a staggered one cannot go on from its end state."""
        fields = msgspec.structs.asdict(self)
        fields["conserves"] = frozenset(self.conserves)
        fields["complete_state"] = self.complete_state and not staggered
        return Method(**fields, precision=precision)


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
    faults = [
        ("engine.command", engine.command, bool(engine.command), "the program and its arguments"),
        ("engine.methods", [m.name for m in engine.methods], bool(engine.methods), "at least one [[engine.methods]]"),
        ("engine.timeout", engine.timeout, engine.timeout > 0, "seconds > 0"),
        ("engine.budget", engine.budget, engine.budget > 0, "seconds > 0"),
    ]
    faults += [("order", m.order, m.control != "step" or m.order >= 1, f"the order that {m.name} claims, >= 1") for m in engine.methods]
    names = [m.name for m in engine.methods]
    faults.append(("engine.methods", names, len(set(names)) == len(names), "each name once"))
    for name, came, holds, expected in faults:
        if not holds:
            raise UsageError(f"{path}: {name} is {came!r}; expected {expected}")
