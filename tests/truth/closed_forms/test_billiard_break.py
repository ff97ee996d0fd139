"""A break of billiards: held-out settings against an event-driven computation in decimals that
shares nothing with the truth, what has long been known of it, and how errors grow.
"""

import random
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import combinations, pairwise

import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth import impacts_in_balls
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import billiard_break
from tests.rationals import RandomFractions, text
from tests.truth.displaced_starts import largest_growth

CASE = discovery.case("billiard-break")
DIGITS = 120
"""Of the decimals; a break loses some ten of them."""
NEAR = Decimal(10) ** -40
SMALL = {"rows": "2"}


@contextmanager
def decimals() -> Iterator[None]:
    """Arithmetic of DIGITS digits."""
    with localcontext() as context:
        context.prec = DIGITS
        yield


def decimal(value: Fraction | str) -> Decimal:
    """A rational in the current decimals."""
    exact = Fraction(value)
    return Decimal(exact.numerator) / Decimal(exact.denominator)


class Disc:
    """A disc in the plane: mass, moment of inertia, radius, place, velocity and spin."""

    def __init__(self, mass, factor, radius, place, velocity, spin) -> None:
        self.mass = mass
        self.moment = factor * mass * radius * radius
        self.radius = radius
        self.x, self.y = place
        self.vx, self.vy = velocity
        self.spin = spin


def discs(given: dict[str, str]) -> list[Disc]:
    """Cue ball and rack at the start."""
    p = CASE.at(**given).p
    cue_mass, mass = (decimal(x) for x in p["masses"])
    cue_radius, radius = (decimal(x) for x in p["radii"])
    factor = decimal(p["inertia_factor"])
    reach = cue_radius + radius
    place = (-decimal(p["distance"]) * reach, decimal(p["offset"]) * reach)
    velocity = tuple(decimal(x) for x in p["velocity"])
    found = [Disc(cue_mass, factor, cue_radius, place, velocity, decimal(p["spin"]))]
    pitch = 2 * radius + decimal(p["gap"])
    nothing = Decimal(0)
    for row in range(int(p["rows"])):
        for k in range(row + 1):
            centre = (pitch * row * 7 / 8, pitch * (2 * k - row) / 2)
            found.append(Disc(mass, factor, radius, centre, (nothing, nothing), nothing))
    return found


def wait_for(a: Disc, b: Disc) -> Decimal | None:
    """The smaller root of the quadratic of the distance of two discs that come nearer."""
    dx, dy = b.x - a.x, b.y - a.y
    wx, wy = b.vx - a.vx, b.vy - a.vy
    speed_squared = wx * wx + wy * wy
    inwards = dx * wx + dy * wy
    beyond = dx * dx + dy * dy - (a.radius + b.radius) ** 2
    under_root = inwards * inwards - speed_squared * beyond
    if inwards >= 0 or under_root <= 0:
        return None
    return (-inwards - under_root.sqrt()) / speed_squared


def collide(a: Disc, b: Disc, e: Decimal, back: Decimal, mu: Decimal) -> None:
    """The impact of two discs, from the scalar impulses along the normal and the tangent."""
    distance = ((b.x - a.x) ** 2 + (b.y - a.y) ** 2).sqrt()
    nx, ny = (b.x - a.x) / distance, (b.y - a.y) / distance
    wx, wy = a.vx - b.vx, a.vy - b.vy
    closing = wx * nx + wy * ny
    # The tangent is the normal turned by a right angle: (-ny, nx).
    slip = -wx * ny + wy * nx + a.radius * a.spin + b.radius * b.spin
    ease = 1 / a.mass + 1 / b.mass
    tangential_ease = ease + a.radius**2 / a.moment + b.radius**2 / b.moment
    pressing = (1 + e) * closing / ease
    rubbing = -(1 + back) * slip / tangential_ease
    rubbing = max(-mu * pressing, min(mu * pressing, rubbing))
    for disc, sign in ((a, 1), (b, -1)):
        disc.vx += sign * (-pressing * nx - rubbing * ny) / disc.mass
        disc.vy += sign * (-pressing * ny + rubbing * nx) / disc.mass
        disc.spin += disc.radius * rubbing / disc.moment


def by_decimals(given: dict[str, str], times: list[Fraction]):
    """All impacts as (time, i, j), and the states of all discs at the times, which rise."""
    p = CASE.at(**given).p
    law = [decimal(p[name]) for name in ("restitution", "tangential_restitution", "friction")]
    all_discs = discs(given)
    impacts = []
    states = []
    waiting = [decimal(t) for t in times]
    now = Decimal(0)
    while True:
        coming = []
        for i, j in combinations(range(len(all_discs)), 2):
            wait = wait_for(all_discs[i], all_discs[j])
            if wait is not None:
                coming.append((wait, i, j))
        wait, i, j = min(coming, default=(None, 0, 0))
        while waiting and (wait is None or waiting[0] < now + wait):
            ahead = waiting.pop(0) - now
            states.append(
                [(d.x + d.vx * ahead, d.y + d.vy * ahead, d.vx, d.vy, d.spin) for d in all_discs]
            )
        if wait is None:
            return impacts, states
        for disc in all_discs:
            disc.x += disc.vx * wait
            disc.y += disc.vy * wait
        now += wait
        collide(all_discs[i], all_discs[j], *law)
        impacts.append((now, i, j))


