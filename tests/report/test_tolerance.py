"""The tolerance table against numbers counted by hand."""

import math

import pytest

from refdem.core.finding import Finding, Level, Record
from refdem.report.contents import contents_of, page
from refdem.report.numbers import decades, significant, two
from refdem.report.tolerance import WORST, cell, rows_of


def level(step, error, bound):
    return Level(level=step, error=error, bound=bound, seconds=step * 10, counts=True)


def finding(quantity, *levels, order=2.0):
    return Finding(
        check="error",
        quantity=quantity,
        outcome="pass",
        sentence="",
        value=0.0,
        bound=1.0,
        levels=levels,
        order_claimed=order,
        order_seen=order,
    )


def record(engine, method, *findings, label="a"):
    return Record(
        case="a",
        label=label,
        parameters={},
        engine=engine,
        version="1",
        method=method,
        is_reference=engine == "reference",
        runs=(),
        findings=findings,
    )


X = finding("x", level(0.4, 1e-2, 1e-1), level(0.2, 1e-3, 1e-2), level(0.1, 1e-7, 1e-5))
Y = finding("y", level(0.4, 2e-4, 1e-1), level(0.2, 5e-3, 1e-2), level(0.1, 3e-7, 1e-7))


def rows(*records, label="a"):
    return rows_of(contents_of(records), label)


def test_the_largest_step_that_holds_also_holds_at_every_finer_step():
    worst, x, y = rows(record("alpha", "verlet", X, Y))
    assert x.steps == ((0.2, False), (0.1, False), None)
    assert y.steps == (
        (0.1, False),
        (0.1, False),
        None,
    ), "the coarsest step holds 1e-3 by luck: the next does not"
    assert worst.quantity == WORST
    assert worst.steps == ((0.1, False), (0.1, False), None)


def test_the_coarsest_step_that_ran_is_marked_as_such():
    row = rows(record("alpha", "verlet", finding("x", level(0.4, 1e-4, 1), level(0.2, 1e-5, 1))))[0]
    assert row.steps == ((0.4, True), None, None)


def test_a_bound_is_held_at_the_level_where_the_error_is_under_it():
    worst, x, y = rows(record("alpha", "verlet", X, Y))
    assert (x.bound_held, y.bound_held, worst.bound_held) == (1e-5, 1e-2, 1e-2)


def test_no_bound_is_held_where_one_quantity_holds_none():
    worst = rows(record("alpha", "verlet", X, finding("y", level(0.4, 2.0, 1.0))))[0]
    assert worst.bound_held is None


def test_the_worst_of_all_has_the_largest_error_of_each_level():
    worst = rows(record("alpha", "verlet", X, Y))[0]
    assert [(x.level, x.error, x.bound) for x in worst.levels] == [
        (0.4, 1e-2, 1e-1),
        (0.2, 5e-3, 1e-2),
        (0.1, 3e-7, 1e-7),
    ]


def test_the_cost_is_that_of_the_largest_step_that_holds_one_in_a_million():
    assert rows(record("alpha", "verlet", X, Y))[0].seconds == pytest.approx(1.0)


def test_the_order_of_all_is_what_the_check_of_the_order_saw():
    order = Finding(
        check="order",
        quantity="state",
        outcome="pass",
        sentence="",
        order_seen=1.97,
        order_claimed=2.0,
    )
    assert rows(record("alpha", "verlet", X, order))[0].order_seen == 1.97
    assert rows(record("alpha", "verlet", X))[0].order_seen is None


def test_the_distance_between_engines_lies_between_difference_and_sum_of_their_errors():
    near = finding("x", level(0.1, 1e-9, 1))
    far = finding("x", level(0.1, 4e-3, 1))
    mine = rows(
        record("alpha", "rk4", finding("x", level(0.1, 1e-3, 1))),
        record("beta", "m", near),
        record("gamma", "m", far),
    )[0]
    assert mine.apart == ("gamma", pytest.approx(3e-3), pytest.approx(5e-3))


def test_a_method_without_order_is_exact_at_level_zero_and_else_controlled_by_a_tolerance():
    exact = record("alpha", "exact", finding("x", level(0.0, 1e-16, 1e-14), order=None))
    found = rows(exact, record("alpha", "bs", finding("x", level(1e-8, 1e-9, 1), order=None)))
    assert {row.record.method: row.control for row in found} == {
        "exact": "exact",
        "bs": "tolerance",
    }


def test_correct_digits_are_those_of_the_best_method_and_of_its_worst_quantity():
    records = [
        record("alpha", "verlet", X, Y),
        record("alpha", "euler", finding("x", level(0.1, 1e-2, 1))),
    ]
    found = cell(contents_of(records), rows(*records), "a", "alpha")
    assert found.method == "verlet"
    assert found.digits == pytest.approx(-math.log10(3e-7))


def test_an_error_of_exactly_zero_is_exact_and_an_engine_that_did_not_run_has_no_digits():
    records = [record("alpha", "m", finding("x", level(0.0, 0.0, 1e-14), order=None))]
    contents = contents_of(records)
    assert cell(contents, rows(*records), "a", "alpha").digits == math.inf
    assert cell(contents, rows(*records), "a", "beta").worst is None


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "\N{EN DASH}"),
        (0.0, "0"),
        (0.00123, "0.0012"),
        (1.24e-4, "1.2e-4"),
        (999.0, "1e3"),
        (120.0, "120"),
        (-0.5, "-0.5"),
        (3e-16, "3e-16"),
        (2.0, "2"),
    ],
)
def test_numbers_have_two_significant_digits(value, text):
    assert two(value) == text


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1.6265782, 5, "1.6266"),
        (0.4, 5, "0.4"),
        (101752.0, 6, "101752"),
        (101752.0, 3, "1.02e5"),
        (100000.0, 3, "1e5"),
        (160.177, 3, "160"),
        (5.09e-5, 6, "5.09e-5"),
        (None, 4, "\N{EN DASH}"),
    ],
)
def test_numbers_have_as_many_significant_digits_as_are_asked_for(value, digits, text):
    assert significant(value, digits) == text


def test_a_margin_has_its_sign():
    assert [decades(margin) for margin in (1.26, -2.0, math.inf)] == ["+1.3", "-2.0", "exact"]


def test_different_labels_have_different_pages_also_where_case_and_signs_do_not_count():
    labels = [
        "a[x=1,2]",
        "a[x=1.2]",
        "A[x=1.2]",
        "a[x=1 2]",
        "../../etc/passwd",
        "",
        "x" * 300,
        "a",
    ]
    names = [page(label) for label in labels]
    assert len({name.lower() for name in names}) == len(names)
    assert all(
        name and "/" not in name and not name.startswith(".") and len(name) < 100 for name in names
    )
    assert page("free-rigid-body") == "free-rigid-body"
