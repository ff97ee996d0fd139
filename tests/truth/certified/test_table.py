"""The store as CSV: every value, and the same numbers."""

import csv
import io
from fractions import Fraction

from refdem.truth import load
from refdem.truth.certified.table import HEADER, csv_of


def test_the_table_has_every_value_of_the_store_and_reads_back_exactly() -> None:
    sets = load("pendulum") + load("quaternions")
    rows = list(csv.DictReader(io.StringIO(csv_of(sets))))
    values = [(one.case, value) for one in sets for value in one.values]
    assert len(rows) == len(values) > 100
    assert tuple(rows[0]) == HEADER
    for row, (case, value) in zip(rows, values, strict=True):
        assert (row["case"], row["quantity"], row["mid"], row["radius"]) == (
            case,
            value.quantity,
            value.mid,
            value.radius,
        )
        assert (Fraction(row["t"]) if row["t"] else None) == value.t
        assert (float.fromhex(row["binary64"]) if row["binary64"] else None) == value.binary64


def test_the_command_prints_it_and_names_what_it_has_not(capsys) -> None:  # type: ignore[no-untyped-def]
    from typer.testing import CliRunner

    from refdem.cli.app import app

    runner = CliRunner()
    printed = runner.invoke(app, ["truth", "pendulum", "--csv"])
    assert printed.exit_code == 0
    assert printed.output.splitlines()[0] == ",".join(HEADER)
    refused = runner.invoke(app, ["truth", "pendulumm", "--csv"])
    assert refused.exit_code != 0
    assert "pendulum" in str(refused.exception)
