"""Programs that are right raise no alarm at settings drawn over the whole range of the cases that
they support; each change of the tree draws others, by the seed that is printed.
"""

import os
import subprocess

import alarms
import pytest
from alarms import Count

from refdem.core import discovery
from refdem.core.parameters import labelled
from refdem.smoke.battery import smoke

PAIRS = 300
SECONDS = 60.0
"""Of one run: it judges fewer pairs on a slow machine."""
FEWEST = 20
"""Pairs that must have decided something, or the draws are no test."""

FORMER = [
    # Friction of 827 along a slip that is 0 but for a rounding, at every step.
    (
        "two-spheres[stiffness=41.1 closing_speed=0.0101 friction=827 duration=1.103 samples=16]",
        "soft",
        "dormand-prince",
    ),
    # Rounding is two thirds of the error at the finest step, and more of what that pair lacks.
    (
        "double-pendulum[masses=55.8,1.49 lengths=1.53,0.0119 gravity=9.69 theta0=-3.14,4.86"
        " thetadot0=1.71,-0.00255 duration=0.0005704 samples=16]",
        "rods",
        "rattle",
    ),
    # Velocities that are differences of places have their roundings, however slow the bodies are.
    (
        "two-spheres[masses=0.595,0.364 stiffness=2120 closing_speed=0.432"
        " spins=-282,-0.118,0.677,-83.5,0.174,-1.48 duration=0.03096 samples=16]",
        "multistep",
        "stoermer",
    ),
    # Terms of the error cancel at the coarsest step of three.
    (
        "quadratic-response[eps=0 drive=0.3,0.3 duration=1 samples=16]",
        "multistep",
        "adams-bashforth-moulton-4",
    ),
    # The first bounce comes 19 us after the end, and a scene that is elsewhere has it before.
    (
        "bouncing-ball[mass=1.45 spin=85 gravity=7.89 restitution=1 duration=0.712 samples=16]",
        "rigid-single",
        "late",
    ),
    # Spheres that are far from the origin beside their overlap, and velocities as differences of
    # their places.
    (
        "two-spheres[masses=5.05,0.488 stiffness=102 angle=0.442"
        " spins=-0.0039,6.26,-110,-0.993,-0.267,-0.379 branch=R cutoff=zero_force"
        " duration=0.1982 samples=16]",
        "multistep",
        "stoermer",
    ),
    # At the coarsest step the integration of the power hides a part of the error.
    (
        "driven-oscillator[mass=0.484 stiffness=7.53 gravity=-1.53 delta=0.0635 f0=-0.378"
        " drive=0.0356 x0=-0.0206 v0=-0.168 duration=0.2535 samples=16]",
        "soft-signs",
        "rk4",
    ),
    # A ball that may pass a much smaller neighbour within a step.
    (
        "newtons-cradle[balls=3 radii=1.36,0.364,211,0.241,0.0847,1.44,0.533"
        " velocities=-1.21,-4.56,2.65,0.82,1.15,-0.335,0.0178 duration=277.6 samples=16]",
        "rigid",
        "late",
    ),
    # Rods between bodies that lie nearly in a plane hardly fix their distances from it.
    (
        "rigid-cluster[masses=7.94,3.39,0.423,2.7 positions=-0.699,773,-0.4,11.1,-5.68,0.382,"
        "170,-0.223,0.614,-761,1.26,1.88 duration=0.8729 samples=16]",
        "rods",
        "rattle",
    ),
    # Velocities that are differences of places, after few steps that are 1e-4 of tau.
    (
        "driven-duffing[beta=-0.4 delta=0 duration=0.005696 samples=16]",
        "multistep",
        "stoermer",
    ),
    # A sample just after the second impact of a ball between two samples.
    (
        "billiard-break[masses=0.241,0.832 radii=2.09,1.33 offset=0.118"
        " tangential_restitution=0.819 friction=1.62 impacts=22 duration=5.346 samples=16]",
        "rigid",
        "late",
    ),
    # The bobs pass each other closely, and turn the spring faster than either swings.
    (
        "coupled-pendulums[masses=843,0.842 stiffness=3.84 theta0=0.956,-1.11"
        " thetadot0=0.935,-0.793 duration=0.5193 samples=16]",
        "rods",
        "rk4",
    ),
    # A way back whose round-off is that of a pivot 302 m away.
    (
        "coupled-pendulums[distance=302 stiffness=1.09 spring_length=316 theta0=2.79,-0.341"
        " duration=0.07937 samples=16]",
        "rods",
        "rattle",
    ),
    # A rod that turns fast at the start, and whips the lighter one round twice as fast.
    (
        "double-pendulum[masses=0.466,3.18 lengths=0.303,0.875 gravity=22.6 theta0=0.617,-0.523"
        " thetadot0=-51.1,-3.17 duration=0.04716 samples=16]",
        "rods",
        "rk4",
    ),
    # A spring whose ends pass close to each other: steps are not yet small beside that.
    (
        "coupled-pendulums[distance=0.409 gravity=91.9 stiffness=1.57 theta0=-87,-0.701"
        " thetadot0=-0.441,-0.229 duration=0.1904 samples=16]",
        "rods",
        "rk4",
    ),
    # A return whose order shows at steps that are finer than the levels alone.
    (
        "double-pendulum[masses=0.126,1.13 lengths=4.14,0.17 gravity=325 theta0=-0.0479,-1.37"
        " thetadot0=-0.105,-3.63 duration=0.07099 samples=16]",
        "rods",
        "rk4",
    ),
    # An angle of many turns, of which truth is printed to more than a run's round-off.
    (
        "double-pendulum[masses=0.0181,0.717 theta0=2.25,1470 duration=0.03506 samples=16]",
        "rods",
        "rattle",
    ),
    # Friction far above 1, which alternates by many times what a normal force moves.
    (
        "two-spheres[damping=12.1 friction=67.3 angle=0.0561 branch=R-d duration=0.1875"
        " samples=16]",
        "multistep-single",
        "adams-bashforth-2",
    ),
    (
        "two-spheres[damping=12.1 friction=67.3 angle=0.0561 branch=R-d duration=0.1875"
        " samples=16]",
        "soft-fused",
        "kick-drift",
    ),
    # A sphere of little inertia, whose spin shows the rounding of a tangential impulse.
    (
        "hard-spheres[inertia_factors=1,0.00063 duration=3 samples=16]",
        "rigid",
        "event-driven",
    ),
    # Small spheres far apart, whose line of motion is unstable once rounding has left it.
    (
        "newtons-cradle[balls=6 masses=0.779,1.01,0.488,0.00491,6.45,0.0038,4.9"
        " radii=6.19,0.29,0.0423,0.00457,0.0657,0.211,0.0516"
        " gaps=0.783,194,0.252,0.441,0.315,0.0806"
        " velocities=-0.331,0.0106,-0.00188,-96,0.0125,191,-0.056 duration=0.07367 samples=16]",
        "rigid-served",
        "event-driven",
    ),
    # One impact, seen by chance almost in time at the coarsest of three levels.
    (
        "newtons-cradle[balls=6 masses=0.779,1.01,0.488,0.00491,6.45,0.0038,4.9"
        " radii=6.19,0.29,0.0423,0.00457,0.0657,0.211,0.0516"
        " gaps=0.783,194,0.252,0.441,0.315,0.0806"
        " velocities=-0.331,0.0106,-0.00188,-96,0.0125,191,-0.056 duration=0.07367 samples=16]",
        "rigid",
        "moreau",
    ),
    # An impact soon after the start, seen a step late, leaves a place off by (1 + e) v h.
    (
        "hard-wall[radius=1.38 velocity=0.438,-669,-0.617 restitution=0.989 friction=0.386"
        " duration=0.006726 samples=16]",
        "rigid",
        "moreau",
    ),
    # Velocities from differences of places, in a picture that is shifted.
    (
        "hertz-spheres[effective_mass=0.103 stiffness=839 closing_speed=4.79 duration=0.06125"
        " samples=16]",
        "multistep",
        "stoermer",
    ),
    # An impact that comes a little before a sample in the run and a little after it in truth.
    (
        "billiard-break[rows=2 distance=-2 velocity=-1,0 restitution=0.938 duration=2.014"
        " samples=16]",
        "rigid",
        "late",
    ),
    # A sample at the impact itself, before it in one picture and after it in another.
    ("hard-spheres[offset=0,0 restitution=0 duration=1 samples=16]", "rigid", "late"),
    (
        "newtons-cradle[radii=0.000816,25.7,0.372,0.591,0.269,0.215,0.88 duration=0.75 samples=16]",
        "rigid",
        "event-driven",
    ),
    # A picture that rounds places by more than perturbed starts move them.
    (
        "newtons-cradle[balls=2 masses=0.482,1.06,82,2.31,0.402,0.964,0.00117"
        " radii=4.07,78.9,0.00191,2.43,0.906,1.74,0.0891"
        " gaps=0.121,0.142,0.0618,0.209,0.00198,12.3"
        " velocities=-0.0709,-9.54,-0.581,-46.6,0.109,-0.772,-1.59 duration=0.1018 samples=16]",
        "rigid-single",
        "moreau",
    ),
    # Friction that slows the mass faster than spring and drive move it.
    (
        "stick-slip[a=31.6 mu0=0.44 mu1=0.0166 lambda0=0.667 lambda1=0.00226 belt=505 gamma=-1.51"
        " eta=0.879 x0=1.59 v0=805 duration=1 samples=16]",
        "sliding",
        "moreau",
    ),
    # Static friction that fades within a step, which then jumps over the speeds that it holds.
    (
        "stick-slip[a=13.5 mu0=57.6 mu1=0.308 lambda0=0.732 lambda1=0.00931 friction_law=linear"
        " belt=-2.2 gamma=-0.251 eta=0.31 x0=0.00154 v0=3.04 duration=1 samples=16]",
        "sliding-single",
        "implicit-friction",
    ),
    # A belt that runs backwards: its pull is twice what holds the mass.
    (
        "stick-slip[a=0.598 mu0=0.0458 mu1=0.000111 lambda0=0.00294 lambda1=0.00785 belt=-55.7"
        " gamma=-0.387 eta=0.0535 x0=-1.28 v0=-0.202 duration=3 samples=16]",
        "sliding",
        "implicit-friction",
    ),
    # Work between samples that was off by more than the last two polynomials differ.
    (
        "van-der-pol[mu=0.318 p=8.9e-05 drive=0.973 x0=-2.79 duration=4.635 samples=16]",
        "soft-fused",
        "dormand-prince",
    ),
    # A graze: spheres pass each other in less than the time of a head-on contact.
    (
        "two-spheres[angle=1.5 closing_speed=10 duration=0.0143 samples=5]",
        "soft",
        "rk4",
    ),
    # Terms of a circular orbit that cancel on the way back at one step and not at the next.
    ("two-body-orbit[eccentricity=0 duration=10 samples=16]", "soft", "dormand-prince"),
    # An order that is read off two, four and eight steps, three of which are those of the start.
    (
        "two-body-orbit[duration=2.887 samples=16]",
        "multistep",
        "adams-bashforth-moulton-4",
    ),
    # Two levels above round-off, of which an impact leaves the coarser one a small error.
    (
        "newtons-cradle[radii=0.0641,4.43,0.143,1.2,0.331,1.55,0.0848"
        " velocities=-1.12,0.836,2.56,-0.95,-0.301,1.68,0.563 duration=0.1035 samples=16]",
        "rigid-single",
        "moreau",
    ),
    # A drive that carries the mass far out of its well.
    (
        "driven-duffing[alpha=1.3 beta=-0.235 delta=0.0452 f0=1440 drive=1.18 x0=-1.93 v0=0.533"
        " duration=0.2534 samples=16]",
        "soft",
        "drift-kick",
    ),
    (
        "driven-duffing[alpha=1.3 beta=-0.235 delta=0.0452 f0=1440 drive=1.18 x0=-1.93 v0=0.533"
        " duration=0.2534 samples=16]",
        "soft-fused",
        "dormand-prince",
    ),
    # A field that lends a slow body 470 times the energy that it had.
    ("asymmetric-field[mass=0.00161 x2=5.85 duration=0.4012 samples=16]", "soft", "drift-kick"),
    # Multistep weights may be negative: an impulse is no mean of the forces within its interval.
    (
        "two-spheres[angle=1.5 duration=0.0625 samples=16]",
        "multistep",
        "adams-bashforth-2",
    ),
    # A multistep method looks back over steps in which velocities still changed.
    ("two-spheres[duration=0.3 samples=32]", "multistep", "adams-bashforth-2"),
    # A multistep method starts with another rule, which has another error constant.
    ("two-body-orbit[duration=0.866 samples=16]", "multistep", "adams-bashforth-moulton-4"),
    # Terms that cancel at a step of which the half leaves but round-off.
    ("driven-duffing[f0=5.63 duration=2.141 samples=16]", "soft", "dormand-prince"),
    # An upper rod whose rate at the start is more than what the energy makes of both.
    (
        "double-pendulum[masses=2.36,1.38 theta0=13.6,-2.29 thetadot0=93.5,0.539 duration=0.1249"
        " samples=16]",
        "rods",
        "rk4",
    ),
    # A slender body: a rounding of its attitude is 278 of its spin.
    (
        "free-rigid-body[inertia=0.022,6.12,6.1 omega_body=-1.49,-403,-3.59"
        " attitude=46,-2.36,2.83,-11.3 duration=0.002481 samples=16]",
        "turning-single",
        "momentum-rk4",
    ),
    # A multistep start of a motion whose forces depend on velocities.
    (
        "van-der-pol[v0=-2.8 duration=0.6189 samples=16]",
        "multistep",
        "adams-bashforth-moulton-4",
    ),
    # A bob on a rod of 713 m moves by less in a step than its place is rounded by: every step is
    # rounded the same way.
    (
        "double-pendulum[masses=0.00352,0.638 lengths=713,0.948 gravity=3.41 theta0=0.0289,18.5"
        " thetadot0=-0.759,-1.18 duration=0.0001292 samples=16]",
        "rods-single",
        "rattle",
    ),
]
"""Settings, programs and methods that were accused once, each with the reason why it was wrong."""


