"""The CSV reader: numbers come back to the last bit, and nothing that a program writes is worse
than one clear error.
"""

import tracemalloc
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refdem.core.trajectory import Trajectory
from refdem.core.trajectory_csv import COLUMNS, LONGEST_ROW, read_trajectory
from refdem.errors import EngineError, RefdemError

HEADER = ",".join(COLUMNS)


def read(
    folder: Path, text: str | bytes, samples: int = 2, bodies: int = 2, events: str | None = None
) -> Trajectory:
    """The trajectory that a file of this text is."""
    path = folder / "trajectory.csv"
    beside = folder / "events.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    beside.unlink(missing_ok=True)
    if events is not None:
        beside.write_text(events)
    return read_trajectory(path, samples, bodies, beside)


def row(t: object, body: object, *rest: object) -> str:
    return ",".join(map(str, (t, body, *(rest or (0,) * 6 + ("",) * 7))))


def table(*rows: str, header: str = HEADER) -> str:
    return "\n".join([header, *rows]) + "\n"


PLAIN = [row(0, 0), row(0, 1), row(0.5, 0), row(0.5, 1)]


def test_numbers_come_back_to_the_last_bit(tmp_path: Path) -> None:
    numbers = np.random.default_rng(1).standard_normal((2, 2, 13)) * 10.0 ** np.arange(-6, 7)
    rows = [
        row(t, b, *(f"{x:.17g}" for x in numbers[n, b]))
        for n, t in enumerate((0, 0.5))
        for b in (0, 1)
    ]
    run = read(tmp_path, table(*rows))
    assert run.t.tolist() == [0.0, 0.5]
    seen = np.concatenate([run.position, run.velocity, run.attitude, run.omega], axis=-1)
    assert np.array_equal(seen, numbers)


def test_points_have_empty_attitudes_beside_bodies_that_turn(tmp_path: Path) -> None:
    turning = row(0, 1, *range(6), 0, 1, 0, 0, 7, 8, 9)
    run = read(
        tmp_path, table(row(0, 0), turning, row(0.5, 0), turning.replace("0,1,", "0.5,1,", 1))
    )
    assert run.attitude[0].tolist() == [[1, 0, 0, 0], [0, 1, 0, 0]]
    assert run.omega[1].tolist() == [[0, 0, 0], [7, 8, 9]]


def test_fortran_exponents_blanks_carriage_returns_and_empty_lines_are_read(tmp_path: Path) -> None:
    text = table(*PLAIN).replace("0.5,", " 5.0D-01 ,").replace("\n", "\r\n\r\n")
    assert read(tmp_path, text).t.tolist() == [0.0, 0.5]


def test_channels_have_a_column_for_each_row_that_is_not_empty(tmp_path: Path) -> None:
    header = f"{HEADER},dissipated_work,overlap"
    rows = [
        f"{line},{work},{overlap}"
        for line, work, overlap in zip(PLAIN, ("1", "", "2", ""), "3456", strict=True)
    ]
    run = read(tmp_path, table(*rows, header=header))
    assert run.channels["dissipated_work"].tolist() == [[1], [2]]
    assert run.channels["overlap"].tolist() == [[3, 4], [5, 6]]


def test_events_are_read_from_beside(tmp_path: Path) -> None:
    (event,) = read(tmp_path, table(*PLAIN), events="time,kind,body\n0.25,stop,1\n").events
    assert (event.time, event.kind, event.body) == (0.25, "stop", 1)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (PLAIN[:3], "has 3 rows; expected 4: 2 samples of 2 bodies"),
        ([*PLAIN, *PLAIN], "has more rows; expected 4"),
        ([], "has 0 rows"),
        ([PLAIN[1], PLAIN[0], *PLAIN[2:]], "row 1 is body 1 at t = 0; expected body 0 at t = 0"),
        ([PLAIN[0], row(0.1, 1), *PLAIN[2:]], r"row 2 is body 1 at t = 0\.1"),
        (
            [row(0, 0, 1, 2, "inf", 0, 0, 0, *[""] * 7), *PLAIN[1:]],
            "line 2: z is 'inf'; expected a finite number",
        ),
        ([row(0, 0, 1, 2, "NaN", 0, 0, 0, *[""] * 7), *PLAIN[1:]], "line 2: z is 'NaN'"),
        ([row(0, 0, 1, 2, "", 0, 0, 0, *[""] * 7), *PLAIN[1:]], "line 2: z is ''"),
        ([row(0, 0, *[0] * 6, 1, "", "", "", "", "", ""), *PLAIN[1:]], "line 2: qx is ''"),
        ([PLAIN[0][:-1], *PLAIN[1:]], "line 2 has 14 columns; expected 15"),
        ([PLAIN[0] + ",1", *PLAIN[1:]], "line 2 has 16 columns"),
    ],
)
def test_a_wrong_row_is_named(tmp_path: Path, rows: list[str], says: str) -> None:
    with pytest.raises(EngineError, match=says):
        read(tmp_path, table(*rows))


