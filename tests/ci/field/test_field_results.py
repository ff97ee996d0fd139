"""What is kept of the gate of a code is small, in one order, and read as it was written."""

import field_results
import pytest

from refdem.core.finding import Finding
from tests.ci.field.records import errors, record


def finding(check, quantity, outcome, sentence="", value=None):
    """A finding without levels."""
    return Finding(check=check, quantity=quantity, outcome=outcome, sentence=sentence, value=value)


def test_the_error_is_that_of_the_worst_quantity_at_the_finest_step():
    x = errors("x", (1e-2, 0.001), (1.234e-5, 0.002))
    y = errors("y", (1e-3, 0.001), (1e-6, 0.002))
    found = field_results.result(record(x, y))
    assert (found.error, found.quantity) == (1.2e-5, "x")


def test_the_time_is_that_of_the_largest_step_that_holds_the_accuracy():
    x = errors("x", (1e-2, 0.001), (1e-3, 0.0021), (1e-5, 0.004))
    y = errors("y", (1e-9, 0.001), (1e-9, 0.0021), (1e-9, 0.004))
    assert field_results.result(record(x, y)).seconds == 0.0021
    assert field_results.result(record(errors("x", (1e-2, 0.001)))).seconds is None


def test_a_law_is_kept_to_round_off_or_near_or_lost():
    kept = finding("momentum", "total", "pass", value=1e-15)
    near = finding("energy", "finest", "pass", value=1.26e-5)
    lost = finding("angular-momentum", "total", "expected", value=0.31)
    found = field_results.result(record(kept, near, lost)).laws
    assert found == {
        "momentum": field_results.Law("kept", 1e-15),
        "angular-momentum": field_results.Law("lost", 0.31),
        "energy": field_results.Law("approximate", 1.3e-5),
    }


@pytest.mark.parametrize(
    ("outcomes", "said"),
    [
        ((), "none"),
        (("unsupported",), "none"),
        (("undecided",), "undecided"),
        (("pass", "undecided"), "right"),
        (("pass", "fail"), "wrong"),
        (("pass", "expected"), "wrong"),
        (("error",), "wrong"),
    ],
)
def test_derivatives_are_right_if_one_finding_shows_it_and_none_the_contrary(outcomes, said):
    found = [finding("gradient", str(n), outcome) for n, outcome in enumerate(outcomes)]
    other = finding("momentum", "total", "fail")
    assert field_results.result(record(*found, other)).derivatives == said


@pytest.mark.parametrize(
    ("sentence", "words"),
    [
        (
            "The run at 0.1 ended without a trajectory (unsupported) (2 runs failed): no rods.",
            "no rods",
        ),
        ("Spring (not in `supports` of refdem.toml).", "Spring (not in `supports` of refdem.toml)"),
    ],
)
def test_a_refusal_is_kept_in_the_words_of_the_driver(sentence, words):
    refused = finding("run", "scene", "unsupported", sentence)
    assert field_results.result(record(refused)).refused == words
    judged = finding("momentum", "total", "pass", value=0.0)
    assert field_results.result(record(refused, judged)).refused == ""


def test_the_file_is_in_one_order_and_is_read_as_it_was_written(tmp_path):
    run = field_results.Run(code="ode", version="1", state="open", date="2026-11-29", methods={})
    records = [
        record(errors("x", (1e-2, 0.001)), label=label, method=method)
        for label, method in (("rolling", "a"), ("pendulum", "b"), ("pendulum", "a"))
    ]
    deviating = finding("rest", "speed", "expected", value=1.0)
    records.append(record(deviating, label="hard-wall"))
    kept = field_results.Kept(run, field_results.results(records))
    places = [(one.label, one.method) for one in kept.results]
    assert places == sorted(places)
    field_results.write(tmp_path / "ode.jsonl", kept)
    assert field_results.read(tmp_path / "ode.jsonl") == kept
    assert kept.results[0].deviations == ("rest/speed",)
    other = field_results.Kept(run, field_results.results(reversed(records)))
    field_results.write(tmp_path / "other.jsonl", other)
    assert (tmp_path / "other.jsonl").read_bytes() == (tmp_path / "ode.jsonl").read_bytes()