def drawn(pairs: int, seed: int) -> Count:
    """Pairs judged with a seed that is printed."""
    print(f"repeat with: .venv/bin/python ci/fuzz/alarms.py --pairs {pairs} --seed {seed}")
    count = alarms.alarms(pairs, seed, SECONDS)
    print(count.summary())
    return count


def seed_of_tree() -> int:
    """A seed that every change of the tree changes, so that what a commit was tested with can be
    repeated; a random one outside of a repository.
    """
    asked = os.environ.get("REFDEM_ALARM_SEED")
    if asked is not None:
        return int(asked)
    tree = subprocess.run(
        ["git", "rev-parse", "HEAD^{tree}"], cwd=alarms.ROOT, capture_output=True, text=True
    )
    if tree.returncode == 0:
        return int(tree.stdout[:8], 16)
    return int.from_bytes(os.urandom(4), "big")


def test_right_programs_raise_no_alarm_at_settings_drawn_at_random() -> None:
    count = drawn(PAIRS, seed_of_tree())
    assert count.judged >= FEWEST
    assert count.outcomes["pass"] > count.judged
    assert count.alarms == []


def test_a_seed_draws_the_same_settings_again() -> None:
    first, again = (
        [instance.label for instance in alarms.settings_of(alarms.CASES, seed=3, count=5)]
        for _ in range(2)
    )
    assert first == again


