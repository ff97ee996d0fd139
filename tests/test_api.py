"""What Python imports: runs of a case, and an integrator of one's own that is judged."""

import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import refdem
from refdem.errors import UsageError


def leapfrog(t, r, v, h, a):  # type: ignore[no-untyped-def]
    """Velocity Verlet: kick, drift, kick."""
    v = v + h / 2 * a(t, r, v)
    r = r + h * v
    return r, v + h / 2 * a(t + h, r, v)


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A store of each test's own."""
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))


@pytest.mark.parametrize(
    ("case", "given"), [("harmonic-oscillator", {}), ("two-body-orbit", {"duration": 2.0})]
)
def test_a_right_step_holds_what_it_claims(case, given):  # type: ignore[no-untyped-def]
    claims = {"order": 2, "symplectic": True, "reversible": True}
    judged = refdem.judge(leapfrog, case, **claims, **given)
    assert judged.holds, judged
    assert judged.outcomes["pass"] > 5
    (record,) = judged.records
    assert (record.engine, record.method) == ("leapfrog", "leapfrog")


def test_a_step_whose_claim_or_formula_is_wrong_does_not_hold() -> None:
    def explicit(t, r, v, h, a):  # type: ignore[no-untyped-def]
        return r + h * v, v + h * a(t, r, v)

    def swapped(t, r, v, h, a):  # type: ignore[no-untyped-def]
        return leapfrog(t, r, v, h, lambda *state: -a(*state))

    assert refdem.judge(explicit, "harmonic-oscillator", order=1).outcomes.get("fail", 0) == 0
    assert not refdem.judge(explicit, "harmonic-oscillator", order=2).holds
    assert not refdem.judge(swapped, "harmonic-oscillator", order=2).holds


def test_a_driven_step_gets_the_time_of_the_scene() -> None:
    """A step that takes the force at t = 0 for that at t is seen in a motion with a drive."""

    def heun(t, r, v, h, a):  # type: ignore[no-untyped-def]
        first = a(t, r, v)
        second = a(t + h, r + h * v, v + h * first)
        return r + h * v + h * h / 2 * first, v + h / 2 * (first + second)

    def stopped(t, r, v, h, a):  # type: ignore[no-untyped-def]
        return heun(0.0, r, v, h, lambda _, *state: a(0.0, *state))

    assert refdem.judge(heun, "driven-oscillator", order=2, duration=4).holds
    assert not refdem.judge(stopped, "driven-oscillator", order=2, duration=4).holds


def test_a_scene_with_more_than_points_in_forces_is_unsupported() -> None:
    judged = refdem.judge(leapfrog, "pendulum", order=2)
    assert judged.outcomes == {"unsupported": 1}
    assert not judged.holds
    assert "does not support the element rod" in repr(judged)


def test_a_step_that_returns_something_else_is_an_error_with_what_was_expected() -> None:
    def forgets(t, r, v, h, a):  # type: ignore[no-untyped-def]
        return r

    judged = refdem.judge(forgets, "harmonic-oscillator", order=2)
    assert "expected two arrays of shape (1, 3)" in repr(judged)
    assert set(judged.outcomes) == {"error"}


def test_a_run_is_judged_and_shows_itself() -> None:
    judged = refdem.run("pendulum", "reference", method="rattle", theta0=0.5, duration=2)
    assert judged.holds, judged
    assert "pass" in repr(judged).splitlines()[-2]
    assert len(judged.findings) == sum(judged.outcomes.values())
    assert set(judged.tolerance["method"]) == {"rattle"}
    assert len(judged.levels) > 4
    table = judged._repr_html_()
    assert table.count("<tr>") == 1 + len(judged.findings)
    assert "<td>order/state</td><td>pass</td>" in table


def test_a_notebook_s_table_has_no_markup_of_a_program() -> None:
    from refdem.api import _shown

    assert _shown("<b>\x1b[31m") == "&lt;b&gt;?[31m"


def test_a_float_stands_for_its_exact_value() -> None:
    as_written = refdem.truth_of("pendulum", theta0="0.1").scalars()["period"]
    as_float = refdem.truth_of("pendulum", theta0=0.1).scalars()["period"]
    exact = refdem.truth_of("pendulum", theta0=Fraction(0.1)).scalars()["period"]
    assert as_float == exact
    apart = abs(as_written.mid - as_float.mid)
    assert as_written.radius + as_float.radius < apart < Fraction(1, 10**16)
    assert (
        refdem.truth_of("pendulum", theta0=1).scalars()
        == refdem.truth_of("pendulum", theta0=np.float64(1.0)).scalars()
    )


@pytest.mark.parametrize("value", [float("nan"), float("inf"), None, {"a": 1}])
def test_what_is_no_number_is_refused(value: object) -> None:
    with pytest.raises(UsageError, match="expected a finite number, a text"):
        refdem.truth_of("pendulum", theta0=value)


