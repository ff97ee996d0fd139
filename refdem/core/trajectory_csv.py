"""A trajectory as a CSV file, the way programs of any language hand it back."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.trajectory import CHANNELS, Event, Trajectory
from refdem.errors import EngineError

Array = NDArray[np.float64]

COLUMNS = ("t", "body", "x", "y", "z", "vx", "vy", "vz", "qw", "qx", "qy", "qz", "wx", "wy", "wz")
POINT = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""What empty attitude columns mean: a body that does not turn."""
MOST_BYTES = 2**31


def read_trajectory(path: Path, samples: int, bodies: int, events: Path | None = None) -> Trajectory:
    """The trajectory in a file with a row per sample and body; raises EngineError with the line that is wrong."""
    if not path.is_file():
        raise EngineError(f"the program ended and wrote no {path.name}; expected a CSV file with columns {','.join(COLUMNS)}")
    if path.stat().st_size > MOST_BYTES:
        raise EngineError(f"{path.name} has {path.stat().st_size} bytes; expected {samples} x {bodies} rows")
    with path.open(newline="", encoding="utf-8", errors="replace") as file:
        reader = csv.reader(file)
        header = [name.strip() for name in next(reader, [])]
        channels = _channels(header, path.name)
        rows = [_row(line, header, reader.line_num, path.name) for line in reader if line]
    if len(rows) != samples * bodies:
        raise EngineError(f"{path.name} has {len(rows)} rows; expected {samples * bodies}: {samples} samples of {bodies} bodies")
    table = np.array(rows).reshape(samples, bodies, -1)
    _refuse_disorder(table, bodies, path.name)
    return Trajectory(
        t=np.ascontiguousarray(table[:, 0, 0]),
        position=np.ascontiguousarray(table[:, :, 2:5]),
        velocity=np.ascontiguousarray(table[:, :, 5:8]),
        attitude=np.ascontiguousarray(table[:, :, 8:12]),
        omega=np.ascontiguousarray(table[:, :, 12:15]),
        channels={name: np.ascontiguousarray(table[:, :, 15 + n]) for n, name in enumerate(channels)},
        events=_events(events),
    )


def _channels(header: list[str], name: str) -> list[str]:
    """The channel columns after the fixed ones; raises EngineError for another header."""
    extra = header[len(COLUMNS) :]
    if tuple(header[: len(COLUMNS)]) != COLUMNS or not set(extra) <= set(CHANNELS) or len(set(extra)) < len(extra):
        raise EngineError(
            f"{name} line 1 is {','.join(header)[:200]!r}; expected {','.join(COLUMNS)} and channels of {', '.join(CHANNELS)}"
        )
    return extra


def _row(line: list[str], header: list[str], number: int, name: str) -> list[float]:
    """The numbers of one line, with (1, 0, 0, 0) and 0 for the empty attitude and omega of a point."""
    if len(line) != len(header):
        raise EngineError(f"{name} line {number} has {len(line)} columns; expected {len(header)}")
    if not any(cell.strip() for cell in line[8:15]):
        line = [*line[:8], *map(str, POINT), *line[15:]]
    try:
        return [float(cell) for cell in line]
    except ValueError as error:
        raise EngineError(f"{name} line {number}: {error}") from None


def _refuse_disorder(table: Any, bodies: int, name: str) -> None:
    """Raises EngineError unless every sample has bodies 0..N-1 in order at one time."""
    wrong = np.argwhere((table[:, :, 1] != np.arange(bodies)) | (table[:, :, 0] != table[:, :1, 0]))
    if len(wrong):
        sample, body = wrong[0]
        raise EngineError(
            f"{name} line {sample * bodies + body + 2} is body {table[sample, body, 1]:g} at t = {table[sample, body, 0]!r}; "
            f"expected body {body} at t = {table[sample, 0, 0]!r}: the bodies of a sample in order, at one time"
        )


def _events(path: Path | None) -> tuple[Event, ...]:
    """The events in a CSV file `time,kind,body`, if there is one."""
    if path is None or not path.is_file():
        return ()
    with path.open(newline="", encoding="utf-8", errors="replace") as file:
        rows = list(csv.reader(file))
    if not rows or [cell.strip() for cell in rows[0]] != ["time", "kind", "body"]:
        raise EngineError(f"{path.name} line 1 is {rows[:1]}; expected time,kind,body")
    try:
        return tuple(Event(float(time), kind.strip(), int(body)) for time, kind, body in rows[1:])
    except ValueError as error:
        raise EngineError(f"{path.name}: {error}") from None
