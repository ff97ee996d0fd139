"""The script of the pages is the same in every report, and is made once on a machine."""

from pathlib import Path

import pytest

from refdem.core.store import Store
from refdem.report import figures


def test_the_script_is_made_once_for_all_stores(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []

    def bundle() -> bytes:
        made.append("")
        return b"a script"

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(figures, "_bundle", bundle)
    for name in ("one", "two"):
        figures._script.cache_clear()
        store = Store(tmp_path / f"{name}.sqlite")
        assert figures.script(store) == b"a script"
        store.close()
    figures._script.cache_clear()
    assert len(made) == 1


def test_a_report_without_a_store_has_its_script() -> None:
    script = figures.script(None)
    assert b"vegaEmbed" in script
    assert figures.script(None) == script
