"""What a gate runs of a case that is named without parameters: its defaults, and settings that show
what these leave out.

Defaults are simple: they keep still what is easy to get wrong. A head-on collision rubs at no
lever, bodies that are alike may be taken for each other, what is 1 may be left out or squared, and
at an attitude of no rotation body axes are those of space.
"""

from collections.abc import Mapping

SPRUNG = {"mass": "2", "stiffness": "3", "gravity": "5/4", "x0": "-3/4", "v0": "1/2"}
TURNED = {"attitude": "1,2,-1,1/2"}
TELLING: Mapping[str, tuple[Mapping[str, str], ...]] = {
    "asymmetric-field": (
        {"mass": "2", "k1": "3", "x1": "-3/4", "x2": "5/8", "x0": "-3/2", "v0": "3/2"},
    ),
    "captured-mass": ({"mass": "2", "speed": "3/2", "radius": "3/4"},),
    "coulomb-oscillator": (
        {"mass": "2", "stiffness": "3", "friction_force": "1/4", "x0": "-5/4", "v0": "3/4"},
        {
            "friction_force": "1/8192",
            "x0": "-3/2048",
            "v0": "1/2048",
        },  # nothing is large enough to hide a threshold
    ),
    "dissipating-body": ({**TURNED, "omega_body": "1/2,-1,5/4"},),
    "double-pendulum": (  # the force in the upper rod hangs on both masses
        {
            "masses": "1,3",
            "lengths": "5/4,3/4",
            "thetadot0": "1/2,-1",
            "duration": "1",
            "samples": "16",
        },
    ),
    "driven-duffing": (
        {
            "alpha": "5/4",
            "beta": "3/4",
            "f0": "1",
            "drive": "5/4",
            "x0": "-1/2",
            "v0": "3/4",
            "duration": "12",
        },
    ),
    "driven-oscillator": ({**SPRUNG, "delta": "1/8", "f0": "3/4", "drive": "3/2"},),
    "duffing": ({"alpha": "3/2", "beta": "3/4", "amplitude": "5/4"},),
    "free-rigid-body": ({**TURNED, "omega_body": "1/2,-1,5/4"},),
    "harmonic-oscillator": (
        SPRUNG,
        # it swings about a place 1000 times as far from the origin as it moves
        {"gravity": "1024", "x0": "1025", "v0": "1/2"},
    ),
    "heavy-top": (
        {
            **{"mass": "3/2", "length": "3/4", "inertia": "5/4,1/2"},
            **{"phidot0": "1/2", "thetadot0": "-1/4", "spin": "12"},
        },
    ),
    "hertz-spheres": ({"effective_mass": "3/4", "stiffness": "400", "closing_speed": "3/2"},),
    "impact-benchmarks": (
        {
            "member": "co-6"
        },  # a sphere that spins hits a wall, and its tangential spring holds and slips
        {
            "member": "co-6",
            "spin": "-3",
            "friction": "1/20",
            "branch": "R-d",
        },  # it turns the other way, at another lever
        {  # it slides to the end, and friction is mu times the normal force, to the last digit
            "member": "co-4",
            "tangential_stiffness": "0",
            "angle": "1",
        },
        {"member": "dem-05-hertz", "angle": "0.3"},  # friction under Hertz's law
        {"member": "dem-05-mindlin"},  # a tangential spring that stiffens with its load
        {"member": "three-spheres"},  # a body in two contacts at once
    ),
    "intermediate-axis": ({**TURNED, "inertia": "3,2,1", "direction": "3", "duration": "24"},),
    "kapitza-pendulum": ({"length": "5/4", "gravity": "3/2", "thetadot0": "1/4", "duration": "6"},),
    "neglected-gyroscopic": (TURNED,),
    "pendulum": ({"mass": "2", "length": "3/4", "theta0": "3/4", "thetadot0": "-1"},),
    "pendulum-equilibria": ({"length": "3/4", "position": "bottom"},),
    "pendulum-wheel-mass": (
        {"mass": "3/2", "counter_mass": "2", "rdot0": "1/4", "thetadot0": "-1/2", "duration": "4"},
    ),
    "power-oscillator": ({"mass": "2", "stiffness": "3", "exponent": "5/2", "amplitude": "5/4"},),
    "quadratic-response": (
        {"w0": "5/4", "x0": "-1/2", "v0": "1/4"},
        {"eps": "-1/8", "w0": "5/4", "x0": "1/2", "v0": "-1/4"},  # it resists less where it is long
    ),
    "stick-slip": ({"belt": "3/4", "x0": "1/4", "v0": "-1/2"},),
    "two-body-orbit": ({"gm": "2", "semi_major": "3/4", "eccentricity": "1/4"},),
    "two-spheres": (
        {  # unlike spheres stick, slide and part; the second one's spin and torque count
            **{
                "masses": "1,2",
                "radii": "1/2,3/4",
                "stiffness": "16",
                "damping": "1/2",
                "angle": "1/2",
                "spins": "0,0,2,0,0,-1",
            },
            **{"tangential_stiffness": "12", "friction": "1/4"},
        },
        # sliding friction of full size at the whole radius; a dashpot that would pull at the end,
        # and may not
        {
            **{
                "masses": "2,1",
                "radii": "1/2,1",
                "stiffness": "16",
                "damping": "4",
                "angle": "-3/4",
                "spins": "0,0,1,0,0,2",
            },
            **{"friction": "1/4", "branch": "R", "cutoff": "zero_force"},
        },
        {  # little friction and a stiff spring: it is clipped at once and turns back
            **{
                "masses": "1,3",
                "radii": "3/4,1/2",
                "stiffness": "16",
                "damping": "1",
                "angle": "1/4",
                "spins": "0,0,-1,0,0,1",
            },
            **{"tangential_stiffness": "64", "friction": "1/8", "branch": "R-d"},
        },
        {  # sliding that comes to rest
            **{
                "masses": "2,1",
                "radii": "1/2,1",
                "stiffness": "16",
                "damping": "1",
                "angle": "1/4",
                "spins": "0,0,1/2,0,0,1/4",
            },
            **{"friction": "1/2"},
        },
        # spins about all axes: the slip leaves its plane, and torques are about no axis of their
        # own; friction without damping
        {
            **{
                "masses": "1,3",
                "radii": "1/2,3/4",
                "angle": "1/3",
                "spins": "1,3,1,2,-1,3",
                "friction": "1/8",
                "damping": "0",
            },
        },
        # hardly any speed, a spring softer than 1, and no damping beside friction: nothing here is
        # large enough to hide a threshold
        {
            **{
                "masses": "1,3",
                "radii": "1/2,3/4",
                "closing_speed": "1/1024",
                "angle": "1/2",
                "damping": "0",
            },
            **{
                "stiffness": "2",
                "tangential_stiffness": "1/2",
                "friction": "1/4",
                "spins": "0,0,1/1024,0,0,-1/2048",
            },
        },
        # sliding that comes to rest, so slowly that a speed below which friction fades would be
        # seen
        {
            **{
                "masses": "2,1",
                "radii": "1/2,1",
                "closing_speed": "1/1024",
                "stiffness": "16",
                "damping": "1",
                "angle": "1/4",
            },
            **{"spins": "0,0,1/2048,0,0,1/4096", "friction": "1/2"},
        },
    ),
    "van-der-pol": ({"x0": "-1/2", "v0": "3/4", "p": "3/8"},),  # its drive has a phase
    "viscous-oscillator": ({**SPRUNG, "delta": "1/4"},),
    "wedge-collision": ({"mass": "3/2", "closing_speed": "3/2"},),
}
"""By case id: parameters beside its defaults."""


def settings(case: str) -> tuple[Mapping[str, str], ...]:
    """Parameters of the runs that stand for a case: none, and those that are telling."""
    return ({}, *TELLING.get(case, ()))
