"""Which batteries there are, and which of their ladders are climbed."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path

from refdem.campaign.specification import Entry
from refdem.core.parameters import nearest
from refdem.errors import UsageError
from refdem.stress.ladder import Battery, Ladder

FOLDER = Path(__file__).with_name("batteries")


@cache
def names() -> tuple[str, ...]:
    """Ids of all batteries: a file each."""
    return tuple(
        path.stem.replace("_", "-")
        for path in sorted(FOLDER.glob("*.py"))
        if path.stem != "__init__"
    )


def battery(name: str) -> Battery:
    """The battery of that id; raises UsageError with the nearest name."""
    if name not in names():
        raise UsageError(f"no battery {name!r}; {nearest(name, names())}")
    found: Battery = import_module(f"refdem.stress.batteries.{name.replace('-', '_')}").BATTERY
    return found


def batteries(asked: Sequence[str], cases: Sequence[Entry]) -> list[Battery]:
    """The batteries asked for (none: all), with the ladders on these cases (none: all); raises
    UsageError if nothing is left.
    """
    found = [battery(name) for name in asked or names()]
    if cases:
        found = [
            replace(one, ladders=tuple(ladder for entry in cases for ladder in _on(one, entry)))
            for one in found
        ]
    found = [one for one in found if one.ladders]
    if not found:
        raise UsageError(
            f"no ladder of {', '.join(asked or names())} is on"
            f" {', '.join(entry.id for entry in cases)}"
        )
    return found


def _on(one: Battery, entry: Entry) -> list[Ladder]:
    """The ladders of a battery that are on a case: those made for it, and general ones put on it,
    one of each kind.

    What is made for a case sets its parameters itself, so that it is not for a case that came with
    parameters.
    """
    own = [
        ladder
        for ladder in one.ladders
        if not ladder.is_general and not entry.set and ladder.canonical()[0].id == entry.id
    ]
    label = entry.id + (
        f"[{' '.join(f'{name}={value}' for name, value in entry.set.items())}]" if entry.set else ""
    )
    general = {ladder.along: ladder for ladder in reversed(one.ladders) if ladder.is_general}
    put = [_put(ladder, label) for ladder in reversed(general.values())]
    return own + put


def _put(ladder: Ladder, label: str) -> Ladder:
    """A general ladder on another case; what is promised on its own case is not on this one."""
    if ladder.case == label:
        return ladder
    return replace(
        ladder, name=f"{ladder.name.split(':')[0]}: {label}", case=label, promised="", basis=""
    )
