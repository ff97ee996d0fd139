"""A program's answer in a file: a trajectory (CSV or NumPy), or a table of the mass properties of
solids (CSV).
"""

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from refdem.core.static_problems import MASS_PROPERTIES, Solid, properties
from refdem.core.trajectory import Trajectory
from refdem.core.trajectory_csv import csv_lines, number_in, read_trajectory
from refdem.core.trajectory_npy import read_table
from refdem.errors import EngineError, UsageError

if TYPE_CHECKING:
    from refdem.core.problem_kinds import Problem

SOLID_COLUMNS = ("solid", *(name.rpartition(".")[2] for name in MASS_PROPERTIES))
"""solid,mass,x,y,z,xx,yy,zz,xy,xz,yz: a row a solid in the order of the request; the tensor's own
entries, xy = -integral of x y.
"""
TRAVELLING = ("motion", "solid")
"""The kinds of questions that a request to a program can have."""


def most_rows(problem: "Problem") -> int:
    """Number of rows of the answer, without its header.

    Raises UsageError for a kind of question that no request can have.
    """
    if problem.kind not in TRAVELLING:
        raise UsageError(
            f"{problem.words} cannot be sent to programs; expected one of {', '.join(TRAVELLING)}"
        )
    if isinstance(problem, Solid):
        return len(problem.content.solids)
    return len(problem.times) * len(problem.scene.bodies)


def read_answer(problem: "Problem", path: Path, events: Path | None = None) -> Trajectory:
    """The answer to a question in the file that a program wrote, or for a trajectory in the one
    beside it that ends in `.npy`; raises EngineError with the line that is wrong.
    """
    if isinstance(problem, Solid):
        return read_solids(path, problem)
    table = path.with_suffix(".npy")
    if os.path.lexists(table):
        if os.path.lexists(path):
            raise EngineError(f"there are {path.name} and {table.name}; expected one of them")
        return read_table(table, len(problem.times), len(problem.scene.bodies), events)
    return read_trajectory(path, len(problem.times), len(problem.scene.bodies), events)


def read_solids(path: Path, problem: Solid) -> Trajectory:
    """The mass properties `<solid>.<property>` in a CSV file with a row a solid.

    An empty cell is a property that the program does not determine. Raises EngineError that names
    the wrong line.
    """
    names = [piece.name for piece in problem.content.solids]
    # One row more than expected is read, so that a file with more rows is noticed.
    lines = list(csv_lines(path, len(names) + 2, SOLID_COLUMNS))
    if lines:
        header = tuple(cell.strip() for cell in lines[0][1])
    else:
        header = ()
    if header != SOLID_COLUMNS:
        raise EngineError(
            f"{path.name} line 1 is {','.join(header)[:200]!r}; expected {','.join(SOLID_COLUMNS)}"
        )
    if len(lines) - 1 != len(names):
        if len(lines) <= len(names):
            actual = f"{len(lines) - 1} rows"
        else:
            actual = "more rows"
        raise EngineError(f"{path.name} has {actual}; expected {len(names)}, one a solid")
    entries = {
        name: _entries(line, name, f"{path.name} line {number}")
        for name, (number, line) in zip(names, lines[1:], strict=True)
    }
    if not any(entries.values()):
        raise EngineError(
            f"{path.name} has no value of any solid; a program that cannot compute any ends with"
            " exit status 77"
        )
    values = properties(problem, lambda piece: entries[piece.name])
    return Trajectory.of_values(problem.times, values)


def _entries(line: list[str], solid: str, place: str) -> dict[str, float]:
    """The properties in the cells of one row that are not empty.

    Raises EngineError, with the `place` (file and line), unless the row is that of `solid` and its
    cells are finite numbers or empty.
    """
    if len(line) != len(SOLID_COLUMNS):
        raise EngineError(f"{place} has {len(line)} columns; expected {len(SOLID_COLUMNS)}")
    if line[0].strip() != solid:
        raise EngineError(
            f"{place} is of {line[0][:40]!r}; expected {solid!r}: the solids in the order of the"
            " request"
        )
    entries = {}
    for name, column, cell in zip(MASS_PROPERTIES, SOLID_COLUMNS[1:], line[1:], strict=True):
        if not cell.strip():
            continue
        value = number_in(cell)
        if value is None or not np.isfinite(value):
            raise EngineError(
                f"{place}: {column} is {cell[:40]!r}; expected a finite number, or nothing"
            )
        entries[name] = value
    return entries
