"""The findings that a campaign must make in every engine, in lists beside its TOML file, so that
changes are reviewed as a diff.

`validation/campaigns/main/mujoco.txt` belongs to `validation/campaigns/main.toml`. It has a line
for every case and method, and below it one line for each check with the quantities that must be
decided, without numbers. `refdem run --campaign main --bless` writes it.
"""

import textwrap
from collections.abc import Iterable
from pathlib import Path

from refdem.core.engine import Engine
from refdem.core.finding import DECIDED, Record, Sheet
from refdem.core.outside import opened
from refdem.errors import EngineError, StoreError, UsageError
from refdem.planning.missing import Place, parts, with_lost, with_missing
from refdem.planning.specification import Specification

CHECK = "  "
"""The indentation of a line with a check and its quantities."""
MORE = "      "
"""The indentation of a line that goes on with the quantities of the line above."""
WIDTH = 120
"""Characters of a line of the lists, which people read in diffs."""


def held(
    sheets: list[Sheet], specification: Specification, engines: list[Engine], labels: Iterable[str]
) -> list[Sheet]:
    """The sheets in which every finding that the campaign must make, and that was not decided, is
    lost or absent.

    Nothing is required of engines that were not run. If only some cases of the campaign were asked
    for, only findings on the instances with these `labels` are required.
    """
    required = set().union(*(_required(specification, engine) for engine in engines))
    if specification.is_part:
        requested_labels = set(labels)
        required = {name for name in required if parts(name)[0][0] in requested_labels}
    if not required:
        return sheets
    owner = f"the list of campaign {specification.name}"
    records = [sheet for sheet in sheets if isinstance(sheet, Record)]
    others = [sheet for sheet in sheets if not isinstance(sheet, Record)]
    with_losses = with_lost(records, required, owner)
    return [*others, *with_missing(with_losses, required, owner)]


def _required(specification: Specification, engine: Engine) -> set[str]:
    """The ids of the findings that the campaign requires of an engine.

    There are none if the campaign is run with other steps, checks or starts than those of its file,
    which make other findings. There are also none for a program with a refdem.toml, for which there
    is no list.
    """
    is_altered = (
        specification.step
        or specification.steps_per_tau
        or specification.checks
        or specification.perturbed_ulps
    )
    if not specification.required or is_altered or engine.address != engine.name:
        return set()
    names = read(Path(specification.required) / f"{engine.name}.txt")
    method = specification.method
    return {name for name in names if not method or parts(name)[0][2] == method}


def decided(records: Iterable[Record]) -> dict[str, set[str]]:
    """The ids of everything that was decided, by engine."""
    by_engine: dict[str, set[str]] = {}
    for record in records:
        names = by_engine.setdefault(record.engine, set())
        names |= {record.id(finding) for finding in record.findings if finding.outcome in DECIDED}
    return by_engine


def read(path: Path) -> set[str]:
    """The ids in a list, none if there is no such file; raises UsageError for a malformed line.

    The engine is the name of the file. A line without indentation is `case/method`, one below it
    `  check: quantity, quantity`, and one that is indented further goes on with the quantities.
    """
    try:
        file = opened(path)
        if file is None:
            return set()
        with file:
            lines = file.read().decode("utf-8").split("\n")
    except (EngineError, OSError, UnicodeDecodeError) as error:
        raise UsageError(
            f"{path} cannot be read: {error}; restore it from version control"
        ) from None
    ids: set[str] = set()
    engine = path.stem
    place = check = ""
    for number, line in enumerate(lines, 1):
        quantities = line
        if not line or line.startswith("#"):
            continue
        if not line.isprintable():
            raise UsageError(f"{path}:{number} is {line!r}; expected characters that print")
        if not line.startswith(CHECK):
            label, _, method = line.rpartition("/")
            place = f"{label}/{engine}/{method}"
            check = ""
            continue
        if not line.startswith(MORE):
            check, _, quantities = line.strip().partition(": ")
        if not place or not check or not quantities.strip():
            raise UsageError(
                f"{path}:{number} is {line!r}; expected a case and method, or below it a check and"
                " its quantities"
            )
        ids |= {
            f"{place}/{check}/{quantity}" for quantity in quantities.strip().rstrip(",").split(", ")
        }
    return ids


def text(campaign: str, names: Iterable[str]) -> str:
    """The text of a list: cases and methods in order, one line per check, long lines wrapped."""
    places: dict[Place, dict[str, list[str]]] = {}
    for name in sorted(names):
        place, check, quantity = parts(name)
        places.setdefault(place, {}).setdefault(check, []).append(quantity)
    lines = [
        f"# What campaign {campaign} must decide: `refdem run --campaign {campaign} --bless` writes"
        " this file."
    ]
    for (label, _, method), checks in places.items():
        lines.append(f"{label}/{method}")
        for check, quantities in checks.items():
            lines += _wrapped(check, quantities)
    return "\n".join(lines) + "\n"


def _wrapped(check: str, quantities: list[str]) -> list[str]:
    """The lines of a check with its quantities, broken at WIDTH, but not within a quantity."""
    # A space within a name is hidden from the line breaking as a NUL.
    joined = ", ".join(quantity.replace(" ", "\0") for quantity in quantities)
    broken = textwrap.wrap(
        f"{check}: {joined}",
        WIDTH,
        initial_indent=CHECK,
        subsequent_indent=MORE,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace("\0", " ") for line in broken]


def written(specification: Specification, records: list[Record]) -> list[str]:
    """Writes the lists of the engines that ran and returns the changes, a line each.

    Raises UsageError, and writes nothing, if a finding is an error or nothing was decided.
    """
    broken: list[str] = []
    for record in records:
        errors = [finding for finding in record.findings if finding.outcome == "error"]
        broken += map(record.id, errors)
    if broken:
        raise UsageError(
            f"{len(broken)} findings are errors, first {broken[0]}; the lists are unchanged:"
            " correct the engine, then bless"
        )
    now = decided(records)
    if not any(now.values()):
        raise UsageError(
            f"campaign {specification.name} decided nothing, so there is nothing to write down"
        )
    folder = Path(specification.required)
    changes: list[str] = []
    for engine, names in sorted(now.items()):
        path = folder / f"{engine}.txt"
        before = read(path)
        changes += [f"+ {name}" for name in sorted(names - before)]
        changes += [f"- {name}" for name in sorted(before - names)]
        _write(path, text(specification.name, names))
        changes.append(f"{path}: {len(names)} findings must be made")
    return changes


def _write(path: Path, content: str) -> None:
    """Writes a list; raises StoreError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    except OSError as error:
        raise StoreError(f"{path} cannot be written: {error.strerror}") from None
