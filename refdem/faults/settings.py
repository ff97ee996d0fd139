"""Settings on which faults act: cases with random dyadic parameters, drawn within bounds from a
seed.

Each is a short motion of about eight shortest times, so that all faults on all settings and seeds
take minutes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from refdem.faults.draws import (
    Rows,
    between,
    box_moments,
    computed,
    either,
    listed,
    parameters,
    signed,
    unequal,
)


@dataclass(frozen=True)
class Setting:
    """A case with random parameters.

    `methods` are those of the transparent engine that run it, or of another `engine` if the
    transparent one lacks an element of the scene. The checks get no truth unless `proved`.
    """

    case: str
    rows: Rows
    methods: tuple[str, ...]
    proved: bool = True
    engine: str = ""

    def parameters(self, name: str, seed: int) -> dict[str, str]:
        """The parameters of a seed, as text."""
        return parameters(self.rows, np.random.default_rng([seed, *name.encode()]))


def middle_amplitude(drive: float) -> complex:
    """The middle one of the three complex amplitudes A of harmonic balance for the case's own
    spring under the drive 3/2 cos(w t), with x = Re(A exp(i w t)) (1.120).

    S = |A|^2 solves h^2 S^3 + 2 h g S^2 + (g^2 + 4 delta^2 w^2) S = f0^2, g = alpha - w^2.
    """
    alpha, h, delta, force = 1.0, 0.75 * 0.4, 0.1, 1.5
    g = alpha - drive**2
    roots = np.roots([h * h, 2 * h * g, g * g + (2 * delta * drive) ** 2, -force * force])
    _, middle, _ = sorted(roots.real)
    # A = f0/(g + h S + 2 i delta w).
    return force / complex(g + h * middle, 2 * delta * drive)


def lasting(duration: str, samples: str) -> Rows:
    """Rows for the duration [s] and the number of samples."""
    return (("duration", duration), ("samples", samples))


# Free bodies.
TUMBLER: Rows = (
    ("omega_body", listed(*3 * [signed(0.5, 1.25)])),
    ("attitude", listed(between(1, 4, 1), *3 * [signed(1, 4, 1)])),
    ("inertia", box_moments),
    *lasting("6", "32"),
)
"""A free body with three different moments, an angular velocity along no principal axis, and any
attitude.
"""
FLIPPER: Rows = (
    ("offset", between(1 / 16, 1 / 8, 128)),
    ("direction", either("1", "3")),
    *lasting("24", "48"),
)
"""A body that turns over once about its intermediate axis."""
FLYER: Rows = (
    ("velocity", listed(*3 * [signed(0.25, 1)])),
    ("spin", between(0.75, 1.5)),
    *lasting("8", "32"),
)
"""A free body that flies straight and spins steadily."""
RESTING: Rows = (("member", "spheres"), ("duration", between(0.25, 0.5)), ("samples", "16"))
"""Two spheres in elastic balance."""

# Pendulums, tops, hooks and strings.
SWING: Rows = (
    ("mass", between(0.5, 3)),
    ("length", between(0.5, 2)),
    ("gravity", between(4, 12)),
    ("theta0", signed(0.75, 1.75)),
    ("thetadot0", between(-0.5, 0.5)),
    *lasting("3", "32"),
)
"""A pendulum that swings."""
CIRCLER: Rows = (
    ("mass", between(0.5, 3)),
    ("length", between(1, 2)),
    ("gravity", between(1, 2)),
    ("theta0", between(-1, 1)),
    ("thetadot0", signed(4, 5)),
    *lasting("2", "32"),
)
"""A pendulum that rotates over the top."""
ABOVE: Rows = (
    ("length", between(0.75, 1.5, 64)),
    ("gravity", between(4, 8, 64)),
    ("_quarters", signed(0, 0.03125, 64)),
    ("delta", computed(lambda drawn: drawn["_quarters"] / 4 + Fraction(1, 512))),
    *lasting("1", "16"),
)
"""A pendulum that leaves its upper equilibrium."""
BELOW: Rows = (*ABOVE, ("position", "bottom"), *lasting("4", "32"))
"""A pendulum near its lower equilibrium."""
CHAIN: Rows = (
    ("theta0", listed(*2 * [signed(0.5, 0.75, 64)])),
    ("masses", listed(between(2, 4, 64), between(0.25, 0.5, 64))),
    *lasting("3/2", "12"),
)
"""A double pendulum at amplitudes well below chaos."""
CHAOTIC_CHAIN: Rows = (
    ("theta0", "3,3"),
    ("thetadot0", listed(*2 * [signed(0, 0.125, 64)])),
    ("gravity", between(9, 10.5)),
    *lasting("5", "96"),
)
"""A double pendulum with equal bobs and rods, at angles at which it is known to be chaotic."""
COUPLED: Rows = (
    ("theta0", listed(signed(0.5, 0.75, 64), signed(0.125, 0.25, 64))),
    ("masses", listed(between(2, 4, 64), between(0.5, 1, 64))),
    ("stiffness", between(4, 8, 64)),
    *lasting("3/2", "12"),
)
"""Two pendulums of different masses, coupled by a spring."""
TOP: Rows = (
    ("mass", between(0.75, 1.25, 64)),
    ("length", between(0.375, 0.5, 64)),
    ("theta0", between(0.5, 1.25, 64)),
    ("phidot0", signed(1, 2, 64)),
    ("thetadot0", signed(0.5, 1, 64)),
    ("spin", signed(5, 8, 64)),
    ("inertia", listed(between(0.5, 0.625, 64), between(0.25, 0.375, 64))),
    *lasting("3/2", "12"),
)
"""A symmetric top with nutation and precession."""
CAPTURED: Rows = (
    ("speed", between(0.75, 1.25, 64)),
    ("radius", between(0.75, 1.25, 64)),
    ("mass", between(0.5, 2, 64)),
    ("duration", computed(lambda drawn: 6 * drawn["radius"] / drawn["speed"])),
    ("samples", "32"),
)
"""A mass that a hook catches, and half a revolution or more about it."""
MACHINE: Rows = (
    ("mass", between(0.5, 1.5, 64)),
    ("counter_mass", computed(lambda drawn: 3 * drawn["mass"])),
    ("wheel_radius", "0"),
    ("wheel_inertia", "0"),
    ("theta0", signed(1, 1.5, 64)),
    ("rdot0", between(0, 0.5, 64)),
    ("gravity", between(4, 8, 64)),
    ("r0", between(1, 1.5, 64)),
    *lasting("1", "16"),
)
"""Swinging Atwood's machine in its integrable case: a wheel without radius, and a counterweight of
three times the mass of the pendulum.
"""

# Springs, dashpots, drives and dry friction.
OSCILLATOR: Rows = (
    ("mass", between(0.5, 2)),
    ("stiffness", between(0.5, 2)),
    ("x0", signed(0.5, 2)),
    ("v0", between(-1, 1)),
    *lasting("8", "32"),
)
"""A mass on a spring."""
HANGING: Rows = (*OSCILLATOR, ("gravity", signed(0.5, 1.5)))
"""The same in gravity."""
VISCOUS: Rows = (*OSCILLATOR, ("delta", between(0.125, 0.375)))
"""The same in a fluid, below critical damping."""
FAR: Rows = (
    *OSCILLATOR,
    ("mass", "1"),
    ("stiffness", "1"),
    ("gravity", "1024"),
    ("_away", signed(0.5, 1)),
    ("x0", computed(lambda drawn: 1024 + drawn["_away"])),
)
"""A mass that swings about a point 1000 times as far from the origin as its amplitude."""
LONG_OSCILLATOR: Rows = (
    ("x0", between(0.5, 1.5, 64)),
    ("v0", between(-1, 1, 64)),
    *lasting("112", "64"),
)
"""An oscillator over more than a hundred shortest times, for exponents of growth."""
DRIVEN: Rows = (
    ("mass", between(1.5, 2)),
    ("stiffness", between(1, 2)),
    ("f0", between(0.75, 1.5)),
    ("delta", "0"),
    ("drive", between(1.5, 2)),
    *lasting("8", "32"),
)
"""A periodic force on a heavy mass, without damping, away from resonance."""
HARDENING: Rows = (
    ("alpha", between(0.75, 1.5)),
    ("beta", between(0.25, 0.5)),
    ("amplitude", signed(0.5, 1)),
    *lasting("6", "32"),
)
"""A spring with a cubic term."""
LOPSIDED: Rows = (
    ("eps", signed(0.125, 0.25)),
    ("x0", signed(0.5, 1)),
    ("delta", "0"),
    ("f0", "0,0"),
    *lasting("6", "32"),
)
"""A spring with a quadratic term, released from rest, without damping and drive."""
LOPSIDED_DOWN: Rows = (
    *LOPSIDED,
    ("_down", between(0.125, 0.25)),
    ("eps", computed(lambda drawn: -drawn["_down"])),
)
"""The same with a negative quadratic coefficient."""
MIXING: Rows = (
    ("eps", signed(0.125, 0.25)),
    ("delta", "1/4"),
    ("f0", listed(between(0.1875, 0.3125), between(0.1875, 0.3125))),
    ("drive", "1/2,4/5"),
    ("x0", signed(0.125, 0.25)),
    *lasting("32", "64"),
)
"""A damped spring with a quadratic term under two drives, long enough to resolve the lines at sums
and differences of their frequencies.
"""
TRIPLING: Rows = (
    ("beta", between(0.25, 0.5, 64)),
    ("delta", "1/4"),
    ("f0", between(0.375, 0.5, 64)),
    ("drive", "1/2"),
    ("x0", signed(0.125, 0.25)),
    *lasting("32", "64"),
)
"""A damped spring with a cubic term under a drive, long enough to resolve the third harmonic."""
MIDDLE: Rows = (
    ("drive", between(112 / 64, 118 / 64, 64)),
    ("_balanced", computed(lambda drawn: middle_amplitude(float(drawn["drive"])))),
    ("x0", computed(lambda drawn: Fraction(round(64 * drawn["_balanced"].real), 64))),
    (
        "v0",
        computed(lambda drawn: Fraction(-round(64 * drawn["drive"] * drawn["_balanced"].imag), 64)),
    ),
    *lasting("12", "48"),
)
"""Duffing's oscillator under a drive between its folds, started near the middle one of three
amplitudes, which is unstable.
"""
STEEP: Rows = (
    ("mass", between(0.5, 2)),
    ("stiffness", between(0.5, 2)),
    ("amplitude", signed(0.5, 2)),
    *lasting("6", "32"),
)
"""A spring whose force is the power 3/2 of its stretch."""
CYCLE: Rows = (
    ("mu", between(0.25, 0.5)),
    ("p", between(0.25, 0.5)),
    ("x0", between(1, 1.5)),
    *lasting("6", "24"),
)
"""Van der Pol's oscillator as it approaches its limit cycle."""
CYCLE_AND_DRIVE: Rows = (
    ("mu", "1/5"),
    ("p", between(0.0625, 0.09375, 256)),
    ("x0", "2"),
    *lasting("128", "256"),
)
"""Van der Pol's oscillator on its limit cycle, under a drive that is too weak to lock it."""
RUBBING: Rows = (
    ("stiffness", between(0.75, 2)),
    ("_stretch", between(0.75, 1.5)),
    ("_half_cycles", between(2, 4, 1)),
    ("mass", between(0.75, 1.5)),
    ("_side", either(-1, 1)),
    ("x0", computed(lambda drawn: drawn["_side"] * drawn["_stretch"])),
    ("_share", computed(lambda drawn: 1 / (2 * drawn["_half_cycles"]) + Fraction(1, 128))),
    ("friction_force", computed(lambda d: d["stiffness"] * d["_stretch"] * d["_share"])),
    *lasting("20", "64"),
)
"""A mass on a spring that friction stops after two to four half cycles, with parameters well away
from those at which their number changes.
"""
STICKING: Rows = (
    ("eta", between(1, 1.5)),
    ("gamma", between(0.375, 0.75)),
    ("x0", between(0.75, 1.25)),
    ("mu0", between(0.375, 0.4375)),
    ("mu1", "1/8"),
    ("lambda0", between(1.25, 1.5)),
    ("lambda1", "1/64"),
    *lasting("8", "32"),
)
"""A driven mass on a belt that sticks and slips again."""

