"""For pytest: the name of the test that runs now is kept in a file, and a test that hangs ends its
process.

`pytest -p current_test`, with the file named in REFDEM_CURRENT_TEST. REFDEM_SECONDS is a file of
JSON with the time [s] of tests; a test may take SLOWER times as much of the processor, which no
other process on the machine changes. Other tests have no limit.
"""

import json
import os
import signal
from pathlib import Path

SLOWER = 10.0
"""How much longer than it took a test may take."""
LEAST = 10.0
"""[s] that any test may take."""

_file = os.environ.get("REFDEM_SECONDS")
_seconds: dict[str, float] = json.loads(Path(_file).read_text()) if _file else {}


def pytest_runtest_logstart(nodeid: str) -> None:
    """Writes the name of the test that begins, and sets its limit: at its end the system ends the
    process.
    """
    Path(os.environ["REFDEM_CURRENT_TEST"]).write_text(nodeid)
    if nodeid in _seconds:
        signal.setitimer(signal.ITIMER_PROF, LEAST + SLOWER * _seconds[nodeid])


def pytest_runtest_logfinish() -> None:
    """Between tests there is no limit."""
    signal.setitimer(signal.ITIMER_PROF, 0.0)
