"""What a campaign is: a TOML file that names cases with parameters, engines, levels and limits."""

import tomllib
from pathlib import Path

import msgspec

from refdem.errors import UsageError

_HERE = Path(__file__).resolve().parents[1]


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One case at one set of parameters, each as text."""

    id: str
    set: dict[str, str] = {}


class Specification(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Cases, engines, and how far to refine: `levels` at most, none with more than `most_steps`; `timeout` [s] a run.

    `engines` empty means all that are installed; `step` [s] overrules the first level; `method` keeps only that one;
    `perturbed_ulps` moves every start by so many units in the last place, to see how much of a value is noise. `required` is the
    folder with the lists of findings that it must make, "" for none; `is_part` says that only some of its cases were asked for.
    `include` names campaigns, in the same folder, whose cases come before its own.
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
    required: str = ""
    is_part: bool = False


def validation_folder() -> Path:
    """The folder of campaigns, expected deviations and baselines: inside the installed package, or beside the source."""
    inside = _HERE / "validation"
    return inside if inside.is_dir() else _HERE.parent / "validation"


def named(name: str, above: tuple[Path, ...] = ()) -> Specification:
    """The campaign `name` of validation/campaigns, or that of a .toml file; raises UsageError if it is not there or not well formed.

    `above` are the files that include it.
    """
    path = Path(name) if name.endswith(".toml") else validation_folder() / "campaigns" / f"{name}.toml"
    if path in above:
        raise UsageError(f"{path} includes itself; take it out of `include`")
    try:
        found = msgspec.convert({"name": path.stem, **tomllib.loads(path.read_text())}, Specification)
    except FileNotFoundError:
        known = sorted(p.stem for p in (validation_folder() / "campaigns").glob("*.toml"))
        raise UsageError(f"no campaign {name!r}; known: {', '.join(known)}, or a file that ends in .toml") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, msgspec.ValidationError) as error:
        raise UsageError(f"{path}: {error}") from None
    inside = [entry for name in found.include for entry in named(str(path.with_name(f"{name}.toml")), above=(*above, path)).case]
    entries = inside + [entry for entry in found.case if entry not in inside]
    if not entries:
        raise UsageError(f"{path} has no case; expected at least one [[case]] with an id")
    return msgspec.structs.replace(found, case=entries, required=str(path.with_suffix("")), is_part=False)
