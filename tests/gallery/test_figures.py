"""The figures' data against numbers that are known otherwise."""

from functools import cache

import numpy as np
import pytest

from refdem.errors import UsageError
from refdem.gallery import gallery
from refdem.gallery.corner_weights import fallen
from refdem.gallery.figures.fig_co_4 import ANGLES, LABELS
from refdem.gallery.measured import readings
from refdem.gallery.outline import finer
from refdem.mechanics.quaternion import rotated
from refdem.report.numbers import significant

CHAPTER = (
    "1.12 1.15 1.16 1.17 1.18 1.19 1.20 1.21 1.22 1.23 1.24 1.25 1.26 1.28 1.29 1.30 1.31 1.32 1.33"
    " 1.35 1.36 1.37 1.38"
)


@cache
def figure(name):
    return gallery.figure(name)


def series(name, label):
    return next(s for panel in figure(name).panels for s in panel.series if s.label == label)


def test_every_computed_figure_of_the_chapter_has_a_file():
    assert gallery.names() == [*CHAPTER.split(), "co-4", "restitution", "summation-order"]


def test_an_unknown_figure_is_refused_with_the_nearest():
    with pytest.raises(UsageError, match=r"1\.15"):
        gallery.figure("1.155")


def test_each_says_the_commands_that_make_it_and_its_runs():
    assert figure("1.15").commands[0] == "refdem gallery 1.15"
    assert any(
        line.startswith("refdem run coulomb-oscillator --set duration=16")
        for line in figure("1.15").commands
    )


def test_dry_friction_stops_at_three_pi_where_the_chapter_says():
    assert list(figure("1.15").numbers.values()) == pytest.approx(
        [3 * np.pi, -0.1, -0.7, 0.4, -0.1], abs=1e-6
    )


def test_speeds_under_dry_friction_touch_their_straight_line():
    panel = figure("1.16").panels[0]
    dry = series("1.16", "Coulomb, f = 0.15")
    line = panel.series[3]
    size = np.abs(dry.y)
    tops = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    assert size[tops] == pytest.approx([0.85, 0.55, 0.25], abs=1e-4)
    assert np.interp(dry.x[tops], line.x, line.y) == pytest.approx(size[tops], abs=1e-3)


def test_resonance_peaks_are_those_of_the_formula():
    for delta in (0.1, 0.2, 0.5):
        curve = series("1.17", f"delta = {delta:g}")
        assert curve.y == pytest.approx(1 / np.hypot(1 - curve.x**2, 2 * delta * curve.x), rel=1e-8)
        assert curve.y.max() == pytest.approx(1 / (2 * delta * np.sqrt(1 - delta**2)), rel=4e-3)


@pytest.mark.parametrize("name", ["1.18", "1.19", "1.20", "1.22"])
def test_outlines_have_a_hundred_thousand_points(name):
    assert (
        next(value for what, value in figure(name).numbers.items() if what.startswith("points"))
        >= 1e5
    )


def test_areas_are_kept_shrink_or_go_to_zero():
    head = 0.14038085937500  # 575/4096: the shoelace formula by hand, size 1/4
    assert head == 575 / 4096
    assert figure("1.18").numbers["area at the start"] == pytest.approx(head, rel=1e-12)
    assert figure("1.18").numbers["largest change of the area"] < 1e-13
    assert figure("1.19").numbers["area at the end"] == pytest.approx(
        head * np.exp(-0.6 * np.pi), rel=1e-6
    )
    assert figure("1.19").numbers["largest distance from exp(-2 delta t)"] < 1e-13
    dry = figure("1.20").numbers
    assert dry["area at the end"] == 0
    assert dry["farthest point from the origin at the end [m]"] <= 0.15
    assert 0.05 < dry["part from below"] < 0.95
    assert dry["part from below"] + dry["part of the points from above"] == 1
    assert figure("1.22").numbers["largest change of the area inside"] < 1e-9


def test_periods_are_those_of_elliptic_integrals_and_beta_functions():
    numbers = figure("1.21").numbers
    assert numbers["period of n = 2 at 1.195254 m [s]"] == pytest.approx(2 * np.pi, rel=1e-6)
    assert numbers["period of the pendulum at 2 rad [s]"] == pytest.approx(
        8.3497528, rel=1e-6
    )  # 4 K(sin 1), mpmath