# Fields.
ORBIT: Rows = (
    ("gm", between(0.75, 1.5)),
    ("eccentricity", between(0.0625, 0.375)),
    *lasting("6", "32"),
)
"""About one revolution about a centre of attraction."""
ELLIPSE: Rows = (*ORBIT, ("stiffness", between(0.75, 1.5)))
"""About one revolution on a spring."""
TENT: Rows = (
    ("mass", between(0.75, 1.5)),
    ("k1", between(0.75, 1.5)),
    ("x2", between(0.375, 0.625)),
    ("v0", between(1, 1.5)),
    ("samples", "32"),
)
"""A particle that crosses an asymmetric field from left to right."""
WEDGE: Rows = (
    ("mass", between(0.75, 1.25)),
    ("k1", between(1.5, 2.5)),
    ("k2", between(10, 14)),
    ("closing_speed", between(0.875, 1.25)),
    ("samples", "32"),
)
"""A wedge that loses about half of its energy."""

# Spheres that collide.
UNEQUAL: Rows = (
    ("stiffness", between(96, 192, 1)),
    ("closing_speed", between(0.75, 1.25)),
    ("masses", unequal(0.75, 1.25)),
    ("radii", unequal(0.375, 0.625)),
    ("samples", "16"),
)
"""Two unequal spheres."""
KNOCK: Rows = (("damping", between(2, 4)), *UNEQUAL)
"""A damped head-on collision whose contact ends at zero overlap."""
PARTING: Rows = (*KNOCK, ("cutoff", "zero_force"))
"""A damped head-on collision whose contact ends at zero force."""
BOUNCE: Rows = (("damping", "0"), *UNEQUAL)
"""A head-on collision without damping."""
SPINS = listed(*2 * [lambda rng, drawn: f"0,0,{between(-0.125, 0.125)(rng, drawn)}"])
"""Slow spins about z."""
SCRAPE: Rows = (
    ("_side", either(-1, 1)),
    ("damping", between(0.5, 1)),
    ("friction", between(0.0625, 0.09375)),
    ("_steep", between(0.95, 1.1)),
    ("angle", computed(lambda drawn: drawn["_side"] * drawn["_steep"])),
    ("spins", SPINS),
    *UNEQUAL,
)
"""An oblique collision with gross sliding; the levers add up to the distance of the centres."""
SCRAPE_SHORT: Rows = (*SCRAPE, ("branch", "R-d"))
"""The same with the radius minus the overlap as lever."""
SCRAPE_TWO_LEVERS: Rows = (*SCRAPE, ("branch", "slip-R"))
"""The same with slip at the radius, and torque at the radius less half of the overlap."""
BRISTLE: Rows = (*SCRAPE, ("damping", "0"), ("tangential_stiffness", between(80, 128, 1)))
"""Gross sliding with a tangential spring that is at Coulomb's limit from the start."""
STICKER: Rows = (
    *SCRAPE,
    ("tangential_stiffness", between(80, 128, 1)),
    ("friction", "1"),
    ("angle", "1/4"),
    ("damping", "0"),
)
"""An oblique collision whose tangential spring sticks, then slides."""
HOLD_TWO_LEVERS: Rows = (*STICKER, ("branch", "slip-R"))
"""The same with slip at the radius, and torque at the radius less half of the overlap."""
GRIPPER: Rows = (*STICKER, ("spins", "0,0,1,0,0,3/4"))
"""The same with spins that add to the slip."""
TUMBLING_SPHERES: Rows = (
    *STICKER,
    ("spins", listed(*6 * [signed(1, 2)])),
    ("damping", "1/2"),
)
"""The same with spins about all axes, so that the spring leaves the plane."""
SPINNER: Rows = (
    ("_side", either(-1, 1)),
    ("_slow", between(0.25, 0.5)),
    ("_fast", between(4, 6)),
    ("spins", computed(lambda d: f"0,0,{-d['_side'] * d['_slow']},0,0,{d['_side'] * d['_fast']}")),
    ("damping", "0"),
    ("friction", between(0.0625, 0.125)),
    *UNEQUAL,
)
"""A head-on collision: sphere 2 spins so fast that it slides throughout, sphere 1 slowly in the
opposite direction.
"""
SOFT: Rows = (
    ("_soft", between(2, 4)),
    ("_slow", between(0.75, 0.875)),
    ("friction", between(0.125, 0.1875)),
    ("angle", signed(1.15, 1.2)),
    ("damping", "0"),
    *UNEQUAL,
    ("stiffness", computed(lambda drawn: drawn["_soft"])),
    ("tangential_stiffness", computed(lambda drawn: drawn["_soft"] / 4)),
    ("closing_speed", computed(lambda drawn: drawn["_slow"])),
)
"""Gross sliding of soft spheres, whose normal rotates far while the tangential spring acts."""
SCRAPE_LONG: Rows = (*SOFT, ("branch", "R"), ("tangential_stiffness", "0"))
"""Gross sliding of soft spheres with the radius as lever."""
ALONG_WALL: Rows = (
    ("member", "co-4"),
    ("tangential_stiffness", "0"),
    ("friction", between(0.0625, 0.125, 128)),
    ("angle", signed(0.875, 1.125)),
    ("samples", "16"),
)
"""A sphere that slides along a wall throughout its contact, without a tangential spring."""
CLASH: Rows = (
    ("masses", unequal(0.75, 1.25)),
    ("radii", unequal(0.375, 0.625)),
    ("inertia_factors", listed(between(0.3125, 0.4375), between(0.5, 0.625))),
    ("closing_speed", between(0.75, 1.25)),
    ("restitution", between(0.5, 0.75)),
    ("offset", listed(signed(0.5, 0.625), between(-0.25, 0.25))),
    ("samples", "16"),
)
"""An oblique collision of two unequal rigid spheres without friction."""
ELASTIC: Rows = (*CLASH, ("restitution", "1"))
"""The same without loss of energy."""
SPUN_CLASH: Rows = (*CLASH, ("spins", listed(*6 * [signed(0.5, 1)])))
"""The same with spins about all axes."""
RUB: Rows = (
    *CLASH,
    ("spins", listed(*6 * [signed(4 / 128, 8 / 128, 128)])),
    ("friction", between(4 / 256, 6 / 256, 256)),
)
"""The same with slow spins, and friction at Coulomb's limit that does not stop the slip."""
GRIP: Rows = (*SPUN_CLASH, ("friction", "8"), ("tangential_restitution", between(0.375, 0.625)))
"""The same with friction that reverses part of the slip."""
REBOUND: Rows = (
    ("mass", between(0.75, 1.5)),
    ("restitution", between(0.5, 0.75)),
    ("normal", listed(between(-0.25, 0.25), between(1, 2), between(-0.25, 0.25))),
    ("velocity", listed(signed(0.625, 0.75), between(-1, -0.75), between(-0.25, 0.25))),
    ("spin", listed(*3 * [signed(4 / 128, 8 / 128, 128)])),
    ("friction", between(4 / 256, 6 / 256, 256)),
    ("samples", "16"),
)
"""A rigid sphere that slides along a wall during its impact."""
CORNER: Rows = (
    ("mass", between(0.75, 2)),
    ("sides", listed(between(1, 1.25), between(0.75, 0.875))),
    ("angle", between(0.4375, 0.625)),
    ("height", between(1, 1.5)),
    ("velocity", listed(signed(0.125, 0.375), between(-1.25, -0.75))),
    ("restitution", between(0.625, 0.875)),
    ("samples", "16"),
)
"""A box that hits a plane with one corner and rotates away."""
ELASTIC_CORNER: Rows = (*CORNER, ("restitution", "1"))
"""The same without loss of energy."""
CRADLE: Rows = (
    ("balls", "3"),
    ("masses", listed(between(2, 3), between(0.5, 0.75), between(2, 3), *4 * [between(1, 1)])),
    ("gaps", listed(*6 * [between(0.25, 0.375)])),
    ("velocities", listed(between(1, 1.25), *6 * [between(0, 0)])),
    ("restitution", between(0.75, 0.875)),
    *lasting("5/4", "16"),
)
"""A light ball that bounces between two heavy ones."""
BREAK: Rows = (
    ("rows", "2"),
    ("masses", listed(between(1.25, 2), between(0.75, 1))),
    ("gap", between(0.1875, 0.3125)),
    ("offset", signed(0.125, 0.375)),
    ("velocity", listed(between(1, 1.5), between(0, 0))),
    ("restitution", between(0.625, 0.75)),
    ("impacts", "4"),
    ("samples", "24"),
)
"""A heavy cue ball that breaks a rack of three, off its axis of symmetry."""
ELASTIC_CRADLE: Rows = (*CRADLE, ("restitution", "1"))
"""The same without loss of energy."""
DROP: Rows = (
    ("mass", between(0.75, 1.5)),
    ("height", between(1, 2)),
    ("velocity", listed(signed(2, 3), between(-1, 1))),
    ("gravity", between(4, 8)),
    ("restitution", between(0.625, 0.75)),
    ("friction", between(4 / 64, 8 / 64, 64)),
    ("bounces", "3"),
    ("samples", "16"),
)
"""A ball that is thrown sideways and slides in its first bounces."""
ELASTIC_DROP: Rows = (*DROP, ("restitution", "1"), ("friction", "0"))
"""The same without friction and without loss of energy."""
SPINNING_DROP: Rows = (
    *DROP,
    ("friction", "0"),
    ("spin", signed(1, 2)),
    ("radius", between(0.375, 0.75)),
)
"""The same without friction for a spinning ball."""
SMOOTH_REBOUND: Rows = (*REBOUND, ("friction", "0"))
"""A rigid sphere that meets a smooth wall."""
SKID: Rows = (
    ("mass", between(0.75, 1.5)),
    ("radius", between(0.375, 0.75)),
    ("inertia_factor", either("1/4", "3/8", "1/2", "1")),
    ("_side", either(-1, 1)),
    ("_fast", between(2, 3)),
    ("_turn", between(1, 2.5)),
    ("speed", computed(lambda drawn: drawn["_side"] * drawn["_fast"])),
    ("spin", computed(lambda drawn: drawn["_side"] * drawn["_turn"])),
    ("friction", between(0.1875, 0.3125)),
    ("gravity", between(4, 8)),
    ("samples", "16"),
)
"""A round body on a level plane that slides with R omega < v and rolls in the end. Its centre never
comes to rest, neither with the right friction nor with a faulty one against the centre's velocity.
"""
RAMP: Rows = (
    *SKID,
    ("friction", between(0.375, 0.5)),
    ("slope", between(0.625, 0.6875)),
    ("spin", computed(lambda drawn: -drawn["_turn"])),
    ("speed", computed(lambda drawn: -drawn["_fast"] / 4)),
)
"""The same, thrown up a slope that is too steep for a block to rest; it rolls down."""
CHUTE: Rows = (
    *SKID,
    ("inertia_factor", "1"),
    ("friction", between(0.1875, 0.3125)),
    ("slope", between(1, 1.25)),
    ("speed", computed(lambda drawn: -drawn["_fast"])),
    ("spin", computed(lambda drawn: -drawn["_turn"])),
)
"""A ring thrown up a slope that is too steep for rolling, so that friction changes its sign."""
HERTZ: Rows = (
    ("effective_mass", between(0.5, 2)),
    ("stiffness", between(500, 1500)),
    ("closing_speed", between(0.5, 2)),
    ("samples", "32"),
)
"""Two Hertzian spheres."""
GAS: Rows = (
    ("n", "1000"),
    ("contact", "rigid"),
    ("restitution", between(48 / 64, 56 / 64, 64)),
    ("seed", between(1, 10_000, 1)),
    *lasting("16", "8"),
)
"""A thousand rigid spheres in a periodic box, which cool during about five collisions of each."""

