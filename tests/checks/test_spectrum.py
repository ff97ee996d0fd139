"""Lines of driven oscillators: held by true motions in every order, failed by a line of another
amplitude or phase, and by no error within the bounds.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.spectrum import is_driven_on_a_line, lines_of
from refdem.core import discovery
from refdem.core.check import CompletedRun
from refdem.core.trajectory import Cost
from refdem.core.variant import Variant
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.truth.sampled import sampled
from tests.checks.conftest import subject, true_run

CHECK = discovery.check("spectrum")
MIXED = {
    "eps": "1/2",
    "delta": "1/4",
    "drive": "1/2,4/5",
    "x0": "1/4",
    "duration": "32",
    "samples": "64",
}
NAMES = ["shift", "w1", "w2", "2w1", "w1+w2", "2w2", "w2-w1"]
SINGLE = {"f0": "0,1/2", "drive": "0,2/3", "delta": "1/8", "duration": "24", "samples": "48"}


def with_added(line: str, change: complex):
    """A run whose place has `change`, a complex amplitude [m], more of a line."""

    def fault(run, level):
        of = subject("quadratic-response", "second", **MIXED)
        found = lines_of(of.instance.scene, of.instance.times)
        frequency = next(w for name, w in found.lines if name == line)
        position = np.array(run.position)
        position[:, 0, 0] += np.real(change * np.exp(1j * frequency * run.t))
        return replace(run, position=position)

    return fault


def certified_lines(of) -> dict[str, complex]:
    found = lines_of(of.instance.scene, of.instance.times)
    amplitudes = found.rows @ of.truth.value("x")
    return dict(zip([line.name for line in found.lines], amplitudes.tolist(), strict=True))


def test_the_line_of_a_linear_oscillator_is_its_steady_motion_whatever_the_start() -> None:
    """c = f/(w0^2 - w^2 + 2 i delta w): the free motion is fitted along (1.105)."""
    for x0 in ("0", "2"):
        of = subject("driven-oscillator", "exact", drive="3/2", x0=x0, duration="12", samples="48")
        lines = certified_lines(of)
        assert lines["w"] == pytest.approx(1 / complex(1 - 2.25, 0.3), rel=1e-13)
        assert abs(lines["shift"]) < 1e-14


@pytest.mark.parametrize("method", ["exact", "first", "second", "fourth"])
@pytest.mark.parametrize("given", [MIXED, SINGLE])
def test_the_true_motion_has_its_lines(judge, method, given) -> None:
    found = judge("spectrum", "quadratic-response", method, **given)
    assert {finding.outcome for finding in found.values()} <= {"pass", "undecided"}
    if method != "first":
        assert all(finding.outcome == "pass" for finding in found.values())
        names = NAMES
        if given is SINGLE:
            names = ["shift", "w", "2w"]
        assert list(found) == names


@pytest.mark.parametrize("line", NAMES)
@pytest.mark.parametrize("factor", [-1.0, 2.0, 1.01, 1j])
def test_a_line_with_another_sign_factor_or_phase_fails_alone(judge, line, factor) -> None:
    true = certified_lines(subject("quadratic-response", "second", **MIXED))[line]
    if line == "shift" and factor == 1j:
        factor = 0.5
    fault = with_added(line, (factor - 1) * true)
    found = judge("spectrum", "quadratic-response", "fourth", fault=fault, **MIXED)
    assert found[line].outcome == "fail"
    assert found[line].value == pytest.approx(abs((factor - 1) * true), rel=1e-6)
    assert {name for name, finding in found.items() if finding.outcome == "fail"} == {line}


def test_a_linear_spring_has_no_shift(judge) -> None:
    def shifted(run, level):
        return replace(run, position=run.position + 1e-9)

    given = {"drive": "3/2", "duration": "12", "samples": "48"}
    assert judge("spectrum", "driven-oscillator", "exact", **given)["shift"].outcome == "pass"
    found = judge("spectrum", "driven-oscillator", "exact", fault=shifted, **given)
    assert found["shift"].outcome == "fail"
    assert found["w"].outcome == "pass"


def test_a_shift_that_the_motion_does_not_change_moves_by_round_off_at_most(judge) -> None:
    """x(0) is the mean, but for round-off: what is left differs from processor to processor."""
    given = {"gravity": "1", "delta": "2", "drive": "3", "duration": "5", "samples": "16"}
    found = judge("spectrum", "driven-oscillator", "exact", **given)["shift"]
    assert found.outcome == "undecided"
    assert "moves by no more than round-off" in found.sentence


def test_errors_of_samples_within_their_bounds_are_never_accused() -> None:
    """Those of the worst signs least of all: each bound is reached by its own line alone."""
    of = subject("quadratic-response", "second", **MIXED)
    found = lines_of(of.instance.scene, of.instance.times)
    scale = of.instance.quantities["x"].scale
    for k, row in enumerate(found.rows):
        for phase in (1.0, 1j):
            runs = {}
            for variant in of.plain:
                run = true_run(of)
                position = np.array(run.position)
                signs = np.sign(np.real(phase * row))
                position[:, 0, 0] += signs * of.bound(variant.level) * scale
                runs[variant] = CompletedRun(replace(run, position=position), Cost(seconds=0.0))
            findings = CHECK.judge(of, runs)
            assert all(finding.outcome != "fail" for finding in findings), found.lines[k]


def test_levels_that_lost_the_phase_predict_nothing() -> None:
    """A phase that is ahead by 2.2 r - 1.66 r^2 rad at the end, r being the step over the coarsest,
    is of order 1 and within its bounds; but a line is off by no more than all of the motion, and
    its errors at the coarse steps are too small for order 1.
    """
    given = {"delta": "0", "drive": "4/5", "duration": "200", "samples": "400"}
    levels = tuple(2.0**-k for k in range(7, 13))
    of = replace(subject("driven-oscillator", "first", **given), levels=levels)
    runs = {}
    for variant in of.plain:
        run = true_run(of)
        ratio = variant.level / levels[0]
        ahead = (2.2 * ratio - 1.66 * ratio**2) * run.t / run.t[-1]
        position = np.array(run.position)
        position[:, 0, 0] += np.cos(run.t + ahead) - np.cos(run.t)
        runs[variant] = CompletedRun(replace(run, position=position), Cost(seconds=0.0))
    findings = CHECK.judge(of, runs)
    assert len(findings) == 2
    assert all(finding.outcome != "fail" for finding in findings)


TRIPLED = {
    "beta": "1/2",
    "delta": "1/4",
    "f0": "1/2",
    "drive": "1/2",
    "duration": "32",
    "samples": "64",
}
CYCLE = {"x0": "2", "duration": "128", "samples": "256"}


def test_a_cube_makes_a_third_harmonic_of_the_sign_of_harmonic_balance(judge) -> None:
    """To first order in beta: c3 = -(beta A^3/4)/D(3w), of a line A at w (1.115), of a start on
    the steady motion, A = 3/5 - i/5 without the cube.
    """
    steady = {**TRIPLED, "beta": "1/1000", "x0": "3/5", "v0": "1/10"}
    of = subject("driven-duffing", "second", **steady)
    lines = certified_lines(of)
    balanced = -(lines["w"] ** 3) / 4000 / complex(1 - 1.5**2, 2 * 0.25 * 1.5)
    assert lines["3w"] == pytest.approx(balanced, rel=1e-3)
    found = judge("spectrum", "driven-duffing", "fourth", **TRIPLED)
    assert list(found) == ["shift", "w", "3w"]
    assert all(finding.outcome == "pass" for finding in found.values())


@pytest.mark.parametrize("method", ["exact", "first", "second", "fourth"])
def test_the_true_motion_of_a_driven_cycle_has_the_lines_that_figure_1_25_names(
    judge, method
) -> None:
    found = judge("spectrum", "van-der-pol", method, **CYCLE)
    assert {finding.outcome for finding in found.values()} <= {"pass", "undecided"}
    if method in ("exact", "fourth"):
        assert {"w", "wd", "2w-wd", "3w-2wd"} <= set(found)
        assert all(found[name].outcome == "pass" for name in ("w", "wd", "2w-wd", "3w-2wd"))
        assert "at 2w-wd = 0.8453 rad/s (amplitude 0.0445" in found["2w-wd"].sentence
        assert "at 3w-2wd = 0.693 rad/s (amplitude 0.00107" in found["3w-2wd"].sentence


@pytest.mark.parametrize("line", ["w", "wd", "2w-wd", "3w-2wd"])
@pytest.mark.parametrize("factor", [-1.0, 2.0, 1.01, 1j])
def test_a_line_of_a_driven_cycle_with_another_sign_factor_or_phase_fails_alone(
    judge, line, factor
) -> None:
    of = subject("van-der-pol", "exact", **CYCLE)
    true = of.truth.value("x")
    lines = lines_of(of.instance.scene, of.instance.times, true)
    (k,) = (k for k, one in enumerate(lines.lines) if one.name == line)
    change = (factor - 1) * complex(lines.rows[k] @ true)

    def fault(run, level):
        position = np.array(run.position)
        added = np.real(change * np.exp(1j * lines.lines[k].frequency * run.t))
        position[:, 0, 0] += added
        return replace(run, position=position)

    found = judge("spectrum", "van-der-pol", "exact", fault=fault, **CYCLE)
    assert {name for name, finding in found.items() if finding.outcome == "fail"} == {line}
    assert found[line].value == pytest.approx(abs(change), rel=1e-6)


@pytest.mark.parametrize(
    "given",
    [{}, {"mu": "2", "duration": "128", "samples": "256"}, {**CYCLE, "p": "0"}],
)
def test_a_cycle_is_not_judged_on_its_way_nor_in_relaxation_nor_without_a_drive(given) -> None:
    instance = discovery.case("van-der-pol").at(**given)
    of = replace(subject("van-der-pol", "exact", **CYCLE), instance=instance, truth=None)
    assert CHECK.applies(of) is not None


@pytest.mark.parametrize(
    "elements",
    [
        (Spring(a=0, stiffness=1.0), Dashpot(a=0, damping=0.5)),
        (Spring(a=0, stiffness=1.0), Force(a=0, amplitude=1.0)),
        (Spring(a=0, stiffness=-1.0), Force(a=0, amplitude=1.0, frequency=2.0)),
        (Spring(a=0, stiffness=1.0, exponent=1.5), Force(a=0, amplitude=1.0, frequency=2.0)),
        (
            Spring(a=0, stiffness=1.0),
            Dashpot(a=0, van_der_pol=1.0),
            Force(a=0, amplitude=1.0, frequency=2.0),
        ),
        (
            Spring(a=0, stiffness=1.0),
            Slider(a=0, friction=0.5, normal_force=1.0),
            Force(a=0, amplitude=1.0, frequency=2.0),
        ),
        (
            Spring(a=0, stiffness=1.0),
            Force(a=0, amplitude=1.0, frequency=2.0, axis=(0.0, 1.0, 0.0)),
        ),
    ],
)
def test_other_scenes_have_no_lines(elements) -> None:
    assert not is_driven_on_a_line(Scene.of([Body(mass=1.0, position=(1.0, 0.0, 0.0))], elements))


def test_weight_and_forces_of_one_frequency_change_no_frequencies() -> None:
    elements = (
        Spring(a=0, stiffness=1.0),
        UniformGravity(g=(2.0, 0.0, 0.0)),
        Force(a=0, amplitude=1.0, frequency=2.0),
        Force(a=0, amplitude=1.0, frequency=2.0, phase=1.0),
    )
    scene = Scene.of([Body(mass=1.0, position=(1.0, 0.0, 0.0))], elements)
    assert is_driven_on_a_line(scene)
    found = lines_of(scene, np.linspace(0.0, 10.0, 41))
    assert [line.name for line in found.lines] == ["shift", "w"]


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"duration": "3", "samples": "64"}, "too few or cover too short a time"),
        ({"duration": "32", "samples": "8"}, "too few or cover too short a time"),
        ({"delta": "0", "drive": "1/2,1/2"}, "too few or cover too short a time"),
        ({"f0": "0,0"}, "not one body on a spring under periodic forces"),
    ],
)
def test_it_does_not_apply_where_there_are_no_lines_to_tell_apart(given, reason) -> None:
    instance = discovery.case("quadratic-response").at(**{**MIXED, **given})
    truth = sampled(instance.truth(), instance.times.tolist())
    of = replace(subject("quadratic-response", "second", **MIXED), instance=instance, truth=truth)
    assert reason in (CHECK.applies(of) or "")


def test_without_truth_and_with_too_near_a_horizon_it_is_undecided() -> None:
    of = subject("quadratic-response", "second", **MIXED)
    runs = {variant: CompletedRun(true_run(of), Cost(seconds=0.0)) for variant in of.plain}
    (unproved,) = CHECK.judge(replace(of, truth=None), runs)
    assert unproved.outcome == "undecided"
    coarse = replace(of, levels=(0.5,))
    (blind,) = CHECK.judge(coarse, {Variant(0.5): CompletedRun(true_run(of), Cost(seconds=0.0))})
    assert blind.outcome == "undecided"
    assert "horizon" in blind.sentence