def test_the_leaning_resonance_folds_where_harmonic_balance_says_and_runs_lie_near_it():
    assert list(figure("1.23").numbers.values()) == pytest.approx(
        [1.6266, 1.6153, 1.5664], abs=5e-5
    )
    low, high = figure("1.24").numbers.values()
    assert low == pytest.approx(1.6153, abs=0.05)
    assert 2.0 < high < 2.3


def test_van_der_pol_has_its_amplitude_and_its_lines():
    panels = figure("1.25").panels
    assert figure("1.25").numbers["amplitude of the free cycle [m]"] == pytest.approx(
        2.00041, abs=2e-5
    )
    # 1 - mu^2/16 + 17 mu^4/3072 of the free cycle; the driven ones by fits of all lines.
    for force, frequency in (("0", 0.9975088542), ("1/25", 0.99766935), ("2/5", 1.013716)):
        name = f"highest line, p = {force}"
        error = figure("1.25").numbers[f"{name}: its error [rad/s]"]
        assert error < 2e-6
        assert figure("1.25").numbers[f"{name} [rad/s]"] == pytest.approx(
            frequency, abs=max(5 * error, 5e-9)
        )
    spectrum = panels[5].series[0]
    for line in (1.15, 0.85, 0.70):
        near = np.abs(spectrum.x - line) < 0.02
        assert (
            spectrum.y[near].max()
            > 20
            * spectrum.y[
                (np.abs(spectrum.x - line) > 0.04) & (np.abs(spectrum.x - line) < 0.06)
            ].min()
        )


def test_the_period_doubles_where_it_must():
    numbers = list(figure("1.26").numbers.values())
    assert numbers[:3] == pytest.approx([3, 1 + np.sqrt(6), 3.5440903], abs=1e-3)


def test_friction_is_static_at_rest_and_a_weak_drive_never_outruns_the_belt():
    assert figure("1.28").numbers["at rest"] == 0.4
    velocities = [
        value
        for what, value in figure("1.29").numbers.items()
        if what.startswith("gamma = 0.5") and "velocity" in what
    ]
    assert velocities == [1.0, 1.0, 1.0]


def exponents(name, start):
    """The exponents of a figure whose names begin so, each over its standard error."""
    numbers = figure(name).numbers
    measured = [what for what in numbers if what.startswith(start) and what.endswith("nt [1/s]")]
    return [
        numbers[what]
        / numbers[
            what.replace("largest exponent", "exponent").replace(
                ": exponent", ": its standard error"
            )
        ]
        for what in measured
    ]


def test_what_is_called_chaotic_has_a_positive_exponent_and_what_fills_a_band_has_none():
    assert max(exponents("1.29", "gamma = 0.5")) < 3
    periodic, *chaotic = exponents("1.29", "gamma = 2")
    assert periodic < -3
    assert min(chaotic) > 3
    *chaotic, periodic = exponents("1.30", "eta")
    assert periodic < -3
    assert min(chaotic) > 3
    maps = figure("1.31").numbers
    assert maps["gamma = 0.5, quadratic law: eta from 0.9 to 2.5: chaotic [parts of 1]"] == 0
    assert maps["gamma = 2, linear law: eta from 0.9 to 2.5: chaotic [parts of 1]"] > 0.5
    assert min(exponents("1.31", "gamma = 2")) > 3


def test_numbers_that_differ_are_told_apart():
    """Three folds were all shown as 1.6."""
    folds = figure("1.23")
    shown = [significant(value, folds.digits_of(what)) for what, value in folds.numbers.items()]
    assert shown == ["1.6266", "1.6153", "1.5664"]
    drawn = figure("1.18")
    shown = [significant(value, drawn.digits_of(what)) for what, value in drawn.numbers.items()]
    assert shown[:2] == ["101752", "0.140381"]
    assert len(shown[2]) <= len("9.5e-15"), "of an error only the size counts"


def test_a_beam_stays_together_in_the_rectangle_and_not_in_the_stadium():
    numbers = figure("1.33").numbers
    assert (
        numbers["rectangle: spread at t = 14 [m]"] < 1.2 * numbers["rectangle: spread at t = 0 [m]"]
    )
    assert numbers["stadium: spread at t = 14 [m]"] > 2 * numbers["stadium: spread at t = 0 [m]"]


