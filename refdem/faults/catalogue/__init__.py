"""The catalogue of known faults: a file a class, each with a tuple FAULTS."""

from functools import cache
from importlib import import_module
from pathlib import Path

from refdem.core.parameters import nearest
from refdem.errors import UsageError
from refdem.faults.fault import Fault


@cache
def faults() -> tuple[Fault, ...]:
    """All faults of the catalogue, class by class."""
    catalogue: list[Fault] = []
    for path in sorted(Path(__file__).parent.glob("[a-z]*.py")):
        catalogue += import_module(f"{__name__}.{path.stem}").FAULTS
    return tuple(catalogue)


def chosen(names: list[str]) -> tuple[Fault, ...]:
    """The faults of these names or kinds (none: all); raises UsageError with the nearest name."""
    known = {fault.name for fault in faults()} | {fault.kind for fault in faults()}
    for name in names:
        if name not in known:
            raise UsageError(f"no fault {name!r}; {nearest(name, known)}")
    return tuple(
        fault for fault in faults() if not names or fault.name in names or fault.kind in names
    )