def test_several_numbers_may_be_a_list_or_an_array() -> None:
    listed = refdem.truth_of("double-pendulum", masses=[1, 2.0], duration="1/8")
    of_array = refdem.truth_of("double-pendulum", masses=np.array([1.0, 2.0]), duration="1/8")
    written = refdem.truth_of("double-pendulum", masses="1,2", duration="1/8")
    at = Fraction(1, 16)
    assert listed.at(at) == of_array.at(at) == written.at(at)


def test_certified_values_are_arrays_with_the_radii_that_contain_them() -> None:
    times = [0, 0.25, "1/3"]
    middles, radii = refdem.sampled("pendulum", times, theta0=2.0)
    assert middles.index.tolist() == radii.index.tolist() == [0.0, 0.25, 1 / 3]
    truth = refdem.truth_of("pendulum", theta0=2.0)
    for row, t in enumerate((Fraction(0), Fraction(1, 4), Fraction(1, 3))):
        for name, ball in truth.at(t).items():
            middle = middles[name].iloc[row]
            assert middle == float(ball)
            assert abs(Fraction(middle) - ball.mid) + ball.radius <= Fraction(radii[name].iloc[row])
    assert 0 < radii.to_numpy().max() < 1e-15


def test_derivatives_are_tables_with_units_and_nan_where_there_is_none() -> None:
    """x = x0 cos w t: dx/dx0 = cos w t."""
    given = {"mass": 1, "stiffness": 4, "gravity": 0, "v0": 0}
    middles, radii, units = refdem.sensitivities_of("harmonic-oscillator", [0.25, "1/3"], **given)
    assert middles.index.names == ["t", "quantity"]
    for t in (0.25, 1 / 3):
        assert middles.loc[t, "x"]["x0"] == pytest.approx(np.cos(2 * t), rel=1e-15)
    assert 0 < radii.to_numpy().max() < 1e-15
    assert units.loc["v", "mass"] == "(m/s)/kg"
    border = refdem.sensitivities_of("coulomb-oscillator", [2.5]).middles
    assert border["v0"].isna().all()
    assert border["mass"].notna().all()


def test_a_time_beyond_what_is_certified_is_said() -> None:
    with pytest.raises(UsageError, match="expected a finite number"):
        refdem.sampled("pendulum", [float("nan")])


def test_tables_have_the_parameters_in_columns() -> None:
    judged = refdem.run("pendulum", "reference", method="rattle", theta0=2.0, levels=2)
    for frame in (judged.findings, judged.tolerance, judged.levels):
        assert frame["theta0"].unique().tolist() == [2.0]
    assert {"step_for_3_digits", "seconds_for_6_digits"} <= set(judged.tolerance.columns)
    spheres = refdem.run("two-spheres", "reference", levels=2)
    assert set(spheres.findings["masses"]) == {"1,1"}


def test_errors_are_drawn_by_altair_and_into_axes_of_matplotlib() -> None:
    judged = refdem.judge(leapfrog, "harmonic-oscillator", order=2)
    drawn = judged.chart().to_dict()
    assert "leapfrog" in str(drawn["datasets"])
    axes = Figure().subplots()
    judged.plot(axes)
    errors, bounds = axes.get_lines()
    assert np.all(errors.get_ydata() < bounds.get_ydata())
    assert errors.get_xdata().tolist() == sorted(set(judged.levels["level"]))
    with pytest.raises(UsageError, match="nothing to draw"):
        refdem.judge(leapfrog, "pendulum", order=2).chart()


def test_the_stub_has_every_public_name() -> None:
    stub = Path(refdem.__file__).with_suffix(".pyi").read_text()
    told = set(re.findall(r"import \w+ as (\w+)", stub)) | set(re.findall(r"(?m)^(\w+):", stub))
    assert told == {*refdem._HOMES, "__version__"}


CALLS = """
import refdem

judged = refdem.run("pendulum", theta0=2.0)
reveal_type(judged)
reveal_type(refdem.truth_of("pendulum"))
reveal_type(refdem.sampled)
"""


def test_a_type_checker_sees_what_is_called(tmp_path: Path) -> None:
    (tmp_path / "calls.py").write_text(CALLS)
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path / "cache"), "calls.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout
    for name in ("refdem.api.Judged", "refdem.core.truth.Truth", "refdem.api.Sampled"):
        assert name in done.stdout


@pytest.mark.parametrize(("words", "status"), [(["--version"], 0), (["no-such-command"], 2)])
def test_python_runs_the_package_as_the_command(words: list[str], status: int) -> None:
    command = [sys.executable, "-m", "refdem", *words]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == status, found.stderr
    assert "refdem" in found.stdout + found.stderr