def test_energy_appears_going_forward_disappears_coming_back_and_is_lost_by_the_wedge():
    assert list(figure("1.37").numbers.values()) == pytest.approx([0.75] * 3, rel=1e-12)
    assert list(figure("1.38").numbers.values()) == pytest.approx([0.5, 0.25, 0.5], rel=1e-6)


def test_poinsot_curves_keep_their_length_and_the_fault_shows():
    assert figure("1.36").numbers["largest change of |L| of all"] < 1e-13
    assert figure("1.12").numbers["largest difference in omega [rad/s]"] > 50


def test_on_the_slope_the_wrong_box_turns_steadily_between_contacts_and_goes_elsewhere():
    """Between the first two contacts of its corners its angular velocity keeps; that of the right
    box never does.
    """
    spins = figure("1.12").panels[3].series
    wrong = spins[0]
    right = spins[2]
    between = (wrong.x > 0.16) & (wrong.x < 0.3)
    assert np.ptp(wrong.y[between]) < 1e-9
    assert np.ptp(right.y[between]) > 10
    assert np.ptp(wrong.y) > 100
    assert figure("1.12").numbers[
        "on the slope: distance of the two centres at the end [m]"
    ] == pytest.approx(0.101, abs=2e-3)


def test_an_exponent_is_shown_only_where_neighbours_part_exponentially():
    """The pendulum's neighbours part as the time itself: a positive rate of finite times is no
    exponent.
    """
    numbers = figure("1.35").numbers
    assert (
        numbers["double pendulum: exponent [1/s]"]
        > 3 * numbers["double pendulum: its standard error [1/s]"]
    )
    assert numbers["pendulum: power of the time"] == pytest.approx(1.0, abs=0.2)
    assert "pendulum: exponent [1/s]" not in numbers


def test_measured_points_lie_near_the_certified_curve_and_say_who_measured_them():
    numbers = list(figure("co-4").numbers.values())
    assert numbers[0] < 1e-11, "the curve is the certified one"
    assert numbers[1] == sum(len(one.angle) for one in readings("kharaz_2001")) == 55
    assert 0 < numbers[2] < 0.05, "the experiments scatter by 5 to 10 %"
    slides = ANGLES > 40
    law = figure("co-4").panels[3].series[0]
    assert law.label == LABELS[0]
    formula = 1 - 0.092 * 1.98 / np.tan(np.radians(ANGLES[slides]))
    assert law.y[slides] == pytest.approx(formula, rel=1e-5), (
        "the damped force begins with a jump, under which the spring sticks first"
    )
    assert np.all(law.y[slides] > formula)
    assert all("Kharaz" not in one.by and one.of and one.by for one in readings("kharaz_2001"))
    assert "judge nothing" in figure("co-4").caption


def test_restitution_comes_out_as_it_went_in_but_for_what_gravity_adds_in_a_step():
    """An impact that is seen late by t < h strikes with v + g t: e v + (1 + e) g t comes back."""
    over_restitution, over_speed, over_step = figure("restitution").panels
    for panel in (over_restitution, over_speed):
        *seen, asked = panel.series
        assert {series.label for series in seen} == {
            "reference",
            "pymunk",
            "pymunk, as shipped",
            "REBOUND",
        }
        for series in seen:
            assert series.y == pytest.approx(asked.y, abs=1e-12)
    of_reference, *of_steps, _ = over_step.series
    assert of_reference.label == "reference"
    assert of_reference.y == pytest.approx(0.75, abs=1e-12)
    assert [series.label for series in of_steps] == ["pymunk", "pymunk, as shipped"]
    for series in of_steps:
        # g h/v is h over the time of the fall.
        assert np.all(series.y >= 0.75 - 1e-9)
        assert np.all(series.y - 0.75 <= 1.75 * series.x * (1 + 1e-9))
        assert series.y[1] - 0.75 > 0.05


def test_two_readings_of_one_measurement_agree_to_two_percent():
    """What was read off two papers by two projects: points within half a degree of each other."""
    compared = 0
    for quantity in ("spin", "tangential restitution"):
        first, second = (one.places for one in readings("kharaz_2001") if one.quantity == quantity)
        for x, y in zip(*first, strict=True):
            k = int(np.argmin(np.abs(second[0] - x)))
            if abs(second[0][k] - x) < 0.5:
                assert second[1][k] == pytest.approx(y, rel=0.02)
                compared += 1
    assert compared >= 13


