"""Every case: the catalogue's names, bounds that refuse, starts that are physical, and observation
of known motions.
"""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory
from refdem.errors import NotCertifiedError, UsageError
from refdem.scene import Scene

AXES = "xyz"
ROTATION = (
    [f"{name}.{a}" for name in ("omega_body", "omega") for a in AXES]
    + [f"attitude.{a}" for a in "wxyz"]
    + [f"R.{a}{b}" for a in AXES for b in AXES]
)
CATALOGUE = {
    "free-rigid-body": ("inertia omega_body attitude", ROTATION),
    "intermediate-axis": ("inertia omega_body attitude offset direction", ROTATION),
    "pendulum": (
        "mass length gravity theta0 thetadot0",
        ["theta", "thetadot", "x", "y", "rod_force"],
    ),
    "harmonic-oscillator": ("mass stiffness gravity x0 v0", ["x", "v"]),
    "coulomb-oscillator": (
        "member mass stiffness friction_force x0 v0 gravity",
        ["x", "v"],
    ),
    "stick-slip": ("a mu0 mu1 lambda0 lambda1 friction_law belt gamma eta x0 v0", ["x", "v"]),
    "viscous-oscillator": ("mass stiffness gravity delta x0 v0", ["x", "v"]),
    "driven-oscillator": ("mass stiffness gravity delta f0 drive x0 v0", ["x", "v"]),
    "power-oscillator": ("mass stiffness exponent amplitude", ["x", "v"]),
    "duffing": ("alpha beta amplitude", ["x", "v"]),
    "driven-duffing": ("alpha beta delta f0 drive x0 v0", ["x", "v"]),
    "quadratic-response": ("w0 eps delta f0 drive x0 v0", ["x", "v"]),
    "whirling-shaft": (
        "mass stiffness outer_damping inner_damping turning x0 v0",
        ["x", "y", "vx", "vy"],
    ),
    "van-der-pol": ("mu p drive x0 v0", ["x", "v"]),
    "two-body-orbit": ("gm semi_major eccentricity stiffness", ["x", "y", "vx", "vy"]),
    "two-spheres": (
        (
            "masses radii stiffness damping closing_speed tangential_stiffness friction angle spins"
            " branch cutoff"
        ),
        [f"{kind}{i}.{a}" for i in (1, 2) for kind in ("r", "v", "omega") for a in AXES],
    ),
    "hertz-spheres": ("effective_mass stiffness closing_speed", ["overlap", "v"]),
    "asymmetric-field": ("mass k1 x1 x2 x0 v0", ["x", "v"]),
    "wedge-collision": ("mass k1 k2 closing_speed", ["overlap", "v"]),
    "corner-impact": (
        "mass sides angle height velocity restitution",
        ["x", "y", "vx", "vy", "theta", "omega"],
    ),
    "logistic": ("eta x0 n form", ["x_n"]),
    "lorenz": ("sigma rho beta start interval n", ["x", "y", "z"]),
    "billiards": (
        "geometry start direction n size",
        [f"{kind}.{a}" for kind in ("position", "direction") for a in "xy"],
    ),
    "rigid-cluster": ("masses positions omega", [f"r{i}.{a}" for i in (1, 2, 3, 4) for a in AXES]),
    "heavy-top": (
        "mass length gravity inertia theta0 phidot0 thetadot0 spin",
        ["theta", "phi", "psi", "thetadot"],
    ),
    "granular-gas": (
        "n diameter contact restitution friction density boundary seed t0 gravity",
        ["temperature"],
    ),
    "captured-mass": ("mass speed radius", ["x", "y", "vx", "vy"]),
    "pendulum-wheel-mass": (
        "mass counter_mass wheel_radius wheel_inertia gravity r0 theta0 rdot0 thetadot0",
        ["r", "theta", "rdot", "thetadot"],
    ),
    "double-pendulum": (
        "masses lengths gravity theta0 thetadot0",
        ["theta1", "theta2", "thetadot1", "thetadot2"],
    ),
    "coupled-pendulums": (
        "masses lengths distance gravity stiffness spring_length theta0 thetadot0",
        ["theta1", "theta2", "thetadot1", "thetadot2"],
    ),
    "kapitza-pendulum": (
        "length gravity drive_amplitude drive theta0 thetadot0",
        ["theta", "thetadot"],
    ),
    "pendulum-equilibria": ("length gravity position delta", ["x", "y", "vx", "vy"]),
    "newtons-first-law": (
        "member velocity spin",
        [
            *AXES,
            "vx",
            "vy",
            "vz",
            *(f"omega.{a}" for a in AXES),
            *(f"attitude.{a}" for a in "wxyz"),
        ],
    ),
}
CATALOGUE |= {
    "block-on-slope": ("mass friction slope angle gravity heading", ["s", "v"]),
    "neglected-gyroscopic": (
        (
            "member inertia omega_body attitude velocity mass gravity slope height stiffness"
            " damping friction"
        ),
        [*ROTATION, "x", "y", "z"],
    ),
    "dissipating-body": ("inertia omega_body attitude damping", [f"omega_body.{a}" for a in AXES]),
}
CARRIED = {
    "phase-flow": "flow centre size points mass stiffness delta friction_force length gravity"
}
TIMELESS = {
    "degrees-of-freedom": "points",
    "moments-of-inertia": "a b c density hollow thin attitude",
    "rotations": (
        "angle vector euler omega near frequency shifts masses places velocities small step"
        " multiple"
    ),
    "quaternions": "p q r vector omega rise",
    "poincare-sections": "a mu0 mu1 lambda0 lambda1 friction_law belt gamma eta x0 v0",
    "bifurcations": "amplitude alpha beta delta f0 eta",
}
SELECTIONS = {"time-reversal", "lyapunov"}
CATALOGUE["impact-benchmarks"] = (
    (
        "member material branch cutoff radius density speed angle normal_speed psi spin"
        " partner_radius partner_density partner_spin restitution stiffness tangential_stiffness"
        " friction gravity height overlap"
    ),
    [f"{kind}.{a}" for kind in ("r", "v", "omega") for a in AXES],
)
LISTED = {*CATALOGUE, *TIMELESS, *CARRIED, *SELECTIONS}
OTHERS = sorted(set(discovery.own_names("cases")) - LISTED)
"""Cases whose names are in a test of their own."""
STARTS: list[tuple[str, dict[str, str]]] = [
    (name, {}) for name in OTHERS if isinstance(discovery.case(name).at().problem, Motion)
]
STARTS += [
    ("free-rigid-body", {}),
    ("free-rigid-body", {"inertia": "2,2,3", "attitude": "1,2,3,4"}),
    ("intermediate-axis", {}),
    (
        "intermediate-axis",
        {"omega_body": "0,-2,0", "offset": "1e-9", "direction": "3", "attitude": "0,0,1,1"},
    ),
    ("pendulum", {}),
    ("pendulum", {"mass": "3/2", "length": "2", "theta0": "-2.5", "thetadot0": "4"}),
    ("harmonic-oscillator", {"gravity": "9.81", "v0": "-2", "mass": "0.3", "stiffness": "7"}),
    ("coulomb-oscillator", {}),
    ("coulomb-oscillator", {"v0": "1/3", "x0": "0"}),
    ("viscous-oscillator", {"delta": "3", "gravity": "-2", "mass": "5", "v0": "1/3"}),
    ("whirling-shaft", {"turning": "-7/2", "mass": "1/3", "v0": "1,-2"}),
    ("driven-oscillator", {"mass": "3", "delta": "0", "drive": "0.7", "gravity": "1"}),
    ("power-oscillator", {"exponent": "5/2", "amplitude": "-2", "mass": "1/3"}),
    ("duffing", {"alpha": "-1", "amplitude": "1/2"}),
    ("duffing", {"alpha": "2", "beta": "-1"}),
    ("driven-duffing", {"alpha": "-1", "x0": "0", "v0": "1/2"}),
    ("quadratic-response", {"eps": "-1/4", "x0": "1/2", "v0": "1"}),
    ("van-der-pol", {"mu": "2", "x0": "0", "v0": "0"}),
    ("two-body-orbit", {}),
    ("two-body-orbit", {"eccentricity": "0.99", "gm": "2", "semi_major": "3"}),
    ("two-body-orbit", {"eccentricity": "0.6", "stiffness": "4", "semi_major": "2"}),
    ("two-spheres", {}),
    ("two-spheres", {"damping": "1"}),
    (
        "two-spheres",
        {
            "masses": "1,3",
            "radii": "1/4,1/2",
            "damping": "1",
            "angle": "0.5",
            "friction": "0.1",
            "spins": "0,0,1,0,0,-2",
        },
    ),
    ("two-spheres", {"damping": "20"}),
    ("hertz-spheres", {"effective_mass": "3", "stiffness": "1e8", "closing_speed": "0.01"}),
    ("asymmetric-field", {"x0": "2", "v0": "-3", "k1": "5", "x1": "-1/4"}),
    ("asymmetric-field", {"x0": "-1/3", "v0": "0"}),
    ("wedge-collision", {"k1": "20", "mass": "1/3", "closing_speed": "2"}),
    ("rigid-cluster", {}),
    (
        "rigid-cluster",
        {"masses": "1,1,1,2", "positions": "1,1,1,1,-1,-1,-1,1,-1,-1,-1,1", "omega": "0,0,3"},
    ),
    ("heavy-top", {}),
    (
        "heavy-top",
        {"theta0": "2", "phidot0": "-1", "thetadot0": "1/2", "spin": "-9", "inertia": "2,1/3"},
    ),
    ("captured-mass", {"mass": "1/3", "speed": "7", "radius": "2"}),
    ("pendulum-wheel-mass", {}),
    (
        "pendulum-wheel-mass",
        {
            "wheel_radius": "0",
            "wheel_inertia": "0",
            "counter_mass": "3",
            "rdot0": "-1",
            "thetadot0": "2",
        },
    ),
    (
        "double-pendulum",
        {"masses": "1/3,2", "lengths": "2,1/2", "theta0": "-1,2", "thetadot0": "1,-3"},
    ),
    (
        "coupled-pendulums",
        {"masses": "1/3,2", "lengths": "2,1/2", "theta0": "-1,2", "thetadot0": "1,-3"},
    ),
    ("kapitza-pendulum", {"theta0": "-1/3", "thetadot0": "2", "length": "2"}),
    ("pendulum-equilibria", {}),
    ("pendulum-equilibria", {"position": "bottom", "delta": "-1/2", "length": "3"}),
    ("newtons-first-law", {}),
    ("newtons-first-law", {"member": "block"}),
    ("newtons-first-law", {"member": "stack"}),
    ("newtons-first-law", {"member": "spheres"}),
]
REFUSED = [
    ("free-rigid-body", {"inertia": "1,1,3"}, "triangle inequality"),
    ("free-rigid-body", {"inertia": "0,1,1"}, "inertia"),
    ("free-rigid-body", {"attitude": "0,0,0,0"}, "attitude"),
    ("free-rigid-body", {"omega_body": "0,0,0"}, "omega_body"),
    ("intermediate-axis", {"offset": "0"}, "offset"),
    ("intermediate-axis", {"direction": "2"}, "direction"),
    ("intermediate-axis", {"omega_body": "-1,0,0", "offset": "1"}, "offset"),
    ("pendulum", {"length": "-1"}, "length"),
    ("pendulum", {"gravity": "0"}, "gravity"),
    ("pendulum", {"theta": "1"}, "theta0"),
    ("harmonic-oscillator", {"x0": "0"}, "x0"),
    ("harmonic-oscillator", {"mass": "nan"}, "mass"),
    ("coulomb-oscillator", {"friction_force": "-0.1"}, "friction_force"),
    ("coulomb-oscillator", {"samples": "1"}, "samples"),
    ("viscous-oscillator", {"delta": "-1"}, "delta"),
    ("driven-oscillator", {"f0": "0", "x0": "0"}, "x0"),
    ("whirling-shaft", {"inner_damping": "-1"}, "inner_damping"),
    ("whirling-shaft", {"x0": "0,0", "v0": "0,0"}, "x0"),
    ("power-oscillator", {"exponent": "1/2"}, "exponent"),
    ("power-oscillator", {"amplitude": "0"}, "amplitude"),
    ("duffing", {"alpha": "1", "beta": "-1"}, "escape energy"),
    ("duffing", {"alpha": "0", "beta": "0"}, "escape energy"),
    ("driven-duffing", {"beta": "-1", "x0": "0", "v0": "1"}, "escape energy"),
    ("driven-duffing", {"beta": "-1", "x0": "2"}, "escape energy"),
    ("driven-duffing", {"alpha": "-1", "beta": "0"}, "escape energy"),
    ("driven-duffing", {"f0": "0", "x0": "0"}, "x0"),
    ("quadratic-response", {"eps": "1/4", "x0": "2"}, "escape energy"),
    ("quadratic-response", {"eps": "1/4", "x0": "-5"}, "escape energy"),
    ("van-der-pol", {"p": "0", "x0": "0"}, "x0"),
    ("two-body-orbit", {"eccentricity": "1"}, "eccentricity"),
    ("two-body-orbit", {"stiffness": "0"}, "stiffness"),
    ("two-spheres", {"angle": "1.6"}, "angle"),
    ("two-spheres", {"closing_speed": "16"}, "closing_speed"),
    ("two-spheres", {"branch": "R+d"}, "branch"),
    ("two-spheres", {"masses": "1,1,1"}, "masses"),
    ("hertz-spheres", {"closing_speed": "0"}, "closing_speed"),
    ("asymmetric-field", {"x1": "0"}, "x1"),
    ("asymmetric-field", {"v0": "0"}, "outside the field"),
    ("wedge-collision", {"k2": "0"}, "k2"),
    ("logistic", {"eta": "5"}, "eta"),
    ("logistic", {"x0": "-1/8"}, "x0"),
    ("logistic", {"duration": "3"}, "duration"),
    ("lorenz", {"beta": "0"}, "beta"),
    ("lorenz", {"start": "0,0,0"}, "start"),
    ("lorenz", {"beta": "3", "rho": "4", "start": "-3,-3,3"}, "start"),
    ("lorenz", {"interval": "2"}, "interval"),
    ("billiards", {"direction": "0,0"}, "direction"),
    ("billiards", {"size": "1,2"}, "size"),
    ("billiards", {"start": "2,0"}, "start"),
    ("billiards", {"start": "15/8,3/4"}, "start"),
    ("billiards", {"start": "0,1", "geometry": "rectangle"}, "start"),
    ("rigid-cluster", {"positions": "0,0,0,1,0,0,0,1,0,1,1,0"}, "plane"),
    ("rigid-cluster", {"omega": "0,0,0"}, "omega"),
    ("captured-mass", {"speed": "0"}, "speed"),
    ("heavy-top", {"theta0": "0"}, "theta0"),
    ("pendulum-wheel-mass", {"wheel_radius": "-1"}, "wheel_radius"),
    ("double-pendulum", {"lengths": "1,0"}, "lengths"),
    ("coupled-pendulums", {"theta0": "1e-8,-1e-8", "distance": "2e-8"}, "no direction"),
    ("kapitza-pendulum", {"drive": "0"}, "drive"),
    ("pendulum-equilibria", {"position": "side"}, "position"),
    ("newtons-first-law", {"member": "sphere"}, "member"),
]


