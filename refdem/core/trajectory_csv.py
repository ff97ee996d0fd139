"""A trajectory as a CSV file, the way programs of any language hand it back."""

import csv
import io
import os
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from refdem.core.outside import one_line, opened
from refdem.core.trajectory import CHANNELS, Event, Trajectory
from refdem.errors import EngineError

Array = NDArray[np.float64]

COLUMNS = ("t", "body", "x", "y", "z", "vx", "vy", "vz", "qw", "qx", "qy", "qz", "wx", "wy", "wz")
EVENT_COLUMNS = ("time", "kind", "body")
STATES = len(COLUMNS)
POINT = ["1", "0", "0", "0", "0", "0", "0"]
"""Attitude and omega of a body whose columns for them are empty: it does not rotate."""
MOST_EVENTS = 1_000_000
"""Largest number of rows of an events file: a program that writes more has a defect, and its file
could fill the memory.
"""
LONGEST_ROW = 2**17
"""Largest number of characters of a row; a row with all channels has 500."""
MOST_EMPTY = 4
"""Largest number of empty lines for each expected row; two between blocks of rows are common."""


def read_trajectory(
    path: Path, samples: int, bodies: int, events: Path | None = None
) -> Trajectory:
    """The trajectory in a CSV file with a row per sample and body; raises EngineError that names
    the wrong line.

    A channel (rod_force, overlap, ...) has a column of its own. In the rows of one sample, the row
    of body k has the value of the k-th element with this channel; the other cells of the column are
    empty.
    """
    row_count = samples * bodies
    # One row more than expected is read, so that a file with more rows is noticed.
    lines = csv_lines(path, row_count + 2, COLUMNS)
    _, first = next(lines, (1, []))
    header = [name.strip() for name in first]
    channels = channels_of(header, path.name)
    # Row by row into one array, so that a file takes little more memory than its numbers.
    rows = np.empty((row_count, len(header)))
    count = 0
    for number, line in lines:
        row = _row(line, header, number, path.name)
        if count < row_count:
            rows[count] = row
        count += 1
    if count != row_count:
        if count < row_count:
            actual = f"{count} rows"
        else:
            actual = "more rows"
        raise EngineError(
            f"{path.name} has {actual}; expected {row_count}: {samples} samples of {bodies} bodies"
        )
    return trajectory_of(rows, channels, (samples, bodies), path.name, events)


def trajectory_of(
    rows: Array, channels: list[str], shape: tuple[int, int], name: str, events: Path | None
) -> Trajectory:
    """The trajectory in rows (samples * bodies, columns) of the file `name`, of which `shape` is
    (samples, bodies); raises EngineError for rows that are out of order.
    """
    samples, bodies = shape
    table = rows.reshape(samples, bodies, -1)
    _refuse_disorder(table, bodies, name)
    columns = {"t": table[:, 0, 0], "position": table[:, :, 2:5], "velocity": table[:, :, 5:8]}
    columns |= {"attitude": table[:, :, 8:12], "omega": table[:, :, 12:15]}
    arrays: dict[str, Any] = {
        part: np.ascontiguousarray(column) for part, column in columns.items()
    }
    # The channels are the columns after those of the state.
    channel_values = {
        channel: _channel(table[:, :, STATES + n], channel, name)
        for n, channel in enumerate(channels)
    }
    return Trajectory(channels=channel_values, events=_events(events, bodies), **arrays)


def csv_lines(path: Path, most: int, columns: tuple[str, ...]) -> Iterator[tuple[int, list[str]]]:
    """The first `most` lines that are not empty, each with its line number in the file.

    Raises EngineError, which names the expected `columns`, if there is no file or it is no CSV.
    """
    binary = opened(path)
    if binary is None:
        raise EngineError(
            f"the program ended and wrote no {path.name}; expected a CSV file with columns"
            f" {','.join(columns)}"
        )
    try:
        with io.TextIOWrapper(binary, newline="", encoding="utf-8", errors="replace") as file:
            yield from islice(_rows(file, MOST_EMPTY * most), most)
    except (OSError, csv.Error) as error:
        raise EngineError(f"{path.name} cannot be read as CSV: {error}") from None


def _rows(file: TextIO, most_empty: int) -> Iterator[tuple[int, list[str]]]:
    """The rows of a CSV file that are not empty, each with the number of its last line.

    Raises csv.Error for a row, or a number of empty lines, beyond the limits LONGEST_ROW and
    `most_empty`: the cells of a row take thirty times the memory of its text.
    """
    lines = _BoundedLines(file)
    reader = csv.reader(lines)
    empty = 0
    for row in reader:
        lines.taken = 0
        if row:
            yield reader.line_num, row
            continue
        empty += 1
        if empty > most_empty:
            raise csv.Error(f"more than {most_empty} empty lines")


@dataclass
class _BoundedLines:
    """The lines of a file; csv.Error if the lines of one row have more than LONGEST_ROW characters
    together. The reader must set `taken` to 0 after each row.
    """

    file: TextIO
    taken: int = 0

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        line = self.file.readline(LONGEST_ROW + 1 - self.taken)
        self.taken += len(line)
        if self.taken > LONGEST_ROW:
            raise csv.Error(f"a row of more than {LONGEST_ROW} characters")
        if not line:
            raise StopIteration
        return line


