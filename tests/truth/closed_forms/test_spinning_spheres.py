"""Spheres that spin about any axes: rates against cross products of both bodies, whole contacts,
planted faults, honest ends.
"""

from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np
import pytest
from flint import arb

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres
from refdem.truth.closed_forms.two_spheres import NAMES
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.contact_phases import ball
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.system import Entry, Guard, Mode, Traced
from refdem.truth.spatial_phases import SpatialPhases, cross, dot, pointed
from refdem.truth.traced_field import Program, traced
from refdem.truth.witnesses.spinning_pair import Bodies, spinning
from refdem.truth.witnesses.taylor import Solution

SPUN = {"masses": "1,3", "radii": "1/2,3/4", "spins": "1,3,1,2,-1,3", "friction": "1/8"}
SLIDING = [
    SPUN | {"branch": branch, "angle": "1/3", "damping": "2"}
    for branch in ("R", "R-d", "R-d/2", "slip-R")
]
SPRUNG = SPUN | {"tangential_stiffness": "48", "damping": "2", "branch": "R-d"}
SPRUNG_TWO_LEVERS = SPRUNG | {"branch": "slip-R"}
WAYS = [(given, "slip", "slip") for given in SLIDING] + [
    (SPRUNG, "stick", "stick"),
    (SPRUNG, "slip", "clip"),
    (SPRUNG, "press", "free"),
    (SPRUNG_TWO_LEVERS, "stick", "stick"),
    (SPRUNG_TWO_LEVERS, "slip", "clip"),
]


def truth_of(given):
    return discovery.case("two-spheres").at(**given).truth()


def somewhere(found, its):
    """A state in the middle of a contact, in the truth's units and as the witness has it."""
    phases = found.phases
    pair = found.spheres
    way = [Fraction(-35, 37), Fraction(12, 37) * Fraction(3, 5), Fraction(-12, 37) * Fraction(4, 5)]
    apart = [part * (1 / phases.eps - Fraction(3, 8)) for part in way]
    moving = [Fraction(1, 4), Fraction(3, 8), Fraction(-1, 2)]
    spins = [Fraction(k, 7) for k in (3, -2, 5, 1, 4, -6)]
    side = cross(way, [Fraction(1), Fraction(2), Fraction(-1)])
    y = [*map(arb_of, [*apart, *moving, *spins, *side, 0])]
    if phases.kt:
        unit = pointed(y)[12:15]
        y[12:15] = unit
    else:
        y = [*y[:12], arb(0)]
    si = [value * arb_of(unit) for value, unit in zip(y, found.units(), strict=False)]
    shares = [arb_of(Fraction(m, 1) / sum(pair.masses)) for m in pair.masses[::-1]]
    both = [
        [part * (share if not i else -share) for part in si[:6]] + si[6 + 3 * i : 9 + 3 * i]
        for i, share in enumerate(shares)
    ]
    spring = [arb(0)] * 3
    if phases.kt:
        length = its.mu * its.force([*both[0], *both[1]]) / its.kt
        spring = [part * length for part in unit]
    return y, [*both[0], *both[1], *spring]


def rates_apart(given, mode, phase):
    """How far the rates of truth and witness are apart, of r, v and the spins; and of the spring's
    direction.
    """
    with precision(200):
        found = truth_of(given)
        its = Bodies(discovery.case("two-spheres").at(**given).p)
        y, s = somewhere(found, its)
        phases_ = found.phases
        whole = partial(its.rates, phase)
        if mode == "stick":
            size = its.mu * its.force(s) / its.kt / arb_of(phases_.length)
            y[12:15] = [part * size for part in y[12:15]]
        rates = Program(traced(phases_.modes()[mode].field, phases_.size)[0]).run(y)
        said = whole(arb(0), s)
        relative = (
            [a - b for a, b in zip(said[:6], said[9:15], strict=True)] + said[6:9] + said[15:18]
        )
        units = [arb_of(unit / phases_.time) for unit in found.units()]
        far = [abs(a * unit - b) for a, unit, b in zip(rates, units, relative, strict=False)]
        if phase == "clip":
            far += [
                abs(part)
                for part in (
                    a - b
                    for a, b in zip(
                        rates[12:15], turned(s[18:21], said[18:21], phases_.time), strict=True
                    )
                )
            ]
        if phase == "stick":
            far += [abs(a * units[0] - b) for a, b in zip(rates[12:15], said[18:21], strict=True)]
        return float(max(far).upper())


