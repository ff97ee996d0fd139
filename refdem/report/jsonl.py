"""Records as JSON lines: a sheet a line, finite numbers only."""

import errno
import math
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import msgspec

from refdem.core.finding import Finding, Level, Record, Series, Sheet
from refdem.core.outside import opened, printable
from refdem.core.reading import error_message
from refdem.errors import UNREADABLE, EngineError, StoreError, UsageError

RECORDS = "records.jsonl"
NUMBERS = ("value", "bound", "order_seen", "order_claimed", "constant_seen", "sharpness")
"""The numbers of a finding."""
CONTROL = re.compile(rb"\\u|\\[bfr]|\x7f")
"""How JSON in ASCII writes characters that may not print."""
_DECODER: msgspec.json.Decoder[Sheet] = msgspec.json.Decoder(Sheet)


def lines(sheets: Iterable[Sheet]) -> bytes:
    """The sheets as JSON lines; an integer in a float field is written as a float, 0 as 0.0.

    Sheets that are read back are therefore written as the same bytes again.
    """
    decoded = (_DECODER.decode(msgspec.json.encode(finite(sheet))) for sheet in sheets)
    return b"".join(msgspec.json.encode(sheet) + b"\n" for sheet in decoded)


def sheets_in(folder: Path, name: str = RECORDS) -> list[Sheet]:
    """The sheets of a file in the folder of a report; raises StoreError or, with the line,
    UsageError.
    """
    path = folder / name
    sheets = []
    for number, line in enumerate(content(path).splitlines(), 1):
        if not line.strip():
            continue
        try:
            sheets.append(_DECODER.decode(_printable(line)))
        except UNREADABLE as error:
            message = error_message(error, Record)
            raise UsageError(
                f"{path}, line {number}: {message}."
                " Expected one sheet of the schema of `refdem schema records`."
            ) from None
    return sheets


def content(path: Path) -> bytes:
    """The bytes of a plain file; raises StoreError for a link, a pipe, a device, or no file."""
    why = os.strerror(errno.ENOENT)
    try:
        file = opened(path)
    except EngineError as error:
        why = str(error)
        file = None
    if file is None:
        raise StoreError(
            f"cannot read {path}: {why}. Expected the folder of a report; make one with `refdem"
            " run`."
        )
    with file:
        return file.read()


def _printable(line: bytes) -> bytes:
    """The line with "?" for each unprintable character in its texts: records are not trusted."""
    if line.isascii() and not CONTROL.search(line):
        return line
    return msgspec.json.encode(_cleaned(msgspec.json.decode(line)))


def _cleaned(part: Any) -> Any:
    """A part of a document whose texts have only printable characters."""
    if isinstance(part, str):
        return printable(part)
    if isinstance(part, list):
        return [_cleaned(item) for item in part]
    if isinstance(part, dict):
        return {printable(name): _cleaned(item) for name, item in part.items()}
    return part


def finite(sheet: Sheet) -> Sheet:
    """The sheet without numbers that are not finite, which JSON cannot represent.

    Such levels and points are left out, and other such numbers become null. The finding is kept;
    its outcome and its sentence state that a number was not finite.
    """
    if not isinstance(sheet, Record):
        return sheet
    return msgspec.structs.replace(
        sheet, findings=tuple(_finite_finding(finding) for finding in sheet.findings)
    )


def _finite_finding(finding: Finding) -> Finding:
    """The finding without the levels and the points of its curve that are not finite."""
    levels = tuple(level for level in finding.levels if _is_finite_level(level))
    if finding.series is None:
        series = None
    else:
        series = _finite_series(finding.series)
    numbers = {name: _number(getattr(finding, name)) for name in NUMBERS}
    return msgspec.structs.replace(finding, levels=levels, series=series, **numbers)


def _is_finite_level(level: Level) -> bool:
    return all(map(math.isfinite, (level.level, level.error, level.bound, level.seconds)))


def _finite_series(series: Series) -> Series | None:
    """The points of a curve that are finite, None if no point is."""
    every = zip(series.t, series.value, series.bound, strict=False)
    points = [point for point in every if all(map(math.isfinite, point))]
    if not points:
        return None
    return Series(
        t=[t for t, _, _ in points],
        value=[value for _, value, _ in points],
        bound=[bound for _, _, bound in points],
    )


def _number(value: float | None) -> float | None:
    if value is not None and math.isfinite(value):
        return value
    return None
