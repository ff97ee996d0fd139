"""How neighbouring paths of a billiard part: the true separation is within the bounds at any
setting, and is that of the derivative of truth; a bent wall and a rounded state fail.
"""

import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from refdem.checks.beam import CHECK, FEWEST, Beam, followed_beams
from refdem.checks.lyapunov import APART
from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.check import CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.problem import Iteration, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.reference import ENGINE
from refdem.truth.balls import arb_of, precision
from refdem.truth.exact import vector
from refdem.truth.sampled import sampled

METHOD = ENGINE.method("iterated-map")
TABLES = {
    "rectangle": {"geometry": "rectangle", "n": "100"},
    "stadium": {"n": "24"},
    "circle": {"geometry": "stadium", "size": "2,2", "start": "1/4,1/8", "n": "64"},
}


def subject_of(**given: str) -> Subject:
    table = discovery.case("billiards").at(**given)
    return Subject(table, METHOD, (0.0,), sampled(table.truth(), table.times.tolist()))


def run_of(problem: Iteration) -> CompletedRun:
    run, _ = ENGINE.run(Request(problem=problem, method="iterated-map"))
    return CompletedRun(run, Cost(seconds=0.0))


def same(run: Trajectory) -> Trajectory:
    return run


def finding(subject: Subject, change: Callable[[Trajectory], Trajectory] = same) -> Finding:
    """The finding on the reference's runs, each after a `change`."""
    assert CHECK.applies(subject) is None
    problem = subject.instance.problem
    assert isinstance(problem, Iteration)
    plain, beside = CHECK.needs(subject)
    runs = {plain: run_of(problem), beside: run_of(problem.perturbed(APART))}
    changed = {name: replace(run, trajectory=change(run.trajectory)) for name, run in runs.items()}
    (found,) = CHECK.judge(subject, changed)
    return found


def beams_of(subject: Subject) -> list[Beam]:
    truth = subject.truth
    assert truth is not None
    problem = subject.instance.problem
    assert isinstance(problem, Iteration)
    columns = [
        np.column_stack([truth.value(f"{name}.{axis}") for axis in "xy"])
        for name in ("position", "direction")
    ]
    return list(followed_beams(problem, subject, *columns))


@pytest.mark.parametrize("given", TABLES.values(), ids=TABLES)
def test_a_right_run_parts_at_the_true_rate(given: dict[str, str]) -> None:
    found = finding(subject_of(**given))
    assert found.outcome == "pass", found.sentence
    assert found.bound is not None
    assert 0 < found.bound < 1e-3


def drawn(seed: int) -> dict[str, str]:
    """Any table, start and direction."""
    rng = random.Random(seed)
    length = 10 ** rng.uniform(-1, 1)
    width = length * 10 ** rng.uniform(-1, 0)
    direction = (rng.uniform(0.05, 1), rng.choice((-1, 1)) * rng.uniform(0.05, 1))
    return {
        "geometry": rng.choice(("rectangle", "stadium")),
        "size": f"{length:.4g},{width:.4g}",
        "start": f"{length * rng.uniform(-0.2, 0.2):.4g},{width * rng.uniform(-0.2, 0.2):.4g}",
        "direction": "{:.5g},{:.5g}".format(*direction),
        "n": "40",
    }


def neighbour(instance: Instance) -> Instance:
    """The case whose exact start is that of the perturbed run, to the last bit."""
    problem = instance.problem
    assert isinstance(problem, Iteration)
    moved = [str(Fraction(x)) for x in problem.perturbed(APART).start]
    given = {"start": ",".join(moved[:2]), "direction": ",".join(moved[2:])}
    kept = {name: str(instance.p[name]) for name in ("geometry", "n")}
    size = ",".join(str(x) for x in vector(instance.p, "size"))
    return discovery.case("billiards").at(**given, **kept, size=size)


@pytest.mark.parametrize("seed", range(12))
def test_the_certified_neighbour_is_within_the_bounds_after_every_bounce(seed: int) -> None:
    subject = subject_of(**drawn(seed))
    path = subject.instance.truth()
    beside = neighbour(subject.instance).truth()
    beams = beams_of(subject)
    assert len(beams) >= FEWEST
    for beam in beams:
        here = path.at(Fraction(beam.bounces))
        there = beside.at(Fraction(beam.bounces))
        moved = {name: there[name].mid - here[name].mid for name in here}
        u = here["direction.x"].mid
        v = here["direction.y"].mid
        offset = float(u * moved["position.y"] - v * moved["position.x"])
        angle = float(u * moved["direction.y"] - v * moved["direction.x"])
        # The start of the path is rounded as well, to some 1e-16 of a separation of 1e-8.
        off = np.abs(np.array([offset, angle]) - beam.separation)
        assert np.all(off <= beam.bounds + 1e-7 * np.abs(beam.separation)), beam


@pytest.mark.parametrize("given", TABLES.values(), ids=TABLES)
def test_the_separation_is_that_of_the_derivative_of_truth(given: dict[str, str]) -> None:
    subject = subject_of(**given)
    problem = subject.instance.problem
    assert isinstance(problem, Iteration)
    truth = subject.instance.truth()
    beam = beams_of(subject)[-1]
    at = Fraction(beam.bounces)
    scale = subject.instance.scales.length
    moved = (problem.perturbed(APART).start - problem.start) / np.array([scale, scale, 1, 1])
    with precision(512):
        rows = truth.jacobian(at).table()  # type: ignore[attr-defined]
    after = [
        sum(float(x * arb_of(Fraction(d))) for x, d in zip(r, moved, strict=True)) for r in rows
    ]
    values = truth.at(at)
    u, v = float(values["direction.x"]), float(values["direction.y"])
    offset = scale * (u * after[1] - v * after[0])
    angle = u * after[3] - v * after[2]
    np.testing.assert_allclose([offset, angle], beam.separation, rtol=1e-7, atol=1e-14)


def test_a_state_of_nine_digits_fails() -> None:
    def rounded(run: Trajectory) -> Trajectory:
        values = {name: np.round(x, 9) for name, x in run.values.items()}
        return replace(run, values=values)

    assert finding(subject_of(**TABLES["rectangle"]), rounded).outcome == "fail"


def test_neighbours_that_merge_fail() -> None:
    def merged(run: Trajectory) -> Trajectory:
        values = {name: np.zeros_like(x) for name, x in run.values.items()}
        return replace(run, values=values)

    assert finding(subject_of(**TABLES["stadium"]), merged).outcome == "fail"


def test_no_rate_is_read_where_a_path_ends_at_a_corner() -> None:
    found = finding(subject_of(geometry="rectangle", start="0,0", direction="2,1", n="8"))
    assert found.outcome == "undecided"


def test_only_billiards_have_neighbouring_paths() -> None:
    logistic = discovery.case("logistic").at()
    assert CHECK.applies(Subject(logistic, METHOD, (0.0,), None)) == "the case is not a billiard"