@pytest.mark.parametrize(
    "wrong", ["angle = [1.0, 2.0]", "angle = [nan]", "angle = ['1']", "angle = [1.0]\nmore = 1"]
)
def test_a_file_of_measured_points_is_refused_if_it_is_not_finite_pairs(tmp_path, wrong):
    (tmp_path / "one.toml").write_text(
        f"[[reading]]\nquantity = 'spin'\nof = 'a'\nby = 'b'\nvalue = [1.0]\n{wrong}\n"
    )
    with pytest.raises(UsageError, match=r"one\.toml"):
        readings("one", tmp_path)


def test_a_finer_outline_keeps_its_corners_and_cuts_where_told():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    found = finer(square, np.array([1, 2, 4, 1]))
    assert found.tolist() == [
        [0, 0],
        [1, 0],
        [1, 0.5],
        [1, 1],
        [0.75, 1],
        [0.5, 1],
        [0.25, 1],
        [0, 1],
    ]


def test_the_return_map_of_the_belt_fills_intervals_and_that_of_the_logistic_map_is_a_fractal():
    belt = figure("1.31").numbers
    assert belt["box dimension at eta = 1.22"] == 1.0
    assert belt["box dimension there (1: no fractal)"] == 1.0
    exponent = belt["exponent at eta = 1.22, gamma = 2, linear law [1/s]"]
    assert exponent > 100 * belt["its standard error [1/s]"]
    logistic = figure("1.32").numbers
    value = next(number for what, number in logistic.items() if "3.5699" in what)
    assert abs(value - 0.538045) < 3 * logistic["its standard error"] < 0.05
    assert logistic["box dimension at eta = 4"] == 1.0
    # In the plane of (x, next x): on a curve for the belt, the same fractal for the map.
    for what, error in (
        ("box dimension of the points (x, next x) at eta = 1.22", "standard error of that"),
        ("box dimension of the points (x, next x) there (1: a curve)", "standard error of this"),
    ):
        assert abs(belt[what] - 1) < 3 * belt[error] < 0.1
    in_plane = logistic["box dimension of the points (x, next x) there"]
    assert abs(in_plane - 0.538045) < 3 * logistic["standard error of this"] < 0.1


def test_pairs_tell_the_fractal_from_the_belt():
    belt = figure("1.31").numbers
    for motion in ("gamma = 0.5, quadratic law", "gamma = 2, linear law"):
        what = f"correlation dimension at eta = 1.22, {motion}"
        large = belt[f"{what}, of distances from 1/8 to 1/128"]
        assert large < belt[f"{what}, from 1/128 to 1/2048"] < 1
        assert belt[f"{what}, of points (x, next x)"] > 0.8
    logistic = figure("1.32").numbers
    value = next(number for what, number in logistic.items() if "Procaccia" in what)
    assert abs(value - 0.500) < 3 * logistic["standard error of that"] < 0.05


def test_orders_of_summation_turn_bodies_apart_at_the_rate_of_eulers_equations():
    numbers = figure("summation-order").numbers
    rate = numbers["rate at which their angles grow [1/s]"]
    # omega sqrt((J2 - J1)(J3 - J2)/(J1 J3)) = 4 sqrt(1/8), by hand.
    assert rate == pytest.approx(np.sqrt(2), rel=1e-5)
    assert numbers["its standard error [1/s]"] < 1e-5
    assert rate < numbers["rate at which the certified bound S grows [1/s]"] < 1.02 * rate
    assert numbers["largest angle about the intermediate axis [rad]"] > 3


def test_centres_and_spins_about_a_stable_axis_agree_in_every_order_of_summation():
    numbers = figure("summation-order").numbers
    assert numbers["height that they fall [m]"] == pytest.approx(9.7 * 36**2 / 2)
    assert 0 < numbers["largest distance of their centres [m]"] < 1e-13
    assert 0 < numbers["largest angle about the third axis [rad]"] < 1e-13


def test_a_body_whose_opposite_torques_follow_each_other_never_turns_over():
    (about_second,) = fallen((1,), 36.0)
    q = about_second.attitude[:, 0]
    # Runge-Kutta steps do not keep the length of the quaternion.
    unit = q / np.linalg.norm(q, axis=1, keepdims=True)
    spins_along = rotated(unit, np.array([0.0, 1.0, 0.0]))
    assert np.abs(spins_along - spins_along[0]).max() < 1e-12
