"""The scripts without refdem show what the reasons of expected deviations say: where the cause is
varied, the effect follows.
"""

import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[3] / "validation/expected/deviations"
NUMBER = re.compile(r"(?<![\w^.-])-?\d+(?:\.\d+)?(?:e[+-]\d+)?(?![\w^])")


@cache
def printed(script: str) -> tuple[str, ...]:
    """The lines that a script prints, run alone."""
    done = subprocess.run(
        [sys.executable, SCRIPTS / script], check=True, capture_output=True, text=True, timeout=120
    )
    return tuple(done.stdout.splitlines())


def numbers(text: str) -> list[float]:
    """The numbers in a text, in their order; not those that are powers or parts of words."""
    return [float(found) for found in NUMBER.findall(text)]


def lines_of(script: str) -> Callable[[str], list[list[float]]]:
    """Gives the numbers behind a beginning, of all lines of a script that begin so."""

    def behind(beginning: str) -> list[list[float]]:
        found = [
            numbers(line.strip().removeprefix(beginning))
            for line in printed(script)
            if line.strip().startswith(beginning)
        ]
        assert found, beginning
        return found

    return behind


steps = lines_of("rebound_steps.py")
slope = lines_of("mujoco_slope.py")
units = lines_of("pymunk_units.py")
line = lines_of("rebound_line.py")
cone = lines_of("mujoco_cone.py")
sleep = lines_of("pymunk_sleep.py")
bounces = lines_of("rebound_bounces.py")


def test_the_step_of_ias15_grows_fourfold_until_a_sample_cuts_it() -> None:
    _, *grown, cut = steps("ias15 without forces, the first sample after")[0]
    assert grown == [0.001, 0.004, 0.016, 0.064, 0.256, 1.024]
    assert sum(grown) + cut == pytest.approx(3, abs=1e-3)


def test_rebound_is_exact_against_the_normal_where_the_overlap_is_seen() -> None:
    """The true normal is another, the more so the later it is seen."""
    late = steps("ias15,")
    assert [samples for samples, _, _ in late] == [8, 80, 800]
    true = [error for _, error, _ in late]
    assert true[0] > 5 * true[1] > 25 * true[2] > 1e-3
    assert max(error for _, _, error in late) < 1e-15


@pytest.mark.parametrize("beginning", ["leapfrog, steps of", "cradle, leapfrog, steps of"])
def test_with_leapfrog_an_impact_is_late_by_the_step(beginning: str) -> None:
    found = [(step, error) for step, error, *_ in steps(beginning)]
    assert len(found) >= 3
    for (step, error), (smaller, less) in pairwise(found):
        assert error / less == pytest.approx(step / smaller, rel=0.35)


def test_the_cradle_of_ias15_is_off_by_as_much_as_samples_are_apart() -> None:
    few, more, many = (error for _, error in steps("cradle, ias15,"))
    assert few > 0.1
    assert few > 4 * more > 16 * many


def test_the_cradle_of_ias15_run_back_is_off_the_less_the_more_samples_cut_its_steps() -> None:
    """So it is with the steps of leapfrog, which sees impacts late as well."""
    few, more, many = (error for _, error in steps("cradle and back, ias15,"))
    assert 0.02 < few < 0.2
    assert few > 2 * more > 4 * many
    of_steps = [error for _, error in steps("cradle and back, leapfrog, steps of")]
    assert all(before > 3 * after for before, after in pairwise(of_steps))


def creep(name: str) -> list[float]:
    """The creep [mm/s] as shipped but for one setting, h = 2^-8 to 2^-13 s."""
    return slope(f"{name}:")[0]


def test_the_creep_as_shipped_stays_where_the_step_is_halved() -> None:
    shipped = creep("as shipped")
    assert shipped == sorted(shipped, reverse=True)
    assert shipped[-2] / shipped[-1] < 1.05
    assert creep("noslip 100") == pytest.approx(shipped, rel=0.01)


def test_the_creep_as_shipped_follows_time_constant_impedance_and_cone() -> None:
    """But for what is left with an impedance of 0.9999, which falls with the step."""
    rest = creep("solimp 0.9999")
    assert all(a / b > 1.6 for a, b in pairwise(rest))
    whole = creep("as shipped")[-1] - rest[-1]
    for constant in (0.01, 0.005):
        left = creep(f"solref {constant} s")[-1] - rest[-1]
        assert left / whole == pytest.approx(constant / 0.02, rel=0.05)
    soft = creep("solimp 0.9")[-1] - rest[-1]
    for impedance in (0.95, 0.99):
        left = creep(f"solimp {impedance}")[-1] - rest[-1]
        assert left / soft == pytest.approx((1 - impedance) / 0.1, rel=0.05)
    elliptic = creep("cone elliptic")
    assert elliptic[-1] < 0.35 * whole
    assert elliptic[-1] == pytest.approx(elliptic[-3], rel=0.01)
    assert creep("cone elliptic, noslip 100")[-1] < 0.4 * elliptic[-1]