def turned(stretch, rate, time):
    """The rate of the direction of a stretch, in units of the truth's time."""
    size = dot(stretch, stretch).sqrt()
    along = dot(stretch, rate) / (size * size)
    return [(b - a * along) / size * arb_of(time) for a, b in zip(stretch, rate, strict=True)]


@pytest.mark.parametrize(("given", "mode", "phase"), WAYS)
def test_rates_are_those_of_both_bodies_with_cross_products(given, mode, phase):
    assert isinstance(truth_of(given), SpinningSpheres)
    assert rates_apart(given, mode, phase) < 1e-45


FAULTS = {
    "the slip without the second spin": (
        "slip",
        lambda s, y: WHOLE["slip"](s, [*y[:9], 0, 0, 0, *y[12:]]),
    ),
    "levers of full size": ("levers", lambda s, y: [1 + y[0] * 0, 1 + y[0] * 0]),
    "a normal of the start": ("normal", lambda s, y: [1 + y[0] * 0, y[0] * 0, y[0] * 0]),
    "a friction that pushes": (
        "limit",
        lambda s, y, towards: [-x for x in WHOLE["limit"](s, y, towards)],
    ),
    "a friction of the speed": ("sliding_friction", lambda s, y: s.limit(y, s.slip(y))),
    "a dashpot that is forgotten": ("force", lambda s, y: s.overlap(y) * s.k),
    "a spring that does not turn with the normal": ("turning", lambda s, y: [y[0] * 0] * 3),
    "a clipped spring that keeps its slip along": (
        "direction_rate",
        lambda s, y: [w * (s.kt / s.friction / s.force(y)) for w in s.slip(y)],
    ),
}
WHOLE = {name: getattr(SpatialPhases, name) for name in ("slip", "limit")}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_of_the_rates_is_seen(monkeypatch, fault):
    name, wrong = FAULTS[fault]
    monkeypatch.setattr(SpatialPhases, name, wrong)
    assert max(rates_apart(*way) for way in WAYS[1:6]) > 1e-6


def test_what_ends_a_phase_is_zero_where_the_witness_says():
    with precision(200):
        found = truth_of(SPRUNG)
        its = Bodies(discovery.case("two-spheres").at(**SPRUNG).p)
        y, s = somewhere(found, its)
        force = arb_of(found.spheres.effective_mass * found.phases.speed / found.phases.time)
        assert abs(ball(found.phases.force, y) * force - its.force(s)) < 1e-45
        lag = its.ends("clip")["stick"](s)
        steep = force / arb_of(found.phases.time)
        assert abs(ball(found.phases.lag, y) * steep - lag) < 1e-45
        limit = [
            *y[:12],
            *(
                part * (its.mu * its.force(s) / its.kt / arb_of(found.phases.length))
                for part in y[12:15]
            ),
            y[15],
        ]
        assert abs(ball(found.phases.spared, limit)) < 1e-45
        assert abs(its.ends("stick")["clip"](s)) < 1e-45


def test_a_whole_contact_is_that_of_the_witness():
    """At 64 bits, through the release; and what it does out of the plane is worth seeing."""
    instance = discovery.case("two-spheres").at(**SLIDING[2])
    found = instance.truth()
    motion = ContactMotion(TracedContact(found.phases), 64)
    motion.part()
    with precision(192):
        assert [event.name for event in motion.events] == ["pull", "release"]
        lasts = motion.events[-1].time * arb_of(found.phases.time)
        (_, ends), (_, end) = spinning(
            instance.p, [Fraction(1, 2)], {"duration": Fraction(float(lasts))}
        )
        assert abs(lasts - ends["duration"]) < 1e-12
        place = found.quantities(found.in_si(motion.place(found.clock(Fraction(1, 2)))))
        assert all(place[name].rad() < 1e-9 for name in NAMES)
        assert max(abs(place[name] - end[name]) for name in NAMES) < 1e-9
        assert abs(end["v1.z"]) > 0.01


