"""The audit of defaults: REBOUND's default settings, what the adapter sets, and why."""

from refdem.core.engine import Default

AUDIT = (
    Default(
        "gravity",
        "basic, G = 1",
        "none; basic with G = 1 in a central field",
        "the bodies of a scene do not attract each other",
    ),
    Default(
        "central_field",
        "no such thing",
        "a first particle of mass gm at rest at the origin, N_active = 1",
        "REBOUND's own attraction; bodies are test particles, so the centre rests",
    ),
    Default(
        "testparticle_type",
        "0",
        "0",
        "test particles act on nothing; accelerations do not need their mass",
    ),
    Default("softening", "0", "0", "Newton's attraction as it is"),
    Default(
        "additional_forces",
        "none",
        "a compiled callback if there are springs, dashpots, soft contacts, piecewise fields,"
        " periodic forces, rods or uniform gravity",
        "REBOUND knows no such elements: its users program forces, and so does the adapter",
    ),
    Default(
        "rods",
        "no constraints",
        "multiplier force (v.v + r.a)/(r.r) in the callback",
        "the distance at the start is kept by the equations alone, nothing projects it",
    ),
    Default(
        "soft contacts",
        "no such thing",
        "k d^n between every pair of spheres that overlap, in the callback",
        "leapfrog only: the other integrators step over a discontinuity of a force, or reduce their"
        " step without limit; damped contacts need velocities, which leapfrog has half a step off",
    ),
    Default(
        "force_is_velocity_dependent",
        "0",
        "1 with rods or dashpots",
        "IAS15 predicts velocities only then",
    ),
    Default(
        "clock of a periodic force",
        "-",
        "sim.t at every evaluation",
        "each integrator sets it to the time of the stage",
    ),
    Default(
        "rotation",
        "particles have no spin",
        "attitude and Euler's equations as further equations of bs (create_ode)",
        "a quaternion of any length stands for an attitude; it is divided by its length at the"
        " door",
    ),
    Default("boundary", "none", "none", "there is no box"),
    Default(
        "collision, collision_resolve",
        "none, merge",
        "direct or line by the method, hardsphere; none without a rigid contact law",
        "REBOUND's own hard spheres; a search at the end of every step, so that they meet late by"
        " a step at most; hardsphere resolves what overlaps and approaches then, of line too"
        " (deviations/rebound_line.py)",
    ),
    Default(
        "integrator with hard spheres",
        "ias15",
        "leapfrog",
        "WHFast attracts bodies about the first particle whatever gravity is, and a bounce in"
        " MERCURIUS changes the energy by a part of the step (deviations/rebound_bounces.py)",
    ),
    Default(
        "coefficient_of_restitution",
        "1",
        "the contact's, at every speed",
        "REBOUND asks for it at every collision; the callback is Python",
    ),
    Default(
        "minimum_collision_velocity",
        "0",
        "0",
        "nothing is added to what the restitution leaves",
    ),
    Default(
        "rand_seed",
        "time and process",
        "1 with collisions",
        "those of one step are resolved in random order, and rounded otherwise in every run",
    ),
    Default("integrator", "ias15", "the method's", "named by the request"),
    Default("leapfrog.order", "2", "2 or 8", "by the method's name"),
    Default(
        "clock",
        "summed part by part of every step",
        "the engine's; of leapfrog-8 its number of steps times dt",
        "18 rounded parts a step leave that clock 4e-12 behind after 3e4 steps; no force here"
        " reads it",
    ),
    Default(
        "whfast.safe_mode, corrector, kernel",
        "1, 0, default",
        "the same",
        "with one centre there is nothing to correct",
    ),
    Default(
        "ias15.epsilon",
        "1e-9",
        "1e-10 with springs and rods, else 1e-9",
        "at 1e-9 some steps of a damped oscillator end their iteration early and are off by 2e-13;"
        " else the authors' choice for round-off",
    ),
    Default("ias15.min_dt", "0", "0", "no step is longer than its error allows"),
    Default(
        "ias15.adaptive_mode",
        "prs23",
        "global with springs and rods, else prs23",
        "prs23 takes its time from the acceleration: 100 times the steps where it goes through"
        " zero, no end where a rod holds it at 0",
    ),
    Default(
        "bs.eps_rel, bs.eps_abs",
        "1e-8, 1e-8",
        "the tolerance",
        "absolute in SI for places, velocities and quaternions alike",
    ),
    Default("bs.min_dt, bs.max_dt", "0, 0", "0, 0", "no limits to the step"),
    Default(
        "dt of ias15 and bs at the start",
        "0.001",
        "2^-8 of the sample interval",
        "small beside every motion, as the default is in years/2pi: a long first step is never"
        " shortened, see exact_finish_time",
    ),
    Default(
        "exact_finish_time",
        "1",
        "1",
        "ias15 and bs cut their step to meet a sample and start from the one before the cut: more"
        " samples change the steps; leapfrog-uncut samples copies, and its steps end nowhere else",
    ),
    Default(
        "all of it as shipped",
        "-",
        "ias15-as-shipped sets gravity none, the collisions of the scene and its forces, and"
        " nothing else",
        "all else keeps its default: without forces ias15 doubles its step up to the next sample,"
        " and collisions are detected at the ends of such steps only",
    ),
    Default(
        "warnings",
        "passed on",
        "dropped; errors end the run",
        "ias15 warns of loops that did not converge even where nothing pulls",
    ),
    Default(
        "SIGINT",
        "its own handler",
        "put back after every run",
        "integrate() takes the process's handler and keeps it",
    ),
)
