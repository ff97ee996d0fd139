"""The specification of a campaign: a TOML file that names cases with parameters, engines, levels
and limits.
"""

from pathlib import Path

import msgspec

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.outside import one_line
from refdem.core.parameters import nearest
from refdem.core.reading import is_file, toml_as
from refdem.core.selection import Selection
from refdem.errors import OutOfRangeError, UsageError

YEAR = 366 * 86400.0
"""Seconds in a leap year."""
_HERE = Path(__file__).resolve().parents[1]


MOST_LEVELS = 10
"""Largest number of refinement levels: the finest step is then a thousandth of the first."""


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One case at one set of parameters, each as text.

    `levels` replaces the number of levels of the campaign for this case. There are more where the
    order of convergence shows only at small steps, and fewer where a run is expensive.
    """

    id: str
    set: dict[str, str] = {}
    levels: int | msgspec.UnsetType = msgspec.UNSET

    def __post_init__(self) -> None:
        """Raises OutOfRangeError for a number of levels out of range."""
        if self.levels is not msgspec.UNSET and not 1 <= self.levels <= MOST_LEVELS:
            given = one_line(str(self.levels), 40)
            raise OutOfRangeError(
                f"levels of {self.id} is {given}; expected a whole number from 1 to {MOST_LEVELS}"
            )

    def asks_the_same_as(self, other: "Entry") -> bool:
        """True for the same case at the same parameters, for any levels."""
        return self.question == other.question

    @property
    def question(self) -> tuple[str, frozenset[tuple[str, str]]]:
        """The case and its parameters, in a form that can be compared; levels do not matter."""
        return self.id, frozenset(self.set.items())

    @property
    def label(self) -> str:
        """The case with its parameters, such as `pendulum[theta0=2]`."""
        inside = " ".join(f"{name}={value}" for name, value in self.set.items())
        if inside:
            return f"{self.id}[{inside}]"
        return self.id


class Specification(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Cases, engines, and how far to refine: `levels` at most, none with more than `most_steps`;
    `timeout` [s] a run.

    `engines` empty means all that are installed. `step` [s] replaces the first level, and `method`
    selects one method. `perturbed_ulps` moves every start by that many units in the last place, to
    measure the noise of a value. `required` is the folder with the lists of findings that it must
    make, "" for none. `is_part` is true if only some of its cases were requested. `every_case` adds
    those of refdem's own cases that no entry names, each at its defaults. `as_shipped` adds the
    methods with an engine's default settings to the tuned ones. `include` names campaigns in the
    same folder, whose cases come before its own; its own entry replaces an included one with the
    same case and parameters.
    """

    name: str
    case: list[Entry] = []
    engines: list[str] = []
    checks: list[str] = []
    levels: int = 4
    most_steps: float = 2e6
    timeout: float = 60.0
    method: str = ""
    step: float | None = None
    steps_per_tau: float | None = None
    perturbed_ulps: int = 0
    include: list[str] = []
    every_case: bool = False
    as_shipped: bool = False
    required: str = ""
    is_part: bool = False

    def __post_init__(self) -> None:
        """Raises OutOfRangeError for numbers out of range and repeated entries; msgspec adds their
        place in the file to the error.
        """
        ranges = {
            "levels": (self.levels, 1, MOST_LEVELS),
            "most_steps": (self.most_steps, 1, 1e12),
            "timeout": (self.timeout, 1e-3, YEAR),
            "step": (self.step, 1e-300, 1e300),
            "steps_per_tau": (self.steps_per_tau, 1e-6, 1e12),
            "perturbed_ulps": (self.perturbed_ulps, -(2**40), 2**40),
        }
        for name, (value, lowest, highest) in ranges.items():
            # NaN is in no range. An integer may be too large for the format {:g}.
            if value is not None and not lowest <= value <= highest:
                is_printable = abs(value) < 1e300
                if is_printable:
                    printed = f"{value:g}"
                else:
                    printed = one_line(str(value), 40)
                raise OutOfRangeError(
                    f"{name} is {printed}; expected a finite number from {lowest:g} to {highest:g}"
                )
        if self.step is not None and self.steps_per_tau is not None:
            raise OutOfRangeError("got both step and steps_per_tau; expected at most one of them")
        questions = set()
        for entry in self.case:
            if entry.question in questions:
                raise OutOfRangeError(f"{entry.label} is listed twice; remove one")
            questions.add(entry.question)

    def levels_of(self, instance: Instance) -> int:
        """The number of levels for an instance: that of its entry, if it says one, else that of the
        campaign.
        """
        case = instance.case
        for entry in self.case:
            if entry.levels is msgspec.UNSET or entry.id != case.id:
                continue
            if case.at(**entry.set).label == instance.label:
                return entry.levels
        return self.levels

    def of_one(self, instance: Instance, method: str = "") -> "Specification":
        """The specification of an instance alone, and of one method: without cases and engines, and
        with the levels of the entry of the instance.
        """
        levels = self.levels_of(instance)
        return msgspec.structs.replace(self, case=[], engines=[], method=method, levels=levels)


def validation_folder() -> Path:
    """The folder of campaigns, expected deviations and baselines: inside the installed package, or
    beside the source.
    """
    inside = _HERE / "validation"
    if inside.is_dir():
        return inside
    return _HERE.parent / "validation"


def unnamed_cases(entries: list[Entry]) -> list[Entry]:
    """The cases in refdem/cases that no entry names, at their defaults; no selection of others."""
    named_ids = {entry.id for entry in entries}
    others = [name for name in discovery.own_names("cases") if name not in named_ids]
    return [Entry(name) for name in others if not isinstance(discovery.case(name), Selection)]


def _joined(included: list[Entry], own: list[Entry]) -> list[Entry]:
    """Included entries, and then own ones; an own entry takes the place of one that asks the
    same.
    """
    joined = list(included)
    for entry in own:
        places = [n for n, other in enumerate(joined) if entry.asks_the_same_as(other)]
        if places:
            joined[places[0]] = entry
        else:
            joined.append(entry)
    return joined


def named(name: str, above: tuple[Path, ...] = ()) -> Specification:
    """The campaign `name` of validation/campaigns, or that of a .toml file; raises UsageError if it
    is not there or not well formed.

    `above` are the files that include it.
    """
    if name.endswith(".toml"):
        path = Path(name)
    else:
        path = validation_folder() / "campaigns" / f"{name}.toml"
    if path in above:
        raise UsageError(f"{path} includes itself; take it out of `include`")
    if not is_file(path):
        known = {p.stem for p in (validation_folder() / "campaigns").glob("*.toml")}
        hint = nearest(name, known)
        raise UsageError(
            f"no campaign {one_line(name)!r} (its name, or a file that ends in .toml, was"
            f" expected); {hint}"
        )
    specification = toml_as(Specification, path, "a campaign", {"name": path.stem})
    included: list[Entry] = []
    for other in specification.include:
        other_path = path.with_name(f"{other}.toml")
        included += named(str(other_path), above=(*above, path)).case
    entries = _joined(included, specification.case)
    if specification.every_case:
        entries += unnamed_cases(entries)
    if not entries:
        raise UsageError(f"{path} has no case; expected at least one [[case]] with an id")
    return msgspec.structs.replace(
        specification, case=entries, required=str(path.with_suffix("")), is_part=False
    )