def test_the_tuned_creep_falls_with_the_step() -> None:
    for integrator, part in (("Euler", 0.1), ("RK4", 0.2)):
        found = slope(f"{integrator}, h =")
        assert len(found) == 3
        for _, _, of_step in found:
            assert of_step == pytest.approx(part, rel=0.3)


def test_the_tuned_creep_has_two_causes() -> None:
    """The iterations of noslip, as 1/n, and a gain at the start, which a stop takes away."""
    gains = {"Euler": 0.018, "RK4": 0.17}
    for integrator, gain in gains.items():
        speeds = {}
        stopped = {}
        for noslip in (30, 100, 1000):
            found = slope(f"{integrator}, {noslip} iterations of noslip:")[0]
            _, _, speeds[noslip], stopped[noslip], _ = found
        assert speeds[1000] == pytest.approx(gain, rel=0.05)
        for few, many in ((30, 100), (100, 1000)):
            assert stopped[few] / stopped[many] == pytest.approx(many / few, rel=0.1)
        assert stopped[1000] < 0.6 * gain
    # Of the 100 iterations of the adapter it is most under Euler, and half under RK4.
    assert slope("Euler, 100 iterations of noslip:")[0][3] > 0.9 * 0.094
    assert slope("RK4, 100 iterations of noslip:")[0][3] < 0.6 * 0.18


def test_the_creep_under_euler_grows() -> None:
    (_, early), (_, late) = slope("Euler, at the end of")
    assert late > 1.2 * early


def test_at_the_first_sample_the_block_still_comes_to_rest_along_the_normal() -> None:
    for integrator in ("Euler", "RK4"):
        count, normal, down = slope(f"{integrator}, friction 0.9, after")[0]
        assert count == 16
        assert normal > 4 * down
    _, normal, down = slope("RK4, friction 0.75, after")[0]
    creeping = slope("RK4, h = 0.000488 s: creeps at")[0][0]
    assert normal > creeping > down


def test_hard_contacts_do_not_creep_and_throw_up_what_slides() -> None:
    for _, speed, _, _, free, count, _, _ in slope("hard contacts, h ="):
        assert speed < 1e-7
        assert free > 0.8 * count


def test_joints_of_pymunk_at_the_same_rate_move_the_same_in_other_units() -> None:
    found = units("units of")
    assert len(found) == 6
    # The last bit of a power is that of the machine's library, also in units of powers of 2.
    for _, default, same, whole, _ in found:
        assert default > 1e-2
        assert max(same, whole) < 1e-13


@pytest.mark.parametrize("search", ["direct", "line"])
def test_hardsphere_resolves_what_overlaps_and_approaches_at_the_end_of_a_step(search: str) -> None:
    """Spheres of diameter 1 m at 1 m/s do so for 1 s: in a part 1/h of the shots."""
    rows = line(f"{search}, step")
    assert [step for step, *_ in rows] == [0.5, 2, 4, 20]
    for step, meetings, found, bounced in rows:
        assert bounced == meetings * min(1, 1 / step)
        if search == "line":
            assert found == meetings


def test_what_line_finds_is_resolved_the_more_the_longer_the_spheres_overlap() -> None:
    """The time is the diameter over the speed; a resolver that goes back to the touch needs
    none.
    """
    for radius, speed, step, bounced in line("line, spheres of radius"):
        assert bounced == 40 * 2 * radius / speed / step
    assert line("line, resolved at the touch, step") == [[2, 40], [20, 40]]


def widths(beginning: str) -> list[tuple[float, float]]:
    """What is varied, and how far apart the least and the greatest change of energy are [m^2]."""
    found = []
    for varied, count, least, greatest in bounces(beginning):
        assert count == 16
        found.append((varied, greatest - least))
    return found


def test_bounces_in_mercurius_change_the_energy_by_a_part_that_falls_with_the_step() -> None:
    """Of either sign, and not where nothing bounces."""
    for (step, width), (smaller, less) in pairwise(widths("mercurius, step")):
        assert width / less == pytest.approx(step / smaller, rel=0.1)
    for _, _, least, greatest in bounces("mercurius, step"):
        assert least < -0.1 < 0.1 < greatest
    ((_, count, least, greatest),) = bounces("mercurius without bounces, step")
    assert count == 0
    assert -1e-3 < least <= greatest < 1e-3


