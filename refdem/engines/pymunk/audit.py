"""The audit of defaults: Chipmunk's default settings, what the adapter sets, and why."""

from refdem.core.engine import Default

AUDIT = (
    Default(
        "clock",
        "none",
        "steps counted by the engine (cpSpaceGetTimestamp) times the step",
        "Chipmunk keeps no time",
    ),
    Default(
        "Space.damping",
        "1",
        "exp(-damping/mass) of the dashpots; 1 where they are unlike or bodies turn",
        "velocities are multiplied by damping**dt, the same for all; other dashpots are forces",
    ),
    Default(
        "Space.sleep_time_threshold",
        "inf",
        "inf",
        "nothing is put to sleep: a pendulum that turns round would be, whatever pulls at it"
        " (deviations/pymunk_sleep.py)",
    ),
    Default(
        "Space.iterations",
        "10",
        "1 with one joint or none and no contact, else 200",
        "one joint is solved exactly at once; coupled ones converge",
    ),
    Default(
        "Space.collision_slop",
        "0.1 m",
        "0",
        "bodies would sink into each other by 0.1 m, which can be a body's size",
    ),
    Default(
        "Space.collision_bias",
        "0.9**60 a second",
        "0.9**60 a second",
        "pseudo-velocities that part overlapping bodies add no momentum",
    ),
    Default("Space.threaded", "False", "False", "one thread: the same bits every time"),
    Default(
        "Constraint.error_bias of a rod",
        "0.9**60 a second",
        "0",
        "the whole drift of a rod is taken out in every step; slower correction dissipates",
    ),
    Default("Constraint.max_bias of a rod", "inf", "inf", "no drift is left over"),
    Default(
        "Constraint.error_bias of dry friction",
        "0.9**60 a second",
        "1",
        "friction has no memory of a place: nothing pulls the body back",
    ),
    Default(
        "Constraint.max_force of dry friction",
        "inf",
        "friction * normal_force",
        "Coulomb's limit, as impulse max_force * dt a step",
    ),
    Default(
        "Constraint.pre_solve of dry friction",
        "none",
        "sets max_force where friction depends on the speed",
        "Stribeck's law at the speed before the step: explicit, of first order",
    ),
    Default(
        "Body.velocity_func",
        "Euler",
        "the same after the forces at the new place and the clock's end of the step",
        "drives, central and piecewise fields, fluids that turn, dashpots that Space.damping cannot"
        " express; the callback is compiled",
    ),
    Default(
        "DampedSpring.force_func",
        "stiffness * (rest_length - distance)",
        "the spring's law where it is not linear; k d^n of a soft contact while d > 0",
        "Chipmunk asks it for the force of the spring without its damper; the callback is compiled",
    ),
    Default(
        "DampedSpring.damping",
        "an argument",
        "0; a soft contact's while its discs overlap",
        "springs dissipate nothing; pre_solve switches the damper of a contact, which would act at"
        " any distance",
    ),
    Default(
        "Body.moment",
        "an argument",
        "the scene's J3; inf for a point",
        "a body without inertia does not turn",
    ),
    Default(
        "Shape.friction, Shape.elasticity",
        "0",
        "the contact's value and 1 for a shape alone between walls, else its square root",
        "Chipmunk combines the two shapes of a pair by product; the square of a rounded root may"
        " hold a little less",
    ),
    Default(
        "rod force",
        "size of the impulse only",
        "not reported",
        "cpConstraintGetImpulse has no sign, so a strut would read as a tie",
    ),
)
