"""The campaign `main` as tests: one item per case, engine, method and check."""

import pytest

from refdem.pytest_plugin import by_check, campaign_records, decide

ITEMS = by_check(campaign_records("main"))


@pytest.mark.parametrize("name", ITEMS)
def test_validation(name: str) -> None:
    decide(ITEMS[name])
