"""The campaigns `main` and `shipped` as tests: one item per case, engine, method and check."""

import pytest

from refdem.pytest_plugin import by_check, campaign_records, decide

CAMPAIGNS = ("main", "shipped")
ITEMS = {
    name: found
    for campaign in CAMPAIGNS
    for name, found in by_check(campaign_records(campaign)).items()
}


def test_the_campaign_judges_something() -> None:
    assert ITEMS


@pytest.mark.parametrize("name", ITEMS)
def test_validation(name: str) -> None:
    decide(ITEMS[name])
