"""refdem.toml: what a program says of itself, its claims and its gate."""

import tomllib
from pathlib import Path
from typing import Literal

import msgspec

from refdem.core.deviation import Deviation
from refdem.core.engine import Method
from refdem.engines.external.sense import nonsense
from refdem.errors import UsageError

Law = Literal["energy", "momentum", "angular-momentum", "constraint"]


class MethodTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One method of the program and its claims."""

    name: str
    summary: str = ""
    answers: Literal["motion", "solid"] = "motion"
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
        """The method as the checks know it; a staggered one cannot go on from its end state, and mass properties have no step."""
        fields = msgspec.structs.asdict(self)
        fields["conserves"] = frozenset(self.conserves)
        fields["complete_state"] = self.complete_state and engine.velocity_time == "synchronous"
        if self.answers == "solid":
            fields |= {"control": "exact", "knows": frozenset(name for name in engine.supports if name.startswith("solid:"))}
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
    for name, came, expected in nonsense(found.engine, found.gate):
        raise UsageError(f"{path}: {name} is {came!r}; expected {expected}")
    return found