# Maps, billiards and outlines.
CHAOTIC_MAP: Rows = (("eta", "4"), ("x0", between(5 / 64, 59 / 64, 64)), ("n", "48"))
"""The logistic map at eta = 4, from starts for which its slope is not small for long."""
GROWTH: Rows = (
    ("form", "ode"),
    ("eta", between(0.25, 1, 64)),
    ("x0", between(2 / 64, 0.25, 64)),
    ("n", "12"),
)
"""The logistic equation from a small initial value."""
LORENZ: Rows = (
    ("sigma", between(8, 12, 16)),
    ("rho", between(24, 32, 16)),
    ("_half", between(1280, 1535, 1)),
    ("beta", computed(lambda drawn: f"{2 * drawn['_half'] + 1}/1024")),
    ("start", listed(signed(2, 6, 16), signed(2, 6, 16), between(12, 20, 16))),
    ("n", "24"),
)
"""Lorenz' equations near his own parameters, started off the z axis."""
CHAOTIC_LORENZ: Rows = (
    ("start", listed(signed(2, 6, 16), signed(2, 6, 16), between(12, 20, 16))),
    ("n", "128"),
)
"""Lorenz' equations at his own parameters, long enough for neighbours to separate by many powers of
e.
"""
ENTERED: Rows = (
    ("_x", between(-31 / 64, 31 / 64, 64)),
    ("_odd", between(1, 62, 1)),
    ("start", computed(lambda drawn: f"{drawn['_x']},{(2 * drawn['_odd'] + 1) / 256}")),
    ("direction", listed(signed(40 / 64, 90 / 64, 64), between(30 / 64, 80 / 64, 64))),
)
"""A point inside a billiard, and a direction along neither axis."""
STADIUM: Rows = (
    *ENTERED,
    ("_width", between(3, 4, 64)),
    ("size", computed(lambda drawn: f"{drawn['_width']},2")),
    ("n", "40"),
)
"""A stadium with straight walls, with a direction along neither axis."""
RECTANGLE: Rows = (("geometry", "rectangle"), *ENTERED, ("size", "3,2"), ("n", "100"))
"""A rectangle with a path that meets no corner."""
HEAD: Rows = (
    ("centre", listed(between(0.5, 1.5, 64), between(-1.5, -0.5, 64))),
    ("size", between(0.125, 0.5, 64)),
    ("points", "96"),
    *lasting("8", "12"),
)
"""A cat's head in the phase space of an oscillator."""
WET_HEAD: Rows = (*HEAD, ("flow", "viscous"), ("delta", between(0.125, 0.375, 64)))
"""The same in a fluid."""