def at_rest(instance: Instance) -> Trajectory:
    """The start, twice: what an engine would show if nothing happened."""
    bodies = instance.scene.bodies
    state = {
        name: np.stack([getattr(bodies, name)] * 2)
        for name in ("position", "velocity", "attitude", "omega")
    }
    return Trajectory(t=np.array([0.0, 1.0]), **state)


def test_the_catalogue_has_these_cases() -> None:
    """Those that are listed here, and those that have a file of tests named for them."""
    assert set(discovery.names("cases")) >= LISTED
    for name in OTHERS:
        own = Path(__file__).with_name(f"test_{name.replace('-', '_')}.py")
        assert own.is_file(), f"case {name} has no tests: {own} is not there"


@pytest.mark.parametrize("name", CARRIED)
def test_flows_have_these_parameters(name: str) -> None:
    assert [p.name for p in discovery.case(name).parameters] == CARRIED[name].split()


@pytest.mark.parametrize("name", TIMELESS)
def test_cases_without_time_have_the_parameters_of_the_catalogue(name: str) -> None:
    assert [p.name for p in discovery.case(name).parameters] == TIMELESS[name].split()


@pytest.mark.parametrize("name", CATALOGUE)
def test_names_of_parameters_and_quantities_are_the_catalogues(name: str) -> None:
    parameters, quantities = CATALOGUE[name]
    case = discovery.case(name)
    assert [p.name for p in case.parameters] == parameters.split()
    assert list(case.at().quantities) == quantities
    assert (case.id, len(case.statement.split(". ")) >= 2) == (name, True)