def channels_of(header: list[str], name: str) -> list[str]:
    """The channel columns after the fixed ones; raises EngineError for another header."""
    extra = header[STATES:]
    if (
        tuple(header[:STATES]) != COLUMNS
        or not set(extra) <= set(CHANNELS)
        or len(set(extra)) < len(extra)
    ):
        raise EngineError(
            f"{name} line 1 is {one_line(','.join(header), 200)!r}; expected {','.join(COLUMNS)}"
            f" and channels of {', '.join(CHANNELS)}"
        )
    return extra


def _row(line: list[str], header: list[str], number: int, name: str) -> list[float]:
    """The numbers of one line; EngineError, with file `name` and line `number`, if one is missing.

    An empty attitude and omega are those of a point, (1, 0, 0, 0) and 0; an empty channel is NaN.
    """
    if len(line) != len(header):
        raise EngineError(f"{name} line {number} has {len(line)} columns; expected {len(header)}")
    # Columns 8 to STATES are attitude and omega.
    if not any(cell.strip() for cell in line[8:STATES]):
        line = [*line[:8], *POINT, *line[STATES:]]
    plain = plain_numbers(line)
    if plain is not None:
        return plain
    numbers: list[float] = []
    for column, cell in zip(header, line, strict=True):
        is_empty_channel = column in CHANNELS and not cell.strip()
        value: float | None = np.nan
        if not is_empty_channel:
            value = number_in(cell)
        if value is None or not (is_empty_channel or np.isfinite(value)):
            raise EngineError(
                f"{name} line {number}: {column} is {one_line(cell, 40)!r}; expected a finite"
                " number"
            )
        numbers.append(value)
    return numbers


def plain_numbers(line: list[str]) -> list[float] | None:
    """The numbers of a line if all cells are finite numbers in Python's notation, else None.

    Almost every line is of this kind, and this function is faster than `_row`.
    """
    text = "".join(line)
    # float() also accepts 1_000, digits of other scripts, and nan.
    if not text.isascii() or "_" in text:
        return None
    try:
        numbers = list(map(float, line))
    except ValueError:
        return None
    if all(map(isfinite, numbers)):
        return numbers
    return None


def number_in(cell: str) -> float | None:
    """The number in a cell, also in Fortran's notation 1.5D+00; None if the cell is no number."""
    if not cell.isascii() or "_" in cell:
        return None
    try:
        return float(cell.lower().replace("d", "e"))
    except ValueError:
        return None


def _channel(values: Array, channel: str, name: str) -> Array:
    """The columns (T, elements) of a channel that are not empty."""
    empty = np.isnan(values)
    if np.any(empty.any(axis=0) != empty.all(axis=0)):
        raise EngineError(
            f"{name}: {channel} is empty in some samples and not in others; expected a number in"
            " all or in none"
        )
    return np.ascontiguousarray(values[:, ~empty.all(axis=0)])


def _refuse_disorder(table: Any, bodies: int, name: str) -> None:
    """Raises EngineError unless every sample has bodies 0..N-1 in order at one time."""
    wrong = np.argwhere((table[:, :, 1] != np.arange(bodies)) | (table[:, :, 0] != table[:, :1, 0]))
    if len(wrong):
        sample, body = wrong[0]
        raise EngineError(
            f"{name} row {sample * bodies + body + 1} is body {table[sample, body, 1]:g} at t ="
            f" {table[sample, body, 0]:.17g}; expected body {body} at t ="
            f" {table[sample, 0, 0]:.17g}: the bodies of a sample in order, at one time"
        )


def _events(path: Path | None, bodies: int) -> tuple[Event, ...]:
    """The events in a CSV file `time,kind,body`, if there is one."""
    # A link that leads nowhere is no file that is not there: it is refused as every link is.
    if path is None or not os.path.lexists(path):
        return ()
    lines = csv_lines(path, MOST_EVENTS + 2, EVENT_COLUMNS)
    _, first = next(lines, (1, []))
    header = tuple(cell.strip() for cell in first)
    if header != EVENT_COLUMNS:
        first_line = one_line(",".join(header), 200)
        raise EngineError(f"{path.name} line 1 is {first_line!r}; expected time,kind,body")
    events = tuple(_event(line, number, path.name, bodies) for number, line in lines)
    if len(events) > MOST_EVENTS:
        raise EngineError(f"{path.name} has more than {MOST_EVENTS} events; expected fewer")
    return events


def _event(line: list[str], number: int, name: str, bodies: int) -> Event:
    """The event in one line of the file `name`; raises EngineError if it is malformed."""
    time = None
    body = None
    if len(line) == len(EVENT_COLUMNS):
        time = number_in(line[0])
        body = number_in(line[2])
    if time is None or not np.isfinite(time) or body is None or body not in range(bodies):
        text = one_line(",".join(line), 80)
        raise EngineError(
            f"{name} line {number} is {text!r}; expected a time, a kind and a body of"
            f" 0..{bodies - 1}"
        )
    return Event(time, one_line(line[1], 40), int(body))
