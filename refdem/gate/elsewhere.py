"""The baselines of programs that run elsewhere, each a file beside the exported requests."""

from collections.abc import Mapping
from pathlib import Path

from refdem.core.finding import Finding, Record, Sheet
from refdem.gate import baseline, compare
from refdem.gate.baseline import Accepted
from refdem.planning import exchange


def baselines(folder: Path) -> dict[str, Path]:
    """The baseline of each program of an export, by its name; a file need not be there yet.

    Raises UsageError if a link, a pipe or a device has the place of one, since the folder was
    filled on another machine.
    """
    names = exchange.read(folder).versions
    return {name: exchange.plain(folder / f"{name}-baseline.jsonl") for name in names}


def accepted(paths: Mapping[str, Path]) -> dict[str, dict[str, Accepted]]:
    """The accepted findings by id, of each program that has a baseline.

    Raises UsageError for a baseline that cannot be read or is another program's.
    """
    found = {}
    for name, path in paths.items():
        if path.is_file():
            _, found[name] = baseline.read(path, name)
    return found


def against_baselines(
    sheets: list[Sheet], accepted_of: Mapping[str, dict[str, Accepted]]
) -> list[Sheet]:
    """The sheets, in which the records of each program that has a baseline are compared with it."""
    compared: list[Sheet] = [
        sheet
        for sheet in sheets
        if not isinstance(sheet, Record) or sheet.engine not in accepted_of
    ]
    for name, findings in accepted_of.items():
        compared += compare.compared(of_program(sheets, name), findings, _no_spread)
    return compared


def of_program(sheets: list[Sheet], name: str) -> list[Record]:
    """The records of one program."""
    return [sheet for sheet in sheets if isinstance(sheet, Record) and sheet.engine == name]


def _no_spread(record: Record, finding: Finding) -> float:
    """The spread of a finding's size in reruns: 0, since what runs elsewhere is not run again."""
    return 0.0
