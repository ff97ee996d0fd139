"""Proofs of several threads are, ball for ball, those of one; nothing but balls.py touches
python-flint's settings.
"""

import ast
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from threading import Event, Thread

import flint
import pytest
from flint import arb, arb_series, ctx

from refdem.core import discovery
from refdem.truth.balls import CONTEXT, precision, series_length, terms_of
from tests.exponents import exponent

SOURCE = Path(__file__).parents[2] / "refdem"
SETTINGS = {name for name in dir(ctx) if not name.startswith("_")}
THREADS = 8
ASKED = [
    ("pendulum", {"theta0": "3"}, "7"),
    ("van-der-pol", {}, "3"),
    ("double-pendulum", {}, "1/2"),
    ("dissipating-body", {}, "5"),
    ("stick-slip", {}, "6"),
    ("logistic", {}, "40"),
    ("free-rigid-body", {}, "3"),
    ("driven-duffing", {}, "2"),
]


def told(case, given, t):
    """All that a truth says of a time: balls, scalars, S, exponent."""
    truth = discovery.case(case).at(**given).truth()
    time = Fraction(t)
    balls = dict(truth.at(time))
    growth = truth.sensitivity(time)
    return (
        balls,
        dict(truth.scalars()),
        growth,
        exponent(truth, time) if case == "van-der-pol" else None,
    )


def test_eight_threads_prove_bit_for_bit_what_one_proves():
    alone = [told(*asked) for asked in ASKED]
    before = ctx.prec, ctx.cap
    with ThreadPoolExecutor(THREADS) as threads:
        together = list(threads.map(lambda asked: told(*asked), [*ASKED, *ASKED]))
    assert together == [*alone, *alone]
    assert (ctx.prec, ctx.cap) == before


def test_eight_threads_that_share_one_truth_find_what_one_finds():
    times = [Fraction(k, 4) for k in range(16)]
    alone = discovery.case("van-der-pol").at().truth()
    serial = [alone.at(t) for t in reversed(times)]
    shared = discovery.case("van-der-pol").at().truth()
    with ThreadPoolExecutor(THREADS) as threads:
        found = list(threads.map(shared.at, reversed(times)))
    assert found == serial


@pytest.mark.parametrize("setting", [precision, series_length])
def test_a_setting_is_held_until_its_thread_is_done(setting):
    inside = Event()
    done = []

    def other():
        inside.set()
        with setting(7):
            done.append(True)

    with setting(99):
        thread = Thread(target=other)
        thread.start()
        inside.wait()
        thread.join(0.05)
        assert not done
        assert 99 in (ctx.prec, ctx.cap)
    thread.join()
    assert done


def test_a_truth_is_asked_under_the_lock():
    """Another thread that holds the lock keeps `at` waiting; so what is evaluated outside of
    `precision` is guarded too.
    """
    truth = discovery.case("harmonic-oscillator").at().truth()
    found = []
    with CONTEXT:
        thread = Thread(target=lambda: found.append(truth.at(Fraction(1))))
        thread.start()
        thread.join(0.05)
        assert not found
    thread.join()
    assert found == [truth.at(Fraction(1))]


def test_a_series_that_was_cut_short_is_no_series():
    with series_length(4):
        short = arb_series([1, 2, 3, 4], prec=4)
    assert terms_of(short, 4) == [arb(1), arb(2), arb(3), arb(4)]
    with pytest.raises(RuntimeError, match="expected 5"):
        terms_of(short, 5)


def settings_changed(path):
    """Lines of a file that change python-flint's settings: an assignment to one of them, or one of
    its own managers.
    """
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Assign | ast.AugAssign | ast.AnnAssign):
            if isinstance(node, ast.Assign):
                targets = node.targets
            else:
                targets = [node.target]
            for part in (part for target in targets for part in ast.walk(target)):
                is_set = isinstance(part, ast.Attribute) and isinstance(part.ctx, ast.Store)
                if is_set and part.attr in SETTINGS and ast.unparse(part.value).endswith("ctx"):
                    yield node.lineno
        elif isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            is_manager = name.rpartition(".")[2] in {
                "workprec",
                "workdps",
                "extraprec",
                "extradps",
                "default",
                "cleanup",
            }
            if (is_manager and "ctx" in name) or (
                name == "setattr" and "ctx" in ast.unparse(node.args[0])
            ):
                yield node.lineno


def test_nothing_but_balls_changes_the_settings_of_the_process():
    found = {
        path.relative_to(SOURCE).as_posix()
        for path in SOURCE.rglob("*.py")
        if list(settings_changed(path))
    }
    assert found == {"truth/balls.py"}


@pytest.mark.parametrize(
    "line",
    [
        "ctx.prec = 5",
        "flint.ctx.cap = 1",
        "ctx.dps += 3",
        "x, ctx.prec = 1, 2",
        "ctx.workprec(9)",
        "setattr(ctx, 'cap', 3)",
    ],
)
def test_a_change_of_settings_is_seen(line, tmp_path):
    (tmp_path / "planted.py").write_text(line)
    assert hasattr(flint, "ctx")
    assert list(settings_changed(tmp_path / "planted.py")) == [1]
