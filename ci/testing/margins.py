"""A pytest plugin that writes how close every comparison with a small tolerance came to it: `-p
margins`, with ci/testing on PYTHONPATH.

It rewrites each `a < b` of a test, a fixture or a helper that pytest loads, and each comparison
with `pytest.approx`, and watches the comparisons of numpy and math. A line of JSON for each place
goes to the file named by REFDEM_MARGINS: where, the largest part of its tolerance that was used,
that tolerance, and what was measured there. Tolerances of `LARGEST` and above are not about
rounding.
"""

import ast
import json
import math
import operator
import os
import sys
from pathlib import Path
from typing import Any

import _pytest.assertion.rewrite as rewrite
import numpy as np
from numpy.typing import ArrayLike

LARGEST = 1e-6
"""Relative tolerances from here on are no claims about round-off, and are not measured."""
NAME = "__refdem_margin__"
SHAPES = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
}
places: dict[str, dict[str, float]] = {}


def _note(place: str, used: float, tolerance: float, measured: float) -> None:
    """Keeps the comparison that used the largest part of its tolerance, of each place."""
    known = places.get(place)
    if known is None or used > known["used"]:
        places[place] = {"used": used, "tolerance": tolerance, "measured": measured}


def _number(value: Any) -> np.ndarray | None:
    """The value as an array of binary64, or None if it is no finite number."""
    if isinstance(value, bool) or not isinstance(value, float | int | np.floating | np.ndarray):
        return None
    try:
        array = np.asarray(value)
        array = array.astype(complex if array.dtype.kind == "c" else float)
    except (TypeError, ValueError, OverflowError):
        return None
    if array.size and np.isfinite(array).all():
        return array
    return None


def _below(place: str, small: Any, large: Any) -> None:
    """Notes `small < large`: an error below its bound, or a bound below an effect that must be
    seen.
    """
    low = _number(small)
    high = _number(large)
    if low is None or high is None or low.dtype.kind == "c" or high.dtype.kind == "c":
        return
    try:
        low, high = np.broadcast_arrays(low, high)
    except ValueError:
        return
    is_small = (high > 0) & (np.minimum(np.abs(low), high) < LARGEST) & (low < high) & (low > 0)
    if not is_small.any():
        return
    used = np.where(is_small, low / np.where(is_small, high, 1.0), 0.0)
    worst = int(np.argmax(used))
    _note(place, float(used.flat[worst]), float(high.flat[worst]), float(low.flat[worst]))


def _close(place: str, actual: Any, expected: Any, relative: float, absolute: float) -> None:
    """Notes |actual - expected| against absolute + relative |expected|."""
    found = _number(actual)
    wanted = _number(expected)
    if found is None or wanted is None:
        return
    try:
        found, wanted = np.broadcast_arrays(found, wanted)
    except ValueError:
        return
    tolerance = absolute + relative * np.abs(wanted)
    if relative >= LARGEST or not (tolerance > 0).any():
        return
    off = np.abs(found - wanted)
    used = np.where(
        (tolerance > 0) & (off <= tolerance), off / np.where(tolerance > 0, tolerance, 1.0), 0.0
    )
    worst = int(np.argmax(used))
    if used.flat[worst] > 0 and tolerance.flat[worst] < LARGEST * max(
        1.0, float(np.abs(wanted.flat[worst]))
    ):
        _note(place, float(used.flat[worst]), float(tolerance.flat[worst]), float(off.flat[worst]))


def _approx(place: str, actual: Any, wanted: Any) -> None:
    """Notes a comparison with pytest.approx; its tolerance is the larger of the two."""
    expected = wanted.expected
    if wanted.rel is None:
        relative = 1e-6
    else:
        relative = wanted.rel
    if wanted.abs is None:
        absolute = 1e-12
    else:
        absolute = wanted.abs
    if wanted.abs is not None and wanted.rel is None:
        relative = 0.0
    if isinstance(expected, dict):
        for name, value in expected.items():
            _close(place, actual.get(name), value, float(relative), float(absolute))
        return
    _close(place, actual, expected, float(relative), float(absolute))


def compared(place: str, shape: str, left: Any, right: Any) -> Any:
    """What `left <shape> right` is, noted."""
    for actual, wanted in ((left, right), (right, left)):
        if type(wanted).__name__.startswith("Approx") and shape == "Eq":
            _approx(place, actual, wanted)
    if shape in ("Lt", "LtE"):
        _below(place, left, right)
    elif shape in ("Gt", "GtE"):
        _below(place, right, left)
    return SHAPES[getattr(ast, shape)](left, right)


