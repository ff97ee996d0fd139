"""The derivatives of a trajectory as a CSV file, the way programs of any language hand them back.

A row has the derivatives of the state of one body at one sample by one number of the scene, in the
columns of a trajectory: `number,t,body,x,y,z,...` with dx/ds in the column x, and so on. The rows
are in the order of the numbers in the request, each with the rows of a whole trajectory.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from refdem.core.outside import one_line
from refdem.core.trajectory import Trajectory
from refdem.core.trajectory_csv import COLUMNS, csv_lines, number_in
from refdem.errors import EngineError

Array = NDArray[np.float64]

SENSITIVITY_COLUMNS = ("number", *COLUMNS)
STATE_BEGINS = 3
"""Index of the first derivative; the columns before it are the number, the time and the body."""
TURN_BEGINS = SENSITIVITY_COLUMNS.index("qw")
"""Index of the first derivative of the attitude. From it on all cells of a row may be empty: the
body does not rotate, and these derivatives are 0.
"""
SAME_TIME = 1e-9
"""Largest difference of times in the two files, relative to the largest time."""


def with_sensitivities(trajectory: Trajectory, path: Path, requested: Sequence[str]) -> Trajectory:
    """A trajectory with the derivatives by the `requested` numbers, from the file beside it;
    unchanged if none are requested. Raises EngineError, naming the line, if the file is wrong.
    """
    if not requested:
        return trajectory
    samples, bodies, _ = trajectory.position.shape
    count = len(requested) * samples * bodies
    # One row more than expected is read, so that a file with more rows is noticed.
    lines = csv_lines(path, count + 2, SENSITIVITY_COLUMNS)
    _, first = next(lines, (1, []))
    header = tuple(cell.strip() for cell in first)
    if header != SENSITIVITY_COLUMNS:
        raise EngineError(
            f"{path.name} line 1 is {one_line(','.join(header), 200)!r}; expected"
            f" {','.join(SENSITIVITY_COLUMNS)}"
        )
    width = len(SENSITIVITY_COLUMNS) - STATE_BEGINS
    derivatives = np.zeros((len(requested), samples, bodies, width))
    found = 0
    for number, line in lines:
        if found < count:
            place = np.unravel_index(found, derivatives.shape[:3])
            key, sample, body = (int(index) for index in place)
            expected = requested[key], float(trajectory.t[sample]), body
            where = f"{path.name} line {number}"
            _refuse_misplaced(line, expected, float(np.max(np.abs(trajectory.t))), where)
            derivatives[place] = _slopes(line, where)
        found += 1
    if found != count:
        actual = "more rows"
        if found < count:
            actual = f"{found} rows"
        raise EngineError(
            f"{path.name} has {actual}; expected {count}: {len(requested)} numbers of {samples}"
            f" samples of {bodies} bodies"
        )
    return replace(trajectory, derivatives=dict(zip(requested, derivatives, strict=True)))


def _refuse_misplaced(
    line: list[str], expected: tuple[str, float, int], longest: float, where: str
) -> None:
    """Raises EngineError unless a line is of the expected number, time [s] and body."""
    if len(line) != len(SENSITIVITY_COLUMNS):
        raise EngineError(f"{where} has {len(line)} columns; expected {len(SENSITIVITY_COLUMNS)}")
    key, t, body = expected
    actual_time = number_in(line[1])
    actual_body = number_in(line[2])
    is_at_time = actual_time is not None and abs(actual_time - t) <= SAME_TIME * longest
    if line[0].strip() != key or not is_at_time or actual_body != body:
        actual = one_line(",".join(line[:STATE_BEGINS]), 120)
        raise EngineError(
            f"{where} begins with {actual!r}; expected {key},{t:.17g},{body}: the numbers in the"
            " order of the request, each with all samples and bodies"
        )


def _slopes(line: list[str], where: str) -> list[float]:
    """The derivatives in a line; those of attitude and omega are 0 if all their cells are empty."""
    cells = line[STATE_BEGINS:]
    if not any(cell.strip() for cell in line[TURN_BEGINS:]):
        turn = len(SENSITIVITY_COLUMNS) - TURN_BEGINS
        cells = [*line[STATE_BEGINS:TURN_BEGINS], *["0"] * turn]
    slopes = []
    for column, cell in zip(SENSITIVITY_COLUMNS[STATE_BEGINS:], cells, strict=True):
        value = number_in(cell)
        if value is None or not np.isfinite(value):
            raise EngineError(
                f"{where}: {column} is {one_line(cell, 40)!r}; expected a finite number"
            )
        slopes.append(value)
    return slopes