@pytest.mark.parametrize(("name", "given", "word"), REFUSED)
def test_values_that_make_no_motion_are_refused_by_name(
    name: str, given: dict[str, str], word: str
) -> None:
    with pytest.raises(UsageError, match=word):
        discovery.case(name).at(**given)


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_a_scene_survives_json(name: str, given: dict[str, str]) -> None:
    scene = discovery.case(name).at(**given).scene
    assert Scene.from_json(scene.to_json()).to_json() == scene.to_json()


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_scales_are_positive_and_finite(name: str, given: dict[str, str]) -> None:
    instance = discovery.case(name).at(**given)
    sizes = [
        instance.scales.length,
        instance.scales.tau,
        instance.scales.duration,
        instance.scales.mass,
    ]
    sizes += [q.scale for q in instance.quantities.values()]
    assert np.all(np.isfinite(sizes))
    assert min(sizes) > 0


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_truth_starts_where_the_scene_starts(name: str, given: dict[str, str]) -> None:
    instance = discovery.case(name).at(**given)
    seen = instance.observe(at_rest(instance))
    true = instance.truth().at(Fraction(0))
    assert set(seen) <= set(true)
    for quantity, values in seen.items():
        difference = values[0] - float(true[quantity].mid)
        if instance.quantities[quantity].angle:
            difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        assert abs(difference) <= 1e-14 * max(1.0, abs(values[0])), quantity


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_truth_moves_as_its_velocities_say(name: str, given: dict[str, str]) -> None:
    instance = discovery.case(name).at(**given)
    small = Fraction(1, 2**20)
    rates = {"x": "vx", "y": "vy", "z": "vz", "theta": "thetadot"}
    rates |= {f"r{i}.{a}": f"v{i}.{a}" for i in (1, 2) for a in AXES}
    t = Fraction(float(instance.times[3]))
    before, now, after = (instance.truth().at(s) for s in (t - small, t, t + small))
    for place, rate in rates.items():
        if rate in now:
            rate = rate
        else:
            rate = "v"
        if place in now and rate in now:
            slope = (after[place].mid - before[place].mid) / (2 * small)
            turns = round(float(slope * 2 * small) / (2 * np.pi))
            expected = float(now[rate].mid)
            scale = instance.quantities[rate].scale
            assert abs(float(slope) - turns * np.pi / float(small) - expected) < 1e-4 * scale, place


BY_SCALARS = {"granular-gas"}
"""Many bodies in chaos: what is certain of them is a law of their means."""


def test_every_default_has_a_truth() -> None:
    for name in CATALOGUE:
        try:
            instance = discovery.case(name).at()
            truth = instance.truth()
            if "duration" in instance.p:
                late = Fraction(1, 4)
            else:
                late = Fraction(1)
            if name in BY_SCALARS:
                found = truth.scalars()
            else:
                found = truth.at(late)
        except NotCertifiedError as error:
            raise AssertionError(name) from error
        assert found
        assert all(ball.radius <= Fraction(1, 10**20) for ball in found.values())


def test_a_motion_that_is_too_long_for_its_shortest_time_names_what_was_set():
    unset = {"bounces": "25", "restitution": "0.1"}
    with pytest.raises(UsageError, match=r"^bouncing-ball\[.*\]: it lasts .* take other param"):
        discovery.case("bouncing-ball").at(**unset)
    with pytest.raises(UsageError, match=r"^parameter duration: got 1e\+13 s"):
        discovery.case("harmonic-oscillator").at(duration="1e13")