def test_bounces_keep_the_energy_where_ias15_has_all_of_the_force_between_the_planets() -> None:
    """The farther out it takes over, and where it integrates alone."""
    switched = widths("mercurius, r_crit_hill")
    assert [distance for distance, _ in switched] == [6, 10, 20, 40]
    assert all(before > 2 * after for (_, before), (_, after) in pairwise(switched))
    assert switched[-1][1] < 1e-4
    assert widths("ias15, step")[0][1] < 1e-4


@pytest.mark.parametrize("kind", ["bounces", "no collisions"])
def test_whfast_attracts_hard_spheres_where_gravity_is_none(kind: str) -> None:
    """Only G = 0 lets them fly freely; leapfrog lets them."""
    (_, attracted), (_, free) = bounces(f"whfast, gravity none, {kind}, G =")
    assert attracted < -0.3
    assert free == 0
    assert [change for _, change in bounces(f"leapfrog, gravity none, {kind}, G =")] == [0, 0]


def test_a_pyramid_of_friction_brakes_less_on_the_diagonal_and_else_along_a_tangent() -> None:
    """The elliptic cone brakes by mu N, against the velocity, whatever the direction."""
    diagonal = 0.5**0.5
    pyramidal = {degrees: (part, off) for degrees, part, off in cone("pyramidal,")}
    for degrees, tangent in ((0, 0), (30, 0), (60, 90), (90, 90)):
        part, off = pyramidal[degrees]
        assert part == pytest.approx(1, abs=1e-3)
        assert degrees + off == pytest.approx(tangent, abs=0.1)
    assert pyramidal[45] == pytest.approx((diagonal, 0), abs=1e-3)
    elliptic = cone("elliptic,")
    assert [degrees for degrees, *_ in elliptic] == sorted(pyramidal)
    for _, part, off in elliptic:
        assert (part, off) == pytest.approx((1, 0), abs=1e-3)
    for beginning in ("pyramidal on the diagonal, h =", "pyramidal on the diagonal, mu ="):
        parts = [part for _, part in cone(beginning)]
        assert parts == pytest.approx([diagonal, diagonal], abs=1e-3)


def test_a_block_has_less_friction_down_the_diagonal_of_the_pyramid_than_a_tangent() -> None:
    """Turning the fall line or taking the elliptic cone changes it; turning the block does not."""
    diagonal = 0.5**0.5
    parts = {"pyramidal": [1, diagonal, 1], "elliptic": [1, 1, 1]}
    for name, expected in parts.items():
        found = cone(f"block, {name}, fall line at")
        assert [heading for heading, _ in found] == [0, 45, 90]
        assert [part for _, part in found] == pytest.approx(expected, abs=3e-3)
    assert cone("block turned by 45 degrees, along a tangent: c =") == [[1]]
    # It tends to 1/sqrt(2) as the step falls.
    (coarse_step, coarse), (fine_step, fine) = cone("block on the diagonal, h =")
    assert coarse == pytest.approx(diagonal, abs=2 * coarse_step)
    assert fine == pytest.approx(diagonal, abs=6 * fine_step)
    for beginning in ("block turned by 45 degrees, on", "block turned by 90 degrees, on"):
        assert cone(beginning)[0] == pytest.approx([diagonal], abs=3e-3)
    for _, part in cone("block on the diagonal, mu ="):
        assert part == pytest.approx(diagonal, abs=3e-3)


def test_the_expected_error_on_the_diagonal_is_that_of_the_lacking_friction() -> None:
    """s is too long by g (1 - c) mu cos a t^2/2, in units of the height of the block."""
    (part,) = (part for heading, part in cone("block, pyramidal, fall line at") if heading == 45)
    lacking = 9.8125 * (1 - part) * 0.5 * 0.8
    table = tomllib.loads((SCRIPTS.parent / "mujoco.toml").read_text())["expected"]
    rows = [row for row in table if "heading" in row["parameters"] and row["quantity"] == "s"]
    assert len(rows) == 1
    assert rows[0]["low"] < lacking * 0.5**2 / 2 / 0.25 < rows[0]["high"]


def test_a_pendulum_of_pymunk_falls_asleep_where_it_is_slow_for_longer_than_the_threshold() -> None:
    """At the start it is slow for half as long as where it turns round, on the other side."""
    seen = set()
    for time, *_, at_start, at_turn, slept, angle in sleep("asleep above"):
        if time < at_start:
            assert slept == pytest.approx(time, abs=2e-3)
            assert angle > 0.9
            seen.add("start")
        elif time < at_turn:
            assert 1 < slept < 1.2
            assert angle < -0.9
            seen.add("turn")
        else:
            assert slept == 0
            seen.add("awake")
    assert seen == {"start", "turn", "awake"}
    # As shipped.
    assert sleep("as shipped,")[0][-2] == 0
