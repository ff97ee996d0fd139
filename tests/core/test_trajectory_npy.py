"""The NumPy reader: the trajectory is that of CSV; no file of a program is worse than an error."""

import struct
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.answer_csv import read_answer
from refdem.core.trajectory import Trajectory
from refdem.core.trajectory_csv import COLUMNS, read_trajectory
from refdem.core.trajectory_npy import read_table
from refdem.errors import EngineError

SAMPLES = 3
BODIES = 2


def rows() -> "np.ndarray[tuple[int, ...], np.dtype[np.float64]]":
    """Rows of two bodies at three samples."""
    table = np.random.default_rng(1).standard_normal((SAMPLES * BODIES, len(COLUMNS)))
    table[:, 0] = np.repeat(np.arange(SAMPLES) / 4, BODIES)
    table[:, 1] = np.tile(np.arange(BODIES), SAMPLES)
    return table


def read(folder: Path, array: object) -> Trajectory:
    """The trajectory that a file with this array is."""
    path = folder / "trajectory.npy"
    np.save(path, array, allow_pickle=True)  # type: ignore[arg-type]
    return read_table(path, SAMPLES, BODIES)


def of_csv(folder: Path, header: str, lines: list[str]) -> Trajectory:
    """The trajectory of a CSV file."""
    path = folder / "trajectory.csv"
    path.write_text("\n".join([header, *lines]) + "\n")
    return read_trajectory(path, SAMPLES, BODIES)


@pytest.mark.parametrize("order", ["C", "F"])
def test_an_array_is_the_trajectory_that_its_text_is(tmp_path: Path, order: str) -> None:
    table = np.array(rows(), order=order)  # type: ignore[call-overload]
    lines = [",".join(f"{number:.17g}" for number in row) for row in table]
    expected = of_csv(tmp_path, ",".join(COLUMNS), lines)
    assert read(tmp_path, table).to_bytes() == expected.to_bytes()


def test_names_bring_channels_and_nan_is_what_is_empty(tmp_path: Path) -> None:
    table = np.column_stack([rows(), np.tile([1.5, np.nan], SAMPLES)])
    table[:, 8:15] = np.nan
    names = [*COLUMNS, "rod_force"]
    named = np.zeros(len(table), dtype=[(name, "<f8") for name in names])
    for number, name in enumerate(names):
        named[name] = table[:, number]
    lines = [
        ",".join("" if np.isnan(number) else f"{number:.17g}" for number in row) for row in table
    ]
    expected = of_csv(tmp_path, ",".join(names), lines)
    found = read(tmp_path, named)
    assert found.to_bytes() == expected.to_bytes()
    assert found.channels["rod_force"].shape == (SAMPLES, 1)


def changed(row: int, column: int, value: float) -> object:
    """Rows with one other number."""
    table = rows()
    table[row, column] = value
    return table


@pytest.mark.parametrize(
    ("array", "says"),
    [
        (rows()[:-1], "has 5 rows; expected 6"),
        (rows().astype("<f4"), "float32 of shape .*; expected float64 of shape"),
        (rows().astype(">f8"), "expected float64 of shape"),
        (rows()[:, :-1], r"shape \(6, 14\); expected float64"),
        (rows().tolist()[0], r"shape \(15,\); expected float64"),
        (np.array([{"a": print}]), "object of shape"),
        (np.zeros(6, dtype=[("t", "<f8"), ("system", "<f8")]), "line 1 is 't,system'"),
        (np.zeros(6, dtype=[("t", "<f8", (15,))]), "expected float64"),
        (changed(3, 4, np.nan), "row 4: z is nan; expected a finite number"),
        (changed(3, 4, np.inf), "row 4: z is inf; expected a finite number"),
        (changed(2, 9, np.nan), "row 3: qx is nan; expected a finite number"),
        (changed(1, 1, 0), "row 2 is body 0"),
        (changed(1, 0, 7), "row 2 is body 1 at t = 7"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, array: object, says: str) -> None:
    with pytest.raises(EngineError, match=says):
        read(tmp_path, array)


def test_an_infinite_channel_is_named(tmp_path: Path) -> None:
    named = np.zeros(6, dtype=[(name, "<f8") for name in (*COLUMNS, "rod_force")])
    for number, name in enumerate(COLUMNS):
        named[name] = rows()[:, number]
    named["rod_force"][2] = -np.inf
    with pytest.raises(EngineError, match="row 3: rod_force is infinite"):
        read(tmp_path, named)


def header(text: str) -> bytes:
    """A file that begins as one of NumPy's."""
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


HUGE = "{'descr': '<f8', 'fortran_order': False, 'shape': (6, 15), }\n"


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "is no array in NumPy's format"),
        (b"t,body,x\n0,0,1\n", "is no array in NumPy's format"),
        (b"\x93NUMPY\x09\x00\x00", "is no array in NumPy's format"),
        (header("{" * 9000), "is no array in NumPy's format"),
        (header("__import__('os').abort()"), "is no array in NumPy's format"),
        (header("{'descr': '<f8', 'fortran_order': 3, 'shape': 4}\n"), "is no array"),
        (header(HUGE.replace("6, 15", "-6, 15")) + bytes(8), "has -6 rows"),
        (header(HUGE) + bytes(8), "has 8 bytes after its header; expected 720"),
        (header(HUGE) + bytes(721), "has 721 bytes after its header; expected 720"),
    ],
)
def test_no_bytes_are_worse_than_an_error(tmp_path: Path, data: bytes, says: str) -> None:
    path = tmp_path / "trajectory.npy"
    path.write_bytes(data)
    with pytest.raises(EngineError, match=says):
        read_table(path, SAMPLES, BODIES)


def test_a_link_and_two_answers_are_refused(tmp_path: Path) -> None:
    problem = discovery.case("harmonic-oscillator").at(samples="2").problem
    (tmp_path / "trajectory.npy").symlink_to(tmp_path / "other.npy")
    with pytest.raises(EngineError, match="plain file"):
        read_answer(problem, tmp_path / "trajectory.csv")
    (tmp_path / "trajectory.csv").write_text("")
    with pytest.raises(EngineError, match=r"trajectory\.csv and trajectory\.npy; expected one"):
        read_answer(problem, tmp_path / "trajectory.csv")
