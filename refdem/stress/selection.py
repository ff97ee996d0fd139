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
    """The ids of all batteries, one for each file."""
    stems = sorted(path.stem for path in FOLDER.glob("*.py"))
    return tuple(stem.replace("_", "-") for stem in stems if stem != "__init__")


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
        found = [_limited(one, cases) for one in found]
    found = [one for one in found if one.ladders]
    if not found:
        batteries_asked = ", ".join(asked or names())
        cases_asked = ", ".join(entry.id for entry in cases)
        raise UsageError(f"no ladder of {batteries_asked} is on {cases_asked}")
    return found


def _limited(one: Battery, cases: Sequence[Entry]) -> Battery:
    """A battery with its ladders on these cases alone."""
    ladders: list[Ladder] = []
    for entry in cases:
        ladders += _on(one, entry)
    return replace(one, ladders=tuple(ladders))


def _on(one: Battery, entry: Entry) -> list[Ladder]:
    """The ladders of a battery that are on a case: those made for it, and general ones put on it,
    one of each kind.

    What is made for a case sets its parameters itself, so that it is not for a case that came with
    parameters.
    """
    own = []
    label = entry.id
    if entry.set:
        parameters = " ".join(f"{name}={value}" for name, value in entry.set.items())
        label = f"{entry.id}[{parameters}]"
    else:
        made_for_cases = [ladder for ladder in one.ladders if not ladder.is_general]
        own = [ladder for ladder in made_for_cases if ladder.canonical()[0].id == entry.id]
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
