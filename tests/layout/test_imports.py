"""What `import refdem` costs and brings in, and that the floors are held."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
HEAVY = (
    "mujoco",
    "pymunk",
    "rebound",
    "altair",
    "vl_convert",
    "pandas",
    "jinja2",
    "numpy",
    "flint",
    "msgspec",
    "typer",
    "rich",
    "pebble",
    "distributed",
)


def modules(statement: str) -> set[str]:
    """Modules that a fresh interpreter has after a statement."""
    code = f"import sys; {statement}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd="/"
    )
    return set(done.stdout.split())


def loaded(statement: str) -> set[str]:
    """Top-level packages that a fresh interpreter has after a statement."""
    return {name.partition(".")[0] for name in modules(statement)}


def test_importing_refdem_brings_in_no_engine_no_plotting_and_no_tables() -> None:
    assert loaded("import refdem").isdisjoint(HEAVY)


def test_listing_the_catalogue_imports_no_engine_no_plotting_and_no_tables() -> None:
    statement = (
        "from refdem.core import discovery as d; [d.case(n) for n in d.names('cases')];"
        " [d.engine(n) for n in d.names('engines')]"
    )
    brought = loaded(statement)
    assert "numpy" in brought
    assert brought.isdisjoint(
        {"mujoco", "pymunk", "rebound", "altair", "vl_convert", "pandas", "jinja2", "flint"}
    )


def test_a_campaign_that_is_read_from_the_store_imports_nothing_that_proves_draws_or_runs() -> None:
    statement = (
        "from refdem.planning import campaign, moved;"
        " from refdem.report import is_up_to_date, resolution, unchanged"
    )
    brought = loaded(statement)
    assert "numpy" in brought
    assert brought.isdisjoint({"flint", "jinja2", "asyncio", "pebble", "distributed"})


def test_importing_refdem_reads_at_most_half_as_many_modules_as_numpy() -> None:
    """What an import costs is counted: a clock would tell how busy the machine is."""
    before = modules("pass")
    of_refdem = modules("import refdem") - before
    of_numpy = modules("import numpy") - before
    assert len(of_refdem) <= len(of_numpy) / 2