FALLING: Rows = (
    ("mass", between(0.5, 3)),
    ("gravity", between(2, 10)),
    ("drag", between(0.125, 1)),
    *lasting("4", "12"),
)
"""A body that falls from rest in a fluid, up to the terminal velocity."""
SHAFT: Rows = (
    ("mass", between(0.5, 0.875)),
    ("stiffness", between(2, 6)),
    ("outer_damping", between(0.125, 0.25)),
    ("inner_damping", between(0.375, 0.625)),
    ("turning", either("6", "-7")),
    ("x0", listed(signed(0.5, 1.5), signed(0.5, 1.5))),
    ("v0", listed(signed(0.5, 1.5), signed(0.5, 1.5))),
    *lasting("3", "24"),
)
"""A mass on a shaft that rotates faster than its stability limit, in either direction."""
SLOW_SHAFT: Rows = (*SHAFT, ("turning", either("1", "-3/2")))
"""The same below the stability limit."""
THROWN: Rows = (*FALLING, ("v0", between(1, 4)))
"""The same, thrown up at first."""

SMOOTH = ("euler", "verlet", "suzuki", "rk4", "verlet-single")
SWINGING = ("euler", "verlet", "suzuki", "verlet-single")
TOUCHING = ("verlet", "verlet-single")
HELD = ("verlet", "suzuki", "verlet-single")
DAMPED = ("euler", "verlet", "rk4", "verlet-single")
ITERATED = ("iterated",)
DIFFERENTIATED = ("verlet-tangent",)
SETTINGS: Mapping[str, Setting] = {
    "tumbler": Setting("free-rigid-body", TUMBLER, SMOOTH),
    "flipper": Setting("intermediate-axis", FLIPPER, SMOOTH),
    "swing": Setting("pendulum", SWING, SWINGING),
    "circler": Setting("pendulum", CIRCLER, SWINGING),
    "oscillator": Setting("harmonic-oscillator", OSCILLATOR, SMOOTH),
    "hanging": Setting("harmonic-oscillator", HANGING, SMOOTH),
    "viscous": Setting("viscous-oscillator", VISCOUS, DAMPED),
    "falling": Setting("quadratic-drag", FALLING, DAMPED),
    "thrown": Setting("quadratic-drag", THROWN, DAMPED),
    "shaft": Setting("whirling-shaft", SHAFT, DAMPED),
    "slow-shaft": Setting("whirling-shaft", SLOW_SHAFT, DAMPED),
    "driven": Setting("driven-oscillator", DRIVEN, SMOOTH),
    "hardening": Setting("duffing", HARDENING, SMOOTH),
    "lopsided": Setting("quadratic-response", LOPSIDED, SMOOTH),
    "lopsided-down": Setting("quadratic-response", LOPSIDED_DOWN, SMOOTH),
    "mixing": Setting("quadratic-response", MIXING, DAMPED),
    "tripling": Setting("driven-duffing", TRIPLING, DAMPED),
    "middle": Setting("driven-duffing", MIDDLE, DAMPED),
    "cycle-and-drive": Setting("van-der-pol", CYCLE_AND_DRIVE, DAMPED),
    "far": Setting("harmonic-oscillator", FAR, SMOOTH),
    "along-wall": Setting("impact-benchmarks", ALONG_WALL, TOUCHING),
    "steep": Setting("power-oscillator", STEEP, ("euler", "verlet", "verlet-single")),
    "cycle": Setting("van-der-pol", CYCLE, DAMPED),
    "rubbing": Setting("coulomb-oscillator", RUBBING, TOUCHING),
    "sticking": Setting("stick-slip", STICKING, TOUCHING),
    "orbit": Setting("two-body-orbit", ORBIT, SMOOTH),
    "ellipse": Setting("two-body-orbit", ELLIPSE, SMOOTH),
    "knock": Setting("two-spheres", KNOCK, TOUCHING),
    "parting": Setting("two-spheres", PARTING, TOUCHING),
    "bounce": Setting("two-spheres", BOUNCE, TOUCHING),
    "scrape": Setting("two-spheres", SCRAPE, TOUCHING),
    "scrape-long": Setting("two-spheres", SCRAPE_LONG, TOUCHING),
    "scrape-short": Setting("two-spheres", SCRAPE_SHORT, TOUCHING),
    "scrape-two-levers": Setting("two-spheres", SCRAPE_TWO_LEVERS, TOUCHING),
    "bristle": Setting("two-spheres", BRISTLE, TOUCHING),
    "spinner": Setting("two-spheres", SPINNER, TOUCHING),
    "soft": Setting("two-spheres", SOFT, TOUCHING),
    "sticker": Setting("two-spheres", STICKER, TOUCHING),
    "hold-two-levers": Setting("two-spheres", HOLD_TWO_LEVERS, TOUCHING),
    "gripper": Setting("two-spheres", GRIPPER, TOUCHING),
    "tumbling-spheres": Setting("two-spheres", TUMBLING_SPHERES, TOUCHING, proved=False),
    "unproved": Setting("van-der-pol", CYCLE, DAMPED, proved=False),
    "clash": Setting("hard-spheres", CLASH, TOUCHING),
    "elastic": Setting("hard-spheres", ELASTIC, TOUCHING),
    "rub": Setting("hard-spheres", RUB, TOUCHING),
    "grip": Setting("hard-spheres", GRIP, TOUCHING),
    "rebound": Setting("hard-wall", REBOUND, TOUCHING),
    "corner": Setting("corner-impact", CORNER, TOUCHING),
    "elastic-corner": Setting("corner-impact", ELASTIC_CORNER, TOUCHING),
    "cradle": Setting("newtons-cradle", CRADLE, TOUCHING),
    "break": Setting("billiard-break", BREAK, TOUCHING),
    "elastic-cradle": Setting("newtons-cradle", ELASTIC_CRADLE, TOUCHING),
    "elastic-drop": Setting("bouncing-ball", ELASTIC_DROP, TOUCHING),
    "drop": Setting("bouncing-ball", DROP, TOUCHING),
    "differentiated-drop": Setting("bouncing-ball", SPINNING_DROP, DIFFERENTIATED),
    "differentiated-wall": Setting("hard-wall", SMOOTH_REBOUND, DIFFERENTIATED),
    "differentiated-oscillator": Setting("harmonic-oscillator", HANGING, DIFFERENTIATED),
    "skid": Setting("rolling", SKID, TOUCHING),
    "ramp": Setting("rolling", RAMP, TOUCHING),
    "chute": Setting("rolling", CHUTE, TOUCHING),
    "hertz": Setting("hertz-spheres", HERTZ, TOUCHING),
    "gas": Setting("granular-gas", GAS, ("impacts",), engine="reference"),
    # In single precision only one pair of levels would be above round-off.
    "tent": Setting("asymmetric-field", TENT, ("verlet",)),
    "wedge": Setting("wedge-collision", WEDGE, TOUCHING),
    "flyer": Setting("newtons-first-law", FLYER, SMOOTH),
    "resting": Setting("newtons-first-law", RESTING, TOUCHING),
    "top": Setting("heavy-top", TOP, HELD),
    "above": Setting("pendulum-equilibria", ABOVE, HELD),
    "below": Setting("pendulum-equilibria", BELOW, HELD),
    "chain": Setting("double-pendulum", CHAIN, HELD),
    "chaotic-chain": Setting("double-pendulum", CHAOTIC_CHAIN, ("verlet", "suzuki")),
    "coupled": Setting("coupled-pendulums", COUPLED, HELD),
    "captured": Setting("captured-mass", CAPTURED, TOUCHING),
    "machine": Setting("pendulum-wheel-mass", MACHINE, HELD),
    "chaotic-map": Setting("logistic", CHAOTIC_MAP, ITERATED),
    "growth": Setting("logistic", GROWTH, ITERATED),
    "lorenz": Setting("lorenz", LORENZ, ITERATED),
    "chaotic-lorenz": Setting("lorenz", CHAOTIC_LORENZ, ITERATED),
    "stadium": Setting("billiards", STADIUM, ITERATED),
    "rectangle": Setting("billiards", RECTANGLE, ITERATED),
    "head": Setting("phase-flow", HEAD, ("carried",)),
    "wet-head": Setting("phase-flow", WET_HEAD, ("carried",)),
    "long-oscillator": Setting("harmonic-oscillator", LONG_OSCILLATOR, ("verlet",)),
}
