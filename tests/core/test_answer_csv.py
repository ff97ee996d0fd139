"""Tables of mass properties as programs hand them back: what is right is read, what is wrong is
named with its line.
"""

from pathlib import Path

import numpy as np
import pytest

from refdem.core.answer_csv import SOLID_COLUMNS, most_rows, read_answer
from refdem.core.problem import Iteration, Solid
from refdem.core.static_problems import MASS_PROPERTIES, Cuboid, Piece, SolidDocument
from refdem.errors import EngineError, UsageError

PIECES = [
    Piece(name="a", shape=Cuboid(sides=(1.0, 2.0, 3.0))),
    Piece(name="b", shape=Cuboid(sides=(1.0, 1.0, 1.0))),
]
PROBLEM = Solid(SolidDocument(solids=PIECES))
HEADER = "solid,mass,x,y,z,xx,yy,zz,xy,xz,yz"
A = "a,6,0,0,0,6.5,5,2.5,0,0,-1.5D-3"
B = "b,1,,,,,,,,,"


def answer(folder: Path, *lines: str):  # type: ignore[no-untyped-def]
    path = folder / "trajectory.csv"
    path.write_text("".join(f"{line}\n" for line in lines))
    return read_answer(PROBLEM, path)


def test_cells_are_values_by_name_and_empty_ones_are_unsaid(tmp_path: Path) -> None:
    found = answer(tmp_path, HEADER, A, B)
    said = dict(zip(MASS_PROPERTIES, (6, 0, 0, 0, 6.5, 5, 2.5, 0, 0, -1.5e-3), strict=True))
    assert {name: values.tolist() for name, values in found.values.items()} == {
        f"a.{k}": [v] for k, v in said.items()
    } | {"b.mass": [1.0]}
    assert np.array_equal(found.t, PROBLEM.times)
    assert ",".join(SOLID_COLUMNS) == HEADER
    assert most_rows(PROBLEM) == 2


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ((), "line 1 is ''; expected solid,mass"),
        ((A, B), "line 1 is 'a,6"),
        ((HEADER.replace("xx", "ixx"), A, B), "expected solid,mass,x,y,z,xx"),
        ((HEADER, A), "has 1 rows; expected 2, one a solid"),
        ((HEADER, A, B, B), "has more rows; expected 2"),
        ((HEADER, B, A), "line 2 is of 'b'; expected 'a': the solids in the order"),
        ((HEADER, A, B[:-1]), "line 3 has 10 columns; expected 11"),
        (
            (HEADER, A, B.replace("1", "one")),
            "line 3: mass is 'one'; expected a finite number, or nothing",
        ),
        ((HEADER, A.replace("6.5", "nan"), B), "line 2: xx is 'nan'"),
        ((HEADER, A.replace("6.5", "inf"), B), "line 2: xx is 'inf'"),
        ((HEADER, "a,,,,,,,,,,", "b,,,,,,,,,,"), "has no value of any solid"),
    ],
)
def test_a_malformed_table_is_named(tmp_path: Path, lines: tuple[str, ...], says: str) -> None:
    with pytest.raises(EngineError, match=says):
        answer(tmp_path, *lines)


def test_a_missing_and_a_binary_file_are_named(tmp_path: Path) -> None:
    with pytest.raises(EngineError, match=r"wrote no nothing\.csv"):
        read_answer(PROBLEM, tmp_path / "nothing.csv")
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)) * 9)
    with pytest.raises(EngineError, match=r"binary\.csv"):
        read_answer(PROBLEM, tmp_path / "binary.csv")


def test_other_questions_do_not_travel() -> None:
    from refdem.core import discovery

    problem = discovery.case("logistic").at().problem
    assert isinstance(problem, Iteration)
    with pytest.raises(UsageError, match="cannot be sent to programs"):
        most_rows(problem)
