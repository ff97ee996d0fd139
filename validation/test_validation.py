"""The campaign `main` as tests: one item per case, engine, method and check."""

import pytest

from refdem.pytest_plugin import by_check, campaign_records

ITEMS = by_check(campaign_records("main"))


@pytest.mark.parametrize("name", ITEMS)
def test_validation(name: str) -> None:
    findings = ITEMS[name]
    broken = [finding.sentence for finding in findings if finding.outcome in ("fail", "error", "stale")]
    assert not broken, "\n".join(broken)
    if all(finding.outcome in ("unsupported", "undecided") for finding in findings):
        pytest.skip("; ".join(finding.sentence for finding in findings))