def random_break(seed: int) -> dict[str, str]:
    """A break of 2 to 4 rows with any masses, radii, gap, aim, spin, and law."""
    rng = random.Random(seed)
    fractions = RandomFractions(rng)
    given = {
        "rows": str(rng.randint(2, 4)),
        "masses": text(fractions.list_of(2, 5, 20)),
        "radii": text(fractions.list_of(2, 3, 8)),
        "inertia_factor": rng.choice(["2/5", "1/2", "2/3", "1"]),
        "gap": str(fractions.between(1, 4) / 4),
        "distance": "5/2",
        "offset": str(rng.choice([-1, 1]) * Fraction(rng.randint(1, 13), 17)),
        "velocity": f"{2 + fractions.between(1, 9)},{fractions.between(-1, 1) / 4}",
        "restitution": str(Fraction(rng.randint(12, 16), 16)),
    }
    if seed % 2:
        given["friction"] = str(Fraction(rng.randint(1, 8), 16))
        given["spin"] = str(fractions.between(-20, 20))
        given["tangential_restitution"] = str(Fraction(rng.randint(0, 4), 4))
    return given


def between(times: list[Fraction]) -> list[Fraction]:
    """Times in all flights, and one after the last impact."""
    ends = [Fraction(0), *times, times[-1] + 1]
    return [early + (late - early) * Fraction(2, 5) for early, late in pairwise(ends)]


@pytest.mark.parametrize("seed", range(12))
def test_held_out_breaks_agree_with_decimals(seed: int) -> None:
    given = random_break(seed)
    truth = CASE.at(**given).truth()
    scalars = truth.scalars()
    count = int(scalars["impacts"].mid)
    times = between([scalars[f"impact_{k}"].mid for k in range(1, count + 1)])
    with decimals():
        impacts, states = by_decimals(given, times)
        assert count == len(impacts) >= 2
        for k, (when, i, j) in enumerate(impacts, start=1):
            assert abs(decimal(scalars[f"impact_{k}"].mid) - when) < NEAR
            assert scalars[f"impact_{k}_body"].mid == i
            assert scalars[f"impact_{k}_other"].mid == j
        for t, state in zip(times, states, strict=True):
            told = truth.at(t)
            for ball, numbers in enumerate(state):
                names = [f"r{ball}.x", f"r{ball}.y", f"v{ball}.x", f"v{ball}.y", f"omega{ball}.z"]
                for name, value in zip(names, numbers, strict=True):
                    if name in told:
                        assert abs(decimal(told[name].mid) - value) < NEAR


@pytest.mark.parametrize("given", [{}, {"friction": "1/4", "spin": "3"}])
def test_momentum_stays_and_energy_falls_by_what_the_impacts_lose(given: dict[str, str]) -> None:
    instance = CASE.at(**given)
    truth = instance.truth()
    scalars = truth.scalars()
    told = truth.at(scalars["last_impact_time"].mid + 1)
    balls = range(16)
    for axis, start in (("x", 1), ("y", 0)):
        total = sum((told[f"v{k}.{axis}"].mid for k in balls), Fraction(0))
        assert abs(total - start) < Fraction(1, 10**38)
    energy = sum((told[f"v{k}.{axis}"].mid ** 2 / 2 for k in balls for axis in "xy"), Fraction(0))
    before = Fraction(1, 2)
    # J = 2/5 m R^2 = 1/10.
    if given:
        energy += sum((told[f"omega{k}.z"].mid ** 2 / 20 for k in balls), Fraction(0))
        before += Fraction(9, 20)
    assert abs(before - energy - scalars["energy_lost"].mid) < Fraction(1, 10**38)


def test_equal_elastic_balls_part_at_a_right_angle() -> None:
    truth = CASE.at(restitution="1").truth()
    scalars = truth.scalars()
    t = (scalars["impact_1"].mid + scalars["impact_2"].mid) / 2
    told = truth.at(t)
    product = sum(told[f"v0.{axis}"].mid * told[f"v1.{axis}"].mid for axis in "xy")
    assert abs(product) < Fraction(1, 10**38)


def test_a_break_from_the_other_side_is_the_mirror_image() -> None:
    """Ball j of a row of n goes where ball n - 1 - j went, at -y."""
    one = CASE.at(rows="3", offset="1/8").truth()
    other = CASE.at(rows="3", offset="-1/8").truth()
    t = one.scalars()["last_impact_time"].mid + 1
    told = one.at(t)
    mirrored = other.at(t)
    for ball, image in enumerate((0, 1, 3, 2, 6, 5, 4)):
        for kind in "rv":
            x = told[f"{kind}{ball}.x"].mid - mirrored[f"{kind}{image}.x"].mid
            y = told[f"{kind}{ball}.y"].mid + mirrored[f"{kind}{image}.y"].mid
            assert max(abs(x), abs(y)) < Fraction(1, 10**38)


