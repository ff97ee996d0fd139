"""Killed at any moment, what is finished stays and is not run twice."""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing

from refdem.core.finding import CampaignSheet, Record
from refdem.core.store import Store
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification

SCRIPT = """
import sys
from pathlib import Path
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification
from refdem.core.store import Store
if __name__ == "__main__":
    case = [Entry("harmonic-oscillator")]
    specification = Specification(name="t", case=case, engines=["played"], method="good", levels=8)
    Campaign(specification, Store(Path(sys.argv[1])), jobs=1).sheets()
"""


def stored_runs(path):
    if not path.exists():
        return 0
    with closing(sqlite3.connect(path)) as connection:
        try:
            return connection.execute("SELECT count(*) FROM entries WHERE kind='run'").fetchone()[0]
        except sqlite3.OperationalError:
            return 0


def test_a_killed_campaign_goes_on_where_it_was(played, tmp_path):
    store = tmp_path / "store.sqlite"
    script = tmp_path / "campaign.py"
    script.write_text(SCRIPT)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    process = subprocess.Popen(
        [sys.executable, str(script), str(store)], env=environment, start_new_session=True
    )
    deadline = time.monotonic() + 600
    while stored_runs(store) < 3 and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = stored_runs(store)
    assert kept >= 3
    specification = Specification(
        name="t", case=[Entry("harmonic-oscillator")], engines=["played"], method="good", levels=8
    )
    sheets = Campaign(specification, Store(store), jobs=2).sheets()
    whole = next(s for s in sheets if isinstance(s, CampaignSheet))
    (record,) = (s for s in sheets if isinstance(s, Record))
    assert whole.runs_read >= kept
    assert {finding.outcome for finding in record.findings} == {"pass"}
