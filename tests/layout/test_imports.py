"""What `import refdem` costs and brings in, and that the floors are held."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
HEAVY = ("mujoco", "pymunk", "rebound", "altair", "vl_convert", "pandas", "jinja2", "numpy", "flint", "msgspec", "typer", "rich", "pebble")
REPEATS = 11


def seconds(module: str) -> float:
    """Time that a fresh interpreter takes to import a module."""
    code = f"import time; start = time.perf_counter(); import {module}; print(time.perf_counter() - start)"
    return float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd="/").stdout)


def loaded(statement: str) -> set[str]:
    """Top-level packages that a fresh interpreter has after a statement."""
    code = f"import sys; {statement}; print(*{{name.partition('.')[0] for name in sys.modules}})"
    return set(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd="/").stdout.split())


def test_importing_refdem_brings_in_no_engine_no_plotting_and_no_tables() -> None:
    assert loaded("import refdem").isdisjoint(HEAVY)


def test_listing_the_catalogue_imports_no_engine_no_plotting_and_no_tables() -> None:
    statement = "from refdem.core import discovery as d; [d.case(n) for n in d.names('cases')]; [d.engine(n) for n in d.names('engines')]"
    brought = loaded(statement)
    assert "numpy" in brought
    assert brought.isdisjoint({"mujoco", "pymunk", "rebound", "altair", "vl_convert", "pandas", "jinja2", "flint"})


def test_importing_refdem_costs_at_most_half_more_than_numpy() -> None:
    """Minima of interleaved repeats: noise only ever adds time."""
    pairs = [(seconds("numpy"), seconds("refdem")) for _ in range(REPEATS)]
    numpy, refdem = (min(times) for times in zip(*pairs, strict=True))
    assert refdem <= 1.5 * numpy
