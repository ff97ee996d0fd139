"""The store that comes with refdem: whole, wide enough, small, and proved with the code as it
is.
"""

import json
from fractions import Fraction

from jsonschema import Draft202012Validator

from refdem.certification.listing import certified_cases
from refdem.certification.proofs import stale
from refdem.certification.reproof import damaged
from refdem.planning.kept_truth import truth_folder
from refdem.truth import load
from refdem.truth.certified.samples import kept

FOLDER = truth_folder()


def test_every_hash_and_every_claim_holds() -> None:
    assert damaged(FOLDER) == []


def test_it_has_what_was_promised() -> None:
    sets = load()
    values = [value for one in sets for value in one.values]
    assert len(sets) >= 100
    assert len(values) >= 3000
    assert max(Fraction(value.radius) for value in values) <= Fraction(1, 10**30)


def test_every_case_has_sets_and_a_witness() -> None:
    found = certified_cases(FOLDER)
    assert [one.case for one in found if not one.sets] == [], (
        "add sets to validation/truth/sets.toml and run `make certify`"
    )
    assert [one.case for one in found if one.has_no_witness] == []


def test_nothing_is_stale() -> None:
    assert stale(FOLDER) == [], "run `make certify`"


def test_a_value_takes_about_a_hundred_bytes() -> None:
    size = sum(path.stat().st_size for path in (FOLDER / "certified").iterdir())
    assert size < 130 * sum(len(one.values) for one in load())


def test_every_line_is_what_the_schema_says() -> None:
    """And a line that is not is seen."""
    check = Draft202012Validator(json.loads((FOLDER / "schema.json").read_text()))
    for path in (FOLDER / "certified").glob("*.jsonl"):
        for line in path.read_text().splitlines():
            assert check.is_valid(json.loads(line)), f"{path.name}: {line}"
    assert not check.is_valid([None, "x", "1.0", "1e-30", None])
    assert not check.is_valid(["0.5", "x", "1.0", "1.00e-30", None])
    assert not check.is_valid({"format": 2, "case": "x", "sets": 1})


def test_samples_are_those_of_their_hashes() -> None:
    for path in (FOLDER / "samples").glob("*.jsonl"):
        for entry in kept(path.parent, path.stem):
            assert len(entry.truth.sensitivity) == entry.truth.until
