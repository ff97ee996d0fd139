"""Faults that can act on a run: those that change its request or its trajectory, or a part that it
calls.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.faults.correct_parts import CORRECT
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts

CONSTANTS = {"suzuki": ("suzuki", "verlet_kicks"), "rk4": ("rk4_nodes", "rk4_weights")}
"""Constants of each method; other methods, whose names begin with verlet, use `verlet_kicks`."""
MEMORY = "fresh"
"""The part that clears the memory of other parts; it has no other effect."""


def recording_parts(called: set[str]) -> Parts:
    """The correct parts, each of which adds its name to `called` when it is called."""
    recording: Parts = _recording_parts(CORRECT, "", called)
    return recording


def _recording_parts(parts: Any, prefix: str, called: set[str]) -> Any:
    """A record of parts whose functions add their names to `called`."""
    changed: dict[str, Any] = {}
    for name, part in _items(parts):
        if isinstance(part, Mapping):
            changed[name] = {
                kind: _recording(force, f"{prefix}{name}.{kind.__name__}", called)
                for kind, force in part.items()
            }
        elif is_dataclass(part):
            changed[name] = _recording_parts(part, f"{prefix}{name}.", called)
        elif callable(part):
            changed[name] = _recording(part, prefix + name, called)
    return replace(parts, **changed)


def _recording(part: Callable[..., Any], name: str, called: set[str]) -> Callable[..., Any]:
    """The function, which adds its name to `called` when it is called."""

    def recording(*arguments: Any, **named: Any) -> Any:
        called.add(name)
        return part(*arguments, **named)

    return recording


def _items(parts: Any) -> Iterator[tuple[str, Any]]:
    """The name and value of every part of a record."""
    return ((f.name, getattr(parts, f.name)) for f in fields(parts))


def replaced(fault: Fault) -> frozenset[str]:
    """Names of the parts that a fault replaces; empty for one that is not inside."""
    if fault.inside is None:
        return frozenset()
    return frozenset(_replaced(CORRECT.with_(**fault.inside(CORRECT)), CORRECT, "")) - {MEMORY}


def _replaced(faulty: Any, sound: Any, prefix: str) -> Iterator[str]:
    """Names of the parts of a record that differ from the correct ones."""
    for name, part in _items(faulty):
        right = getattr(sound, name)
        if isinstance(part, Mapping):
            for kind, force in part.items():
                if force is not right[kind]:
                    yield f"{prefix}{name}.{kind.__name__}"
        elif is_dataclass(part):
            yield from _replaced(part, right, f"{prefix}{name}.")
        elif part is not right and part != right:
            yield prefix + name


def acts(fault: Fault, request: Request, called: set[str]) -> bool:
    """Whether a fault can change the run of a request that calls the parts `called`."""
    if fault.after is not None:
        return True
    if fault.before is not None:
        try:
            with np.errstate(all="ignore"):
                return fault.before(request).to_json() != request.to_json()
        except Exception:  # a fault may make a question that is none
            return False
    if request.method.startswith("verlet"):
        method = "verlet"
    else:
        method = request.method
    numbers = CONSTANTS.get(method, ("verlet_kicks",))
    return not replaced(fault).isdisjoint({*called, *numbers})