def test_the_order_of_impacts_that_nearly_coincide_is_decided_by_more_bits() -> None:
    """The apex, hit 1e-90 beside its centre, meets one neighbour 1e-90 s before the other."""
    p = CASE.at(**SMALL).p
    exact = {name: p[name] for name in billiard_break.SHAPING}
    impacts = billiard_break.impact_list({**exact, "offset": Fraction(1, 10**90)})
    with precision(256), pytest.raises(ValueError, match="no ball tells"):
        impacts.all()
    with precision(1024):
        _, second, third, *_ = impacts.all()
        assert [second.encounters[0].bodies, third.encounters[0].bodies] == [(1, 2), (1, 3)]
        assert 0 < third.wait < arb_of(Fraction(1, 10**80))


def test_a_graze_that_an_earlier_impact_prevents_does_not_matter() -> None:
    """On its way, undisturbed, the cue ball would just touch the outer ball of the third row."""
    given = {
        "rows": "4",
        "masses": "14/5,8/7",
        "radii": "1/2,4/9",
        "gap": "1/6",
        "distance": "5/2",
        "offset": "2/17",
        "velocity": "32/13,0",
        "restitution": "3/4",
    }
    (_, cue_y), *rack = billiard_break.centres(CASE.at(**given).p)
    assert Fraction(17, 18) in [y - cue_y for _, y in rack]
    scalars = CASE.at(**given).truth().scalars()
    with decimals():
        impacts, _ = by_decimals(given, [])
    assert scalars["impacts"].mid == len(impacts)


def test_a_graze_that_nothing_prevents_is_refused() -> None:
    """The cue ball touches the last ball of the rack on its way, and meets no other one."""
    with pytest.raises(UsageError, match="meet or pass each other is not decided"):
        CASE.at(rows="2", offset=str(Fraction(17, 32) + 1), distance="2")


def test_impacts_that_no_double_tells_apart_are_refused() -> None:
    with pytest.raises(UsageError, match="of one ball follow each other within"):
        CASE.at(rows="2", offset="1e-12")


def test_a_hit_whose_apex_meets_two_balls_at_one_time_is_refused() -> None:
    """The cue ball comes from below, and touches the apex where the axis of symmetry goes out."""
    with pytest.raises(UsageError, match="of which no ball tells which is the first"):
        CASE.at(velocity="1,1/2", offset="-1/2")


def test_at_an_impact_velocities_have_no_value() -> None:
    truth = CASE.at(**SMALL).truth()
    when = truth.scalars()["impact_2"].mid
    with pytest.raises(NotCertifiedError, match="jump") as caught:
        truth.at(when)
    assert caught.value.code == "jump"


def test_balls_that_pass_each_other_never_meet() -> None:
    encounter = billiard_break.BallsMayMeet(Fraction(1))
    with precision(128):
        still, passing = (
            billiard_break.Motion([arb_of(x) for x in r], [arb_of(x) for x in v], [])
            for r, v in (((0, 0, 0), (0, 0, 0)), ((-3, 2, 0), (1, 0, 0)))
        )
        assert encounter.time([still, passing]) is None
        grazing = billiard_break.Motion([arb_of(x) for x in (-3, 1, 0)], passing.v, [])
        with pytest.raises(impacts_in_balls.GrazingError) as caught:
            encounter.time([still, grazing])
        # It would be when the centres are nearest.
        assert caught.value.earliest.contains(3)
        meeting = billiard_break.Motion([arb_of(x) for x in (-3, 0, 0)], passing.v, [])
        wait = encounter.time([still, meeting])
        assert wait is not None
        assert wait.contains(2)


@pytest.mark.parametrize("given", [{}, {"friction": "1/8", "spin": "2"}, {"restitution": "1"}])
def test_no_start_that_is_displaced_a_little_goes_farther_than_s(given: dict[str, str]) -> None:
    instance = CASE.at(**SMALL, **given)
    truth = instance.truth()
    t = truth.scalars()["last_impact_time"].mid + Fraction(1, 3)
    observed = largest_growth(instance, Fraction(1, 10**15), t)
    s = truth.sensitivity(t)
    assert observed <= s * (1 + 1e-6)
    # The norm of S adds up the coordinates, of which one at a time is displaced.
    assert s <= 4 * observed * len(truth.state)


def test_lists_of_different_precisions_are_kept_apart() -> None:
    """A list that few bits gave is not handed out where more are asked for."""
    impacts = billiard_break.impact_list(CASE.at(**SMALL).p)
    radii = {}
    for bits in (128, 512):
        with precision(bits):
            last = impacts.all()[-1]
            radii[bits] = float(last.time.rad())
    assert radii[512] < radii[128] * 1e-100
    assert isinstance(impacts, impacts_in_balls.ImpactsInBalls)
