"""A trajectory as one NumPy array in a file (`.npy`): the columns of the CSV form as numbers."""

import os
import tokenize
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from refdem.core.outside import one_line, opened
from refdem.core.trajectory import Trajectory
from refdem.core.trajectory_csv import COLUMNS, POINT, STATES, channels_of, trajectory_of
from refdem.errors import UNREADABLE, EngineError

Array = NDArray[np.float64]

TURNING = slice(8, STATES)
"""The columns of attitude and omega, which are NaN for a body that does not rotate."""
HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
"""The versions of the format that NumPy writes for numbers and names in plain letters."""
EXPECTED = (
    f"float64 of shape (rows, {STATES}), the columns {','.join(COLUMNS)}, or a structured array of"
    " float64 with these names, for channels"
)


def read_table(path: Path, samples: int, bodies: int, events: Path | None = None) -> Trajectory:
    """The trajectory in an array with one row for each sample and body, as in the CSV form; raises
    EngineError with the reason.

    A plain array has the columns of the state; a structured array may have channels too. NaN stands
    for an empty cell of the CSV form.
    """
    file = opened(path)
    if file is None:
        raise EngineError(f"the program ended and wrote no {path.name}")
    with file:
        rows, header = _rows(file, samples * bodies, path.name)
    channels = channels_of(header, path.name)
    without = np.isnan(rows[:, TURNING]).all(axis=1)
    rows[without, TURNING] = np.array(POINT, dtype=np.float64)
    wrong = np.argwhere(~np.isfinite(rows[:, :STATES]))
    if len(wrong):
        row, column = wrong[0]
        raise EngineError(
            f"{path.name} row {row + 1}: {COLUMNS[column]} is {rows[row, column]}; expected a"
            " finite number"
        )
    infinite = np.argwhere(np.isinf(rows))
    if len(infinite):
        row, column = infinite[0]
        raise EngineError(
            f"{path.name} row {row + 1}: {header[column]} is infinite; expected a finite number"
        )
    return trajectory_of(rows, channels, (samples, bodies), path.name, events)


def _rows(file: BinaryIO, count: int, name: str) -> tuple[Array, list[str]]:
    """The numbers (count, columns) in a file, and the names of the columns."""
    try:
        version = np.lib.format.read_magic(file)
        shape, is_by_columns, dtype = HEADERS[version](file)
    except (*UNREADABLE, SyntaxError, TypeError, KeyError, MemoryError, tokenize.TokenError):
        raise EngineError(f"{name} is no array in NumPy's format; expected {EXPECTED}") from None
    header = _header(dtype, shape)
    if header is None:
        described = one_line(f"{dtype} of shape {shape}", 200)
        raise EngineError(f"{name} is {described}; expected {EXPECTED}")
    if shape[0] != count:
        raise EngineError(f"{name} has {shape[0]} rows; expected {count}, one a sample and body")
    size = 8 * count * len(header)
    there = os.fstat(file.fileno()).st_size - file.tell()
    if there != size:
        raise EngineError(
            f"{name} has {there} bytes after its header; expected {size}: {count} rows of"
            f" {len(header)} numbers"
        )
    numbers = np.frombuffer(file.read(size), dtype="<f8")
    if len(numbers) != count * len(header):
        raise EngineError(f"{name} was cut while it was read; expected {size} bytes")
    order: Any = "C"
    if is_by_columns and len(shape) > 1:
        order = "F"
    return numbers.reshape((count, len(header)), order=order).copy(), header


def _header(dtype: Any, shape: tuple[int, ...]) -> list[str] | None:
    """The names of the columns of an array; None if it is not of the expected form."""
    if dtype.names is None:
        if dtype == np.dtype("<f8") and len(shape) == 2 and shape[1] == STATES:
            return list(COLUMNS)
        return None
    packed = np.dtype([(column, "<f8") for column in dtype.names])
    if dtype != packed or len(shape) != 1:
        return None
    return list(dtype.names)