PROBED = (
    "multistep-single",
    "rigid-single",
    "rods-single",
    "sliding-single",
    "soft-leapfrog-single",
    "soft-single",
    "turning-single",
)
"""Right programs that come nearest to the bounds of probes: those in single precision."""


@pytest.mark.parametrize("name", PROBED)
def test_the_probes_of_a_gate_accuse_no_right_program(name):
    (engine,) = [engine for engine in alarms.engines() if engine.name == f"right-{name}"]
    findings = smoke(engine)
    assert {finding.outcome for finding in findings} == {"pass", "unsupported"}
    parts = [f.value / f.bound for f in findings if f.outcome == "pass" and f.bound]
    assert len(parts) > 10
    # Far from the bound: a right program of another method has room as well.
    assert max(parts) < 0.5


@pytest.mark.parametrize(("label", "program", "method"), FORMER)
def test_a_right_program_that_was_accused_once_is_not_any_more(label, program, method):
    count = alarms.repeated(label, program, method, alarms.LEVELS, alarms.MOST_STEPS)
    assert count.judged == 1
    assert count.alarms == []


def test_an_image_of_a_run_at_a_tolerance_has_the_room_of_errors_that_a_jump_scatters():
    """Its errors at tolerances 1e-6, 1e-8 and 1e-10 are 2.6e-9, 1.3e-10 and 1.3e-12; a boost makes
    the steps as long as at a tolerance between the last two, and the error is 1.6e-9.
    """
    label = (
        "two-spheres[masses=0.00111,0.0704 radii=0.0577,3.64 damping=5.36 angle=1.5"
        " spins=-0.0105,0.00566,1.4,-0.524,1.25,-0.00114 cutoff=zero_force duration=0.0002039"
        " samples=16]"
    )
    count = alarms.repeated(label, "soft-adaptive", "adaptive", 4, 4000.0)
    assert count.outcomes["pass"] > 20
    assert count.alarms == []


FLAT = (
    "rigid-cluster[masses=0.289,5.61,1.9,1.07"
    " positions=0.114,0.307,1.09,-180,528,-0.292,-13.6,0.366,0.341,-36.6,-0.164,-0.644]"
)
"""Four points nearly in a plane: in single precision rounding spoils 0.5 % of each impulse."""


@pytest.mark.parametrize(
    ("label", "program", "are_solved"),
    [
        (FLAT, "rods", True),
        (FLAT, "rods-single", False),
        ("rigid-cluster", "rods-single", True),
        ("two-body-orbit", "rods-single", True),
    ],
)
def test_a_setting_at_which_rounding_spoils_the_impulses_of_rods_is_not_drawn(
    label, program, are_solved
):
    name, given = labelled(label)
    (engine,) = [engine for engine in alarms.engines() if engine.name == f"right-{program}"]
    instance = discovery.case(name).at(**given)
    assert alarms.are_rods_solved(instance, engine.method("rk4")) == are_solved