def test_a_sample_within_the_contact_is_certified_to_40_digits_and_s_is_that_of_displaced_starts():
    found = truth_of(SLIDING[0])
    t = Fraction(1, 512)
    balls = found.at(t)
    assert max(balls[name].radius / Fraction(found.scale[name]) for name in NAMES) < Fraction(
        1, 10**40
    )
    p = discovery.case("two-spheres").at(**SLIDING[0]).p
    with precision(192):
        said = dict(
            zip(
                NAMES,
                Solution(partial(Bodies(p).rates, "slip"), Bodies(p).start(p)).at(t),
                strict=False,
            )
        )
        assert max(abs(said[name] - arb_of(balls[name].mid)) for name in NAMES) < 1e-38
        its = Bodies(p)
        sums = np.zeros(18)
        for axis, name in enumerate(NAMES):
            ends = []
            for sign in (1, -1):
                start = its.start(p)
                start[axis] += sign * arb_of(Fraction(found.scale[name])) * arb("1e-20")
                ends.append(Solution(partial(its.rates, "slip"), start).at(t)[:18])
            sums += [
                abs(float((a - b) / arb("2e-20") / arb_of(found.scale[n])))
                for n, a, b in zip(NAMES, *ends, strict=True)
            ]
    assert max(sums) <= found.sensitivity(t) <= 1.3 * max(sums)


@pytest.mark.parametrize("given", [SLIDING[0], SPRUNG])
def test_s_out_of_the_plane_is_no_less_than_what_displaced_truths_do(given):
    """13 unknowns, and 16 with a spring: columns for spins are differences of the truth itself."""
    found = truth_of(given)
    t = Fraction(3, 1024)
    tiny = Fraction(1, 10**18)
    plain = found.at(t)
    sums = dict.fromkeys(NAMES, 0.0)
    for axis in (1, 3):
        spins = list(found.spheres.spins)
        spins[axis] += tiny
        moved = replace(found, spheres=replace(found.spheres, spins=tuple(spins))).at(t)
        own = float(found.scale[f"omega{axis // 3 + 1}.{'xyz'[axis % 3]}"])
        for name in NAMES:
            slope = float((moved[name].mid - plain[name].mid) / tiny)
            sums[name] += abs(slope) * own / float(found.scale[name])
    assert max(sums.values()) <= found.sensitivity(t)


@pytest.mark.parametrize("given", [SLIDING[0], SPRUNG])
def test_where_the_motion_comes_near_a_point_that_may_not_be_analytic_it_ends_as_grazing(given):
    """The guard is zero at the faint slip, or force, and says so."""
    found = truth_of(given)
    guard = next(guard for guard in found.phases.modes()["slip"].guards if guard.name == "fade")
    with precision(100):
        y = [value() for value in found.phases.start()]
        assert ball(guard.value, y) > 0
        with pytest.raises(SwitchError) as caught:
            guard.then(y)
    assert (caught.value.code, caught.value.final) == ("grazing", True)


def test_what_comes_before_a_grazing_end_stays_certified_after_it_was_met():
    """A guard at t = 1 that cannot be passed."""
    stops = Guard("fade", lambda y: 1 - y[0], lambda y: SpatialPhases.fading(None, "it ends"))
    motion = HybridMotion(
        {"run": Traced(Mode(lambda y: [1, 1], (stops,)), 2)}, [arb(0), arb(0)], Entry("run"), 192
    )
    for late in (arb(2), arb(3)):
        with pytest.raises(SwitchError) as caught:
            motion.at(late)
        assert caught.value.code == "grazing"
        assert 0 < caught.value.state[-1] <= 1
        assert motion.at(arb("0.5"))[0].contains(arb("0.5"))


def test_the_honest_end_of_a_truth_that_is_singular_from_the_start():
    given = SPUN | {"damping": "0", "tangential_stiffness": "512", "friction": "1/64"}
    with pytest.raises(NotCertifiedError, match="singular") as caught:
        truth_of(given).at(Fraction(1, 64))
    assert caught.value.code == "singular"
    assert truth_of(given).at(Fraction(0))["omega1.y"].mid == 3
