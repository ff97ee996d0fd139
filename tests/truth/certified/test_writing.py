"""A line of the store contains the ball that it was made of, and claims a double only where both
ends round to it.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from random import Random

import pytest

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.certified.reader import Value, sets_of
from refdem.truth.certified.writing import block, file_text, row, rows, sums


def value_of(ball: Ball) -> Value:
    t, name, mid, radius, binary64 = row(None, "x", ball)
    return Value(
        t if t is None else Fraction(t),
        name,
        mid,
        radius,
        None if binary64 is None else float.fromhex(binary64),
    )


def test_the_decimal_interval_contains_the_ball() -> None:
    random = Random(1)
    for _ in range(200):
        mid = Fraction(random.randint(-(10**50), 10**50), 10 ** random.randint(30, 55))
        radius = Fraction(random.randint(0, 10**5), 10 ** random.randint(36, 60))
        low, high = value_of(Ball(mid, radius)).interval
        assert low <= mid - radius
        assert mid + radius <= high
        assert high - low < 2 * radius + Fraction(1, 10**33)


def test_a_value_between_two_doubles_claims_neither() -> None:
    between = Fraction(1) + Fraction(1, 2**53)
    assert value_of(Ball(between, Fraction(1, 10**40))).binary64 is None
    assert (
        value_of(Ball(between + Fraction(1, 10**30), Fraction(1, 10**40))).binary64 == 1 + 2.0**-52
    )
    assert value_of(Ball(between - Fraction(1, 10**30), Fraction(1, 10**40))).binary64 == 1.0


def test_exact_values_are_short() -> None:
    assert row(Fraction(1, 3), "x", Ball(Fraction(-5, 4), Fraction(0))) == (
        "1/3",
        "x",
        "-1.25",
        "0",
        "-0x1.4000000000000p+0",
    )
    assert row(None, "n", Ball(Fraction(0), Fraction(0)))[2:] == ("0", "0", "0x0.0p+0")


class Fading(Truth):
    """Certified before t = 2, too wide at t = 1."""

    method = "made up"
    witness = "none"

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        if t >= 2:
            raise NotCertifiedError("grazing at t = 2")
        return {"x": Ball(t, Fraction(1, 10**20) if t == 1 else Fraction(0))}

    def sensitivity(self, t: Fraction) -> float:
        return 1.0


def lines(times: Sequence[int]) -> list[str]:
    found, missing = rows(Fading(), [Fraction(t) for t in times])
    return block(
        "made-up",
        {"a": "1/2"},
        Fading(),
        found,
        source="s",
        job="j",
        witnessed=None,
        not_certified=missing,
    )


def test_what_cannot_be_certified_is_left_out_and_said() -> None:
    (found,) = sets_of(file_text("made-up", [lines([0, 1, 3])]), "made-up.jsonl")
    assert [value.t for value in found.values] == [0]
    assert found.not_certified == {"1": "radius of x above 1e-30", "3": "grazing at t = 2"}
    assert found.parameters == {"a": "1/2"}


def test_the_list_of_files_is_what_sha256sum_reads() -> None:
    assert (
        sums({"b": "", "a": ""}).splitlines()[0]
        == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  a"
    )


def test_two_texts_of_one_set_are_equal() -> None:
    assert lines([0]) == lines([0])
    with pytest.raises(ValueError, match="sha256"):
        list(
            sets_of(
                file_text("made-up", [lines([0])]).replace('"a":"1/2"', '"a":"1/3"'),
                "made-up.jsonl",
            )
        )
