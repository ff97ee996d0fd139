"""Discovery of batteries, and the selection of sweeps for the requested cases."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path

from refdem.core.parameters import nearest
from refdem.errors import UsageError
from refdem.planning.specification import Entry
from refdem.stress.sweep import Battery, Sweep

FOLDER = Path(__file__).with_name("batteries")


@cache
def names() -> tuple[str, ...]:
    """The ids of all batteries, one for each file."""
    stems = sorted(path.stem for path in FOLDER.glob("*.py"))
    return tuple(stem.replace("_", "-") for stem in stems if stem != "__init__")


def battery(name: str) -> Battery:
    """The battery of that id; raises UsageError with the nearest name."""
    if name not in names():
        raise UsageError(f"no battery {name!r}; {nearest(name, names())}")
    result: Battery = import_module(f"refdem.stress.batteries.{name.replace('-', '_')}").BATTERY
    return result


def batteries(requested: Sequence[str], cases: Sequence[Entry]) -> list[Battery]:
    """The requested batteries (none: all), with only the sweeps on the given cases (none: all).

    Raises UsageError if no sweep is left.
    """
    selected = [battery(name) for name in requested or names()]
    if cases:
        selected = [_limited(candidate, cases) for candidate in selected]
    selected = [candidate for candidate in selected if candidate.sweeps]
    if not selected:
        requested_batteries = ", ".join(requested or names())
        requested_cases = ", ".join(entry.id for entry in cases)
        raise UsageError(f"no sweep of {requested_batteries} is on {requested_cases}")
    return selected


def _limited(source: Battery, cases: Sequence[Entry]) -> Battery:
    """A battery with only the sweeps on these cases."""
    sweeps: list[Sweep] = []
    for entry in cases:
        sweeps += _sweeps_for(source, entry)
    return replace(source, sweeps=tuple(sweeps))


def _sweeps_for(source: Battery, entry: Entry) -> list[Sweep]:
    """The sweeps of a battery for a case: those made for it, and general ones put on it, one of
    each kind.

    A sweep made for a case sets its parameters itself, so it does not apply to a case with given
    parameters.
    """
    specific = []
    label = entry.id
    if entry.set:
        parameters = " ".join(f"{name}={value}" for name, value in entry.set.items())
        label = f"{entry.id}[{parameters}]"
    else:
        made_for_cases = [sweep for sweep in source.sweeps if not sweep.is_general]
        specific = [sweep for sweep in made_for_cases if sweep.canonical()[0].id == entry.id]
    general = {sweep.along: sweep for sweep in reversed(source.sweeps) if sweep.is_general}
    adapted = [_on_other_case(sweep, label) for sweep in reversed(general.values())]
    return specific + adapted


def _on_other_case(sweep: Sweep, label: str) -> Sweep:
    """A general sweep on another case, without its promise, which holds for its own case only."""
    if sweep.case == label:
        return sweep
    return replace(
        sweep,
        name=f"{sweep.name.split(':')[0]}: {label}",
        case=label,
        promised="",
        basis="",
        exempt={},
    )