@pytest.mark.parametrize(
    "header",
    ["", "a,b", HEADER.replace("vx", "ux"), HEADER + ",temperature", HEADER + ",overlap,overlap"],
)
def test_another_header_is_refused(tmp_path: Path, header: str) -> None:
    with pytest.raises(EngineError, match=r"trajectory\.csv line 1"):
        read(tmp_path, table(*PLAIN, header=header))


def test_a_channel_that_comes_and_goes_is_refused(tmp_path: Path) -> None:
    rows = [f"{line},{work}" for line, work in zip(PLAIN, ("1", "", "", "2"), strict=True)]
    with pytest.raises(EngineError, match="dissipated_work is empty in some samples"):
        read(tmp_path, table(*rows, header=f"{HEADER},dissipated_work"))


@pytest.mark.parametrize(
    "events",
    [
        "",
        "time,kind\n",
        "time,kind,body\nnan,stop,0\n",
        "time,kind,body\n1,stop,2\n",
        "time,kind,body\n1,stop\n",
        "\n",
    ],
)
def test_wrong_events_are_refused(tmp_path: Path, events: str) -> None:
    with pytest.raises(EngineError, match=r"events\.csv line"):
        read(tmp_path, table(*PLAIN), events=events)


@pytest.mark.parametrize(
    ("begin", "repeated"),
    [
        (HEADER, ",x"),
        (HEADER + "\n", "0,"),
        (HEADER + "\n", '"\n1",'),
        (HEADER + "\n", "\n"),
        ("", "\r"),
    ],
)
def test_a_file_of_cells_or_lines_without_end_takes_little_memory_and_is_refused(
    tmp_path: Path, begin: str, repeated: str
) -> None:
    text = begin + repeated * (40 * LONGEST_ROW // len(repeated))
    (tmp_path / "trajectory.csv").write_text(text, newline="")
    tracemalloc.start()
    with pytest.raises(EngineError, match=r"cannot be read as CSV: (a row of )?more than"):
        read_trajectory(tmp_path / "trajectory.csv", 2, 2)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # The cells of a row take 15 times its text; those of the whole file took 600 times this.
    assert peak < 20 * LONGEST_ROW


def test_a_trajectory_is_read_in_little_more_memory_than_its_numbers(tmp_path: Path) -> None:
    number = "0.12345678901234567"
    samples = 5000
    rows = [row(n, 0, *[number] * 6, 1, 0, 0, 0, *[number] * 3) for n in range(samples)]
    text = table(*rows)
    (tmp_path / "trajectory.csv").write_text(text)
    tracemalloc.start()
    read_trajectory(tmp_path / "trajectory.csv", samples, 1)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5 * len(text)


def test_a_folder_in_place_of_the_file_is_no_trajectory(tmp_path: Path) -> None:
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(EngineError, match="a folder; expected a plain file"):
        read_trajectory(tmp_path / "a.csv", 2, 2)


CELLS = st.sampled_from(
    [
        "0",
        "1",
        "-1e3",
        "",
        "nan",
        "inf",
        "1e999",
        "0x1p3",
        '"',
        "a",
        "\0",
        "1_0",
        "٣",
        " 2 ",
        "1.5D+00",
        "\r",
    ]
)


@given(st.binary(max_size=400))
@settings(max_examples=200)
def test_no_bytes_are_worse_than_an_error(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    _held(tmp_path_factory.getbasetemp(), data)


@given(st.lists(st.lists(CELLS, min_size=13, max_size=16), min_size=3, max_size=5))
@settings(max_examples=300)
def test_no_cells_are_worse_than_an_error(
    tmp_path_factory: pytest.TempPathFactory, cells: list[list[str]]
) -> None:
    _held(tmp_path_factory.getbasetemp(), table(*(",".join(line) for line in cells)).encode())


def _held(folder: Path, data: bytes) -> None:
    """What is read is finite; all else is an error of refdem's own."""
    for events in (None, data.decode(errors="replace")):
        with suppress(RefdemError):
            assert np.isfinite(read(folder, data, events=events).position).all()
