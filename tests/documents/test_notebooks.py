"""Every notebook of docs/notebooks runs, and prints what is stored in it."""

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


def ran(notebook: dict[str, Any], name: str) -> list[tuple[str, str]]:
    """What each cell of code prints and what is stored of it, all in one namespace."""
    namespace: dict[str, Any] = {"__name__": "notebook"}
    found = []
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile("".join(cell["source"]), name, "exec"), namespace)
        stored = "".join("".join(output["text"]) for output in cell["outputs"])
        found.append((printed.getvalue(), stored))
    return found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_prints_what_is_stored_in_it(path: Path) -> None:
    cells = ran(json.loads(path.read_text()), path.name)
    assert cells
    for printed, stored in cells:
        assert printed == stored


def test_there_are_notebooks_and_a_stored_text_that_is_not_so_is_seen() -> None:
    assert len(NOTEBOOKS) >= 3
    cell = {"cell_type": "code", "source": ["print(1)"], "outputs": [{"text": ["2\n"]}]}
    assert ran({"cells": [cell]}, "made by hand") == [("1\n", "2\n")]
