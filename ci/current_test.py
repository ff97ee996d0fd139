"""For pytest: the name of the test that runs now is kept in a file, so that a crash has a name.

`pytest -p current_test`, with the file named in REFDEM_CURRENT_TEST.
"""

import os
from pathlib import Path


def pytest_runtest_logstart(nodeid: str) -> None:
    """Writes the name of the test that begins."""
    Path(os.environ["REFDEM_CURRENT_TEST"]).write_text(nodeid)
