"""Every engine, whatever it is, says of every case that it runs it, or in a few words why not."""

import pytest

from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.selection import Selection

LONGEST = 300
"""Characters of a reason: it stands in a cell of a table."""
CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


@pytest.fixture(params=discovery.names("engines"))
def engine(request: pytest.FixtureRequest) -> Engine:
    """An engine that is installed, or not."""
    return discovery.engine(request.param)


def test_its_names_are_told_apart(engine: Engine) -> None:
    assert engine.title
    assert engine.licence
    methods = [method.name for method in engine.methods]
    assert methods
    assert len(set(methods)) == len(methods)
    assert all(method.summary for method in engine.methods)


def test_it_runs_a_case_at_its_defaults_or_says_why_not(engine: Engine) -> None:
    if engine.missing() is not None:
        assert engine.missing()
        return
    for case in CASES:
        problem = discovery.case(case).at().problem
        for method in engine.methods:
            reason = engine.unsupported(problem, method)
            if reason is not None:
                assert 0 < len(reason) <= LONGEST, f"{case}/{method.name}: {reason!r}"
                assert "\n" not in reason, f"{case}/{method.name}: {reason!r}"
