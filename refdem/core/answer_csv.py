"""What a program hands back as a CSV file: a trajectory, or a table of the mass properties of
solids.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from refdem.core.statics import MASS_PROPERTIES, Solid, properties
from refdem.core.trajectory import Trajectory
from refdem.core.trajectory_csv import csv_lines, number_in, read_trajectory
from refdem.errors import EngineError, UsageError

if TYPE_CHECKING:
    from refdem.core.problem_kinds import Problem

SOLID_COLUMNS = ("solid", *(name.rpartition(".")[2] for name in MASS_PROPERTIES))
"""solid,mass,x,y,z,xx,yy,zz,xy,xz,yz: a row a solid in the order of the request; the tensor's own
entries, xy = -integral of x y.
"""
TRAVELLING = ("motion", "solid")
"""The kinds of questions that programs can be asked."""


def most_rows(problem: "Problem") -> int:
    """How many rows the answer has, without its header; raises UsageError for a question that does
    not travel.
    """
    if problem.kind not in TRAVELLING:
        raise UsageError(
            f"{problem.words} does not travel to programs; expected one of {', '.join(TRAVELLING)}"
        )
    if isinstance(problem, Solid):
        return len(problem.content.solids)
    return len(problem.times) * len(problem.scene.bodies)


def read_answer(problem: "Problem", path: Path, events: Path | None = None) -> Trajectory:
    """The answer to a question in the file that a program wrote; raises EngineError with the line
    that is wrong.
    """
    if isinstance(problem, Solid):
        return read_solids(path, problem)
    return read_trajectory(path, len(problem.times), len(problem.scene.bodies), events)


def read_solids(path: Path, problem: Solid) -> Trajectory:
    """Mass properties by `<solid>.<property>`; an empty cell is what the program cannot say."""
    names = [piece.name for piece in problem.content.solids]
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
            came = f"{len(lines) - 1} rows"
        else:
            came = "more rows"
        raise EngineError(f"{path.name} has {came}; expected {len(names)}, one a solid")
    said = {
        name: _said(line, name, f"{path.name} line {number}")
        for name, (number, line) in zip(names, lines[1:], strict=True)
    }
    if not any(said.values()):
        raise EngineError(
            f"{path.name} says nothing of any solid; a program that cannot say anything ends with"
            " exit status 77"
        )
    return Trajectory.of_values(problem.times, properties(problem, lambda piece: said[piece.name]))


def _said(line: list[str], solid: str, place: str) -> dict[str, float]:
    """The properties in the cells of one row that are not empty."""
    if len(line) != len(SOLID_COLUMNS):
        raise EngineError(f"{place} has {len(line)} columns; expected {len(SOLID_COLUMNS)}")
    if line[0].strip() != solid:
        raise EngineError(
            f"{place} is of {line[0][:40]!r}; expected {solid!r}: the solids in the order of the"
            " request"
        )
    found = {}
    for name, column, cell in zip(MASS_PROPERTIES, SOLID_COLUMNS[1:], line[1:], strict=True):
        if cell.strip():
            value = number_in(cell)
        else:
            value = None
        if cell.strip() and (value is None or not np.isfinite(value)):
            raise EngineError(
                f"{place}: {column} is {cell[:40]!r}; expected a finite number, or nothing"
            )
        if value is not None:
            found[name] = value
    return found
