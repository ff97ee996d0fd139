"""The audit of defaults: MuJoCo's default settings, what the adapter sets, and why."""

from refdem.core.engine import Default

_MODEL = (
    Default(
        "gravity",
        "(0, 0, -9.81) m/s^2",
        "the scene's, else disabled",
        "a default that would act in every scene",
    ),
    Default("timestep", "0.002 s", "the request's step", "what is measured"),
    Default("integrator", "Euler", "the method's", "each integrator is judged by its own claims"),
    Default(
        "balanceinertia, boundmass, boundinertia, settotalmass",
        "off",
        "off",
        "mass and inertia are the scene's, to the bit",
    ),
    Default("inertiafromgeom", "auto", "false", "inertia comes from the scene, not from shapes"),
    Default("density, viscosity, wind", "0", "0", "no medium"),
    Default(
        "joint damping",
        "0",
        "a dashpot's, else 0",
        "the same along every slide joint, as a dashpot is; Euler takes it implicitly",
    ),
    Default("joint armature", "0", "0", "nothing that the scene does not specify"),
    Default(
        "inertia of a point on a rod",
        "at least mjMINVAL = 1e-15 kg m^2",
        "1e-15 kg m^2",
        "could not be zero; adds 1e-15/(m l^2) to the inertia about the anchor: for m = l = 1 an"
        " angle off by 5e-16 of its phase",
    ),
    Default(
        "rod of a pendulum",
        "-",
        "a hinge at the anchor",
        "exact in MuJoCo's coordinates; a tendon or connect constraint is soft",
    ),
    Default(
        "forces that MuJoCo has no element for",
        "-",
        "mjcb_passive, called in every stage at its own time, places and velocities",
        "drives, central and piecewise fields, fluids that turn, springs and dashpots that no joint"
        " or tendon can express; controls and applied forces are constant over a step, also within"
        " Runge-Kutta; the callback is compiled",
    ),
    Default(
        "bodies that do not turn",
        "-",
        "slide joints along the axes of the motion",
        "coordinates that nothing moves would add only work",
    ),
)

_CONSTRAINTS = (
    Default(
        "unneeded machinery",
        "on",
        "off by disable flags",
        "contact, constraints, friction, springs, dampers, gravity only where the scene has them",
    ),
    Default(
        "limits, equalities, actuation, sensors",
        "on",
        "off",
        "no scene has them; sensors are on after the run, for rod forces",
    ),
    Default("autoreset", "on", "off", "a diverging run must be seen, not restarted in silence"),
    Default("warmstart", "on", "off", "a run can then go on from positions and velocities alone"),
    Default("sleep", "off", "off", "a body that rests must rest by the physics"),
    Default(
        "solver",
        "Newton, tolerance 1e-8, 100 iterations",
        "Newton, 1e-15, 100",
        "the constraint problem is solved, not approximated",
    ),
    Default("line search tolerance", "0.01", "1e-6", "as above"),
    Default("diagexact", "off", "on", "impedance as documented for any inertia and position"),
    Default(
        "cone",
        "pyramidal",
        "elliptic",
        "Coulomb's cone is round; the pyramid brakes by 0.71 mu N on the diagonal"
        " (deviations/mujoco_cone.py)",
    ),
    Default(
        "noslip_iterations",
        "0",
        "100 where there is friction",
        "without, what sticks creeps by 1e-4 of its free acceleration",
    ),
    Default(
        "solimp of friction and rigid contact",
        "0.9 to 0.95",
        "0.9999",
        "mjMAXIMP; could not be 1: rest is g (1 - 0.9999) (2 h)^2 deep",
    ),
    Default(
        "solref of friction and rigid contact",
        "0.02 s",
        "2 steps",
        "the shortest that refsafe allows: the law hardens with the step",
    ),
    Default(
        "solref, solimp, solreffriction where shapes may slide",
        "0.02 s, 0.9 to 0.95, as solref",
        "-1/(4 h^2), -1/h; d = 2^-10 (2^-14 on a belt); -d/h",
        "with the harder ones above what slides is thrown up at mu v and hops, by a part that no"
        " shorter step makes smaller",
    ),
    Default(
        "margin of contacts",
        "0",
        "2^-50 of the scene's size",
        "shapes exactly in touch would not feel each other in the first step",
    ),
    Default(
        "slider on a belt",
        "-",
        "a sphere on a plane with surfacevel, pressed by xfrc_applied, on three slide joints",
        "frictionloss is against the world at rest; without the third joint the tangents are"
        " singular and noslip does nothing",
    ),
    Default(
        "solref, solimp of the linear law",
        "soft-constraint values",
        "-stiffness/m_eff, -damping/m_eff; impedance 0.5",
        "direct form; the impedance cancels where no other force acts on the pair",
    ),
    Default(
        "impratio, solreffriction where the linear law slides",
        "1, as solref",
        "2^-30, -1/h",
        "slip would lift what slides, the more the shorter the step; noslip then makes friction"
        " hard at mu times the law's own force",
    ),
    Default(
        "friction coefficients",
        "1, 0.005, 0.0001",
        "the scene's, 0, 0 on every geom",
        "the larger of two counts; no torsional or rolling friction",
    ),
    Default("condim", "3", "1 without friction, else 3", "as above"),
)

AUDIT = _MODEL + _CONSTRAINTS
