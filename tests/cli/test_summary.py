"""What a run prints at its end: counts, and why engines refused a part."""

from refdem.cli.summary import MAX_REASONS, lines, refused
from refdem.core.finding import Finding, Outcome, Record


def record(method: str, outcome: Outcome, sentence: str, case: str = "a") -> Record:
    """A record of engine e with one finding."""
    finding = Finding(check="error", quantity="x", outcome=outcome, sentence=sentence)
    return Record(
        case=case,
        label=case,
        parameters={},
        engine="e",
        version="1",
        method=method,
        is_reference=False,
        runs=(),
        findings=(finding,),
    )


def test_the_methods_that_refuse_are_told_once_a_reason_beneath_the_counts():
    sheets = [
        record("good", "pass", "Holds."),
        record("one", "unsupported", "No rods."),
        record("two", "unsupported", "No rods."),
        record("two", "unsupported", "No rods.", case="b"),
        record("three", "unsupported", "No walls."),
    ]
    assert lines(sheets)[-3:] == [
        "4 unsupported, 1 pass",
        "3 unsupported in e (one, two; a, b): No rods.",
        "1 unsupported in e (three; a): No walls.",
    ]


def test_an_engine_that_judged_nothing_has_its_reasons_above_the_counts_alone():
    sheets = [record("one", "unsupported", "No rods.")]
    assert refused(sheets) == []
    assert lines(sheets)[0] == "a/e (one): No rods."


def test_of_many_reasons_the_most_frequent_are_told_and_the_others_counted():
    sheets = [record("good", "pass", "Holds.")]
    for number in range(MAX_REASONS + 2):
        for repeat in range(number + 1):
            sheets.append(record(f"m{repeat}", "unsupported", f"Reason {number}."))
    told = refused(sheets)
    assert len(told) == MAX_REASONS + 1
    assert told[0].endswith(
        f"(m0, m1, m2, m3 and {MAX_REASONS - 2} more; a): Reason {MAX_REASONS + 1}."
    )
    assert told[-1] == "... and 2 more reasons for refusals; the report lists all"
    assert len(refused(sheets, most=None)) == MAX_REASONS + 2