class _Noted(ast.NodeTransformer):
    """Every comparison of two as a call of `compared`."""

    def __init__(self, path: str) -> None:
        self.path = path

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        """A chain `a < b < c` is taken apart where its middle is a name or a number, which costs
        nothing to say twice.
        """
        self.generic_visit(node)
        operands = [node.left, *node.comparators]
        if not all(type(shape) in SHAPES for shape in node.ops):
            return node
        if not all(isinstance(middle, ast.Name | ast.Constant) for middle in operands[1:-1]):
            return node
        place = f"{self.path}:{node.lineno}"
        calls: list[ast.expr] = []
        for number, shape in enumerate(node.ops):
            arguments = [
                ast.Constant(place),
                ast.Constant(type(shape).__name__),
                operands[number],
                operands[number + 1],
            ]
            calls.append(ast.Call(ast.Name(NAME, ast.Load()), arguments, []))
        if len(calls) == 1:
            whole = calls[0]
        else:
            whole = ast.BoolOp(ast.And(), calls)
        return ast.fix_missing_locations(ast.copy_location(whole, node))


def _from_here() -> str | None:
    """The place in a test from which numpy or math was called."""
    frame = sys._getframe(2)
    path = frame.f_code.co_filename
    if "/tests/" in path or "/validation/" in path:
        return f"{_short(path)}:{frame.f_lineno}"
    return None


def _another_seed(seed: int) -> None:
    """Gives every generator of numpy that a test asks for other numbers than the seed in the test
    alone would.
    """
    real = np.random.default_rng

    def other(first: ArrayLike | None = None) -> np.random.Generator:
        if first is None:
            return real()
        return real([*np.atleast_1d(first).tolist(), seed])

    setattr(np.random, "default_rng", other)  # noqa: B010  (the type of numpy's own takes more)


def _short(path: str) -> str:
    """The path from the root of the project."""
    try:
        return str(Path(path).relative_to(Path.cwd()))
    except ValueError:
        return path


def _watch(
    module: Any, name: str, relative: float, absolute: float, rel_name: str, abs_name: str
) -> None:
    """Notes calls of a comparison of numpy or math that come from a test."""
    real = getattr(module, name)

    def noted(actual: Any, expected: Any, *more: Any, **options: Any) -> Any:
        place = _from_here()
        if place:
            tolerances = dict(zip((rel_name, abs_name), more, strict=False)) | options
            _close(
                place,
                actual,
                expected,
                float(tolerances.get(rel_name, relative)),
                float(tolerances.get(abs_name, absolute)),
            )
        return real(actual, expected, *more, **options)

    setattr(module, name, noted)


_real = rewrite.rewrite_asserts


def _rewritten(
    mod: ast.Module, source: bytes, module_path: str | None = None, config: Any = None
) -> None:
    """Notes the comparisons of tests, and then does what pytest does with assertions."""
    path = _short(module_path or "?")
    if path.startswith(("tests/", "validation/")):
        _Noted(path).visit(mod)
    _real(mod, source, module_path, config)


def pytest_sessionfinish() -> None:
    """Adds the places of this process to the file."""
    if "REFDEM_MARGINS" not in os.environ:
        return
    with Path(os.environ["REFDEM_MARGINS"]).open("a") as file:
        file.writelines(
            json.dumps({"place": place, **noted}) + "\n" for place, noted in sorted(places.items())
        )


if "REFDEM_SEED" in os.environ:
    _another_seed(int(os.environ["REFDEM_SEED"]))
if "REFDEM_MARGINS" in os.environ:
    import builtins

    sys.dont_write_bytecode = True
    setattr(builtins, NAME, compared)
    rewrite.rewrite_asserts = _rewritten
    rewrite._read_pyc = lambda *arguments: None
    _watch(np, "allclose", 1e-5, 1e-8, "rtol", "atol")
    _watch(np, "isclose", 1e-5, 1e-8, "rtol", "atol")
    _watch(np.testing, "assert_allclose", 1e-7, 0.0, "rtol", "atol")
    _watch(math, "isclose", 1e-9, 0.0, "rel_tol", "abs_tol")
