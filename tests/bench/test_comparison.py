"""Two records compared: noise is not a change, a factor is, and how often noise is taken for one is
counted.
"""

import os
import random
from pathlib import Path

import msgspec
import pytest

from refdem.bench.comparison import compared, compared_in_turns, false_alarm_rate, verdict
from refdem.bench.record import BenchRecord, Curve, Point, read
from refdem.errors import UsageError


def record(
    seed: int, *, factor: float = 1.0, machine: float = 1.0, rounds: int = 5, noise: float = 0.05
) -> BenchRecord:
    """A record of one method with three levels on a machine that is slower by `machine`, in code
    that is slower by `factor`.
    """
    chance = random.Random(seed)
    weather = [machine * chance.lognormvariate(0, 0.3) for _ in range(rounds)]
    points = [
        Point(
            level=h,
            error=h**2,
            rounds=[factor / h * day * chance.lognormvariate(0, noise) for day in weather],
        )
        for h in (0.1, 0.05, 0.025)
    ]
    curve = Curve(label="spring", engine="played", method="good", control="step", points=points)
    return BenchRecord(
        refdem="0",
        rounds=rounds,
        load=1.0,
        longest=1.0,
        most_steps=1e6,
        yardstick=weather,
        compared={"spring": ["x"]},
        curves=[curve],
    )


@pytest.mark.parametrize(
    ("factor", "expected"), [(1.0, "same"), (1.5, "slower"), (1 / 1.5, "faster"), (1.05, "same")]
)
def test_a_change_of_the_code_is_told_from_one_of_the_machine(factor: float, expected: str) -> None:
    found = [
        compared(record(2 * seed, factor=factor, machine=2.0), record(2 * seed + 1))[0]
        for seed in range(20)
    ]
    assert sum(change.verdict == expected for change in found) >= 19


def test_a_code_compared_with_itself_raises_few_false_alarms() -> None:
    alarms = [
        compared(record(2 * seed), record(2 * seed + 1))[0].verdict != "same" for seed in range(500)
    ]
    assert sum(alarms) <= 15  # two sides of 1 in 252 are 4 in 500


def in_turns(
    seed: int, *, factor: float = 1.0, rounds: int = 7, noise: float = 0.05
) -> BenchRecord:
    """The same record with another code, which is faster by `factor`, in every round under the same
    weather.
    """
    chance = random.Random(seed + 10**6)
    alone = record(seed, rounds=rounds, noise=noise)
    curve = alone.curves[0]
    points = [
        msgspec.structs.replace(
            p,
            beside=[
                day / p.level / factor * chance.lognormvariate(0, noise) for day in alone.yardstick
            ],
        )
        for p in curve.points
    ]
    return msgspec.structs.replace(alone, curves=[msgspec.structs.replace(curve, points=points)])


@pytest.mark.parametrize(
    ("factor", "expected"), [(1.0, "same"), (1.3, "slower"), (1 / 1.3, "faster"), (1.05, "same")]
)
def test_pairs_tell_a_change_whatever_the_weather(factor: float, expected: str) -> None:
    found = [compared_in_turns(in_turns(seed, factor=factor))[0].verdict for seed in range(20)]
    assert sum(verdict == expected for verdict in found) >= 19


def test_pairs_of_equal_codes_raise_few_false_alarms_even_where_noise_is_large() -> None:
    alarms = [
        compared_in_turns(in_turns(seed, noise=0.3))[0].verdict != "same" for seed in range(1000)
    ]
    assert (
        1 <= sum(alarms) <= 30
    )  # two sides of 1 in 128 are 16 in 1000; the noise is large enough for CHANGE to forbid none


def test_without_another_code_there_is_nothing_to_compare_in_turns() -> None:
    assert compared_in_turns(record(1)) == []


def test_the_false_alarm_rate_of_a_record_is_counted_over_all_splits() -> None:
    rate = false_alarm_rate(record(1, rounds=10, noise=0.2))
    assert rate is not None
    assert rate in (0.0, 1 / 252, 2 / 252)
    assert false_alarm_rate(record(1, rounds=5)) is None


def test_rounds_in_which_codes_differ_by_chance_alone_are_flagged_at_most_once_a_side() -> None:
    assert verdict([2.0, 2.1, 2.2, 2.3], [1.0, 1.1, 1.2, 1.3]) == "slower"
    assert verdict([2.0, 2.1, 2.2, 1.2], [1.0, 1.1, 1.2, 1.3]) == "same"
    assert verdict([2.0, 2.1, 2.2], [1.0, 1.1, 1.2]) == "same"


def test_only_levels_that_both_records_have_are_compared() -> None:
    now = record(1)
    then = record(1)
    curve = now.curves[0]
    slow = msgspec.structs.replace(curve.points[0], level=9.0, rounds=[100.0] * 5)
    now = msgspec.structs.replace(
        now, curves=[msgspec.structs.replace(curve, points=[slow, *curve.points[1:]])]
    )
    assert compared(now, then)[0].factor == pytest.approx(1.0)


def test_a_file_that_is_no_record_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bench.json"
    with pytest.raises(UsageError, match=r"No such file .* expected a bench\.json"):
        read(path)
    os.mkfifo(tmp_path / "pipe.json")
    with pytest.raises(UsageError, match=r"a pipe .* expected a bench\.json"):
        read(tmp_path / "pipe.json")
    path.write_text("{}")
    with pytest.raises(UsageError, match="not a record of a bench"):
        read(path)


def test_a_record_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "bench.json"
    written = record(3)
    path.write_bytes(msgspec.json.encode(written))
    assert read(path) == written
