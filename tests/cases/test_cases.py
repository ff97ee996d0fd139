"""Every case: the catalogue's names, bounds that refuse, starts that are physical, and observation of known motions."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.case import Instance
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
    "pendulum": ("mass length gravity theta0 thetadot0", ["theta", "thetadot", "x", "y", "rod_force"]),
    "harmonic-oscillator": ("mass stiffness gravity x0 v0", ["x", "v"]),
    "coulomb-oscillator": ("mass stiffness friction_force x0 v0", ["x", "v"]),
    "two-body-orbit": ("gm semi_major eccentricity stiffness", ["x", "y", "vx", "vy"]),
    "two-spheres": (
        "masses radii stiffness damping closing_speed tangential_stiffness friction angle spins branch cutoff",
        [f"{kind}{i}.{a}" for i in (1, 2) for kind in ("r", "v", "omega") for a in AXES],
    ),
    "newtons-first-law": (
        "member velocity spin",
        [*AXES, "vx", "vy", "vz", *(f"omega.{a}" for a in AXES), *(f"attitude.{a}" for a in "wxyz")],
    ),
}
STARTS = [
    ("free-rigid-body", {}),
    ("free-rigid-body", {"inertia": "2,2,3", "attitude": "1,2,3,4"}),
    ("intermediate-axis", {}),
    ("intermediate-axis", {"omega_body": "0,-2,0", "offset": "1e-9", "direction": "3", "attitude": "0,0,1,1"}),
    ("pendulum", {}),
    ("pendulum", {"mass": "3/2", "length": "2", "theta0": "-2.5", "thetadot0": "4"}),
    ("harmonic-oscillator", {"gravity": "9.81", "v0": "-2", "mass": "0.3", "stiffness": "7"}),
    ("coulomb-oscillator", {}),
    ("coulomb-oscillator", {"v0": "1/3", "x0": "0"}),
    ("two-body-orbit", {}),
    ("two-body-orbit", {"eccentricity": "0.99", "gm": "2", "semi_major": "3"}),
    ("two-body-orbit", {"eccentricity": "0.6", "stiffness": "4", "semi_major": "2"}),
    ("two-spheres", {}),
    ("two-spheres", {"masses": "1,3", "radii": "1/4,1/2", "angle": "0.5", "friction": "0.1", "spins": "0,0,1,0,0,-2"}),
    ("two-spheres", {"damping": "20"}),
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
    ("two-body-orbit", {"eccentricity": "1"}, "eccentricity"),
    ("two-body-orbit", {"stiffness": "0"}, "stiffness"),
    ("two-spheres", {"angle": "1.6"}, "angle"),
    ("two-spheres", {"closing_speed": "16"}, "closing_speed"),
    ("two-spheres", {"branch": "R+d"}, "branch"),
    ("two-spheres", {"masses": "1,1,1"}, "masses"),
    ("newtons-first-law", {"member": "sphere"}, "member"),
]


def at_rest(instance: Instance) -> Trajectory:
    """The start, twice: what an engine would show if nothing happened."""
    bodies = instance.scene.bodies
    state = {name: np.stack([getattr(bodies, name)] * 2) for name in ("position", "velocity", "attitude", "omega")}
    return Trajectory(t=np.array([0.0, 1.0]), **state)


def test_the_catalogue_has_these_cases() -> None:
    assert set(discovery.names("cases")) == {*CATALOGUE, "time-reversal"}


@pytest.mark.parametrize("name", CATALOGUE)
def test_names_of_parameters_and_quantities_are_the_catalogues(name: str) -> None:
    parameters, quantities = CATALOGUE[name]
    case = discovery.case(name)
    assert [p.name for p in case.parameters] == parameters.split()
    assert list(case.at().quantities) == quantities
    assert (case.id, len(case.statement.split(". ")) >= 2) == (name, True)


@pytest.mark.parametrize(("name", "given", "word"), REFUSED)
def test_values_that_make_no_motion_are_refused_by_name(name: str, given: dict[str, str], word: str) -> None:
    with pytest.raises(UsageError, match=word):
        discovery.case(name).at(**given)


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_a_scene_survives_json(name: str, given: dict[str, str]) -> None:
    scene = discovery.case(name).at(**given).scene
    assert Scene.from_json(scene.to_json()).to_json() == scene.to_json()


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_scales_are_positive_and_finite(name: str, given: dict[str, str]) -> None:
    instance = discovery.case(name).at(**given)
    sizes = [instance.scales.length, instance.scales.tau, instance.scales.duration, instance.scales.mass]
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
        assert abs(difference) <= 1e-15 * max(1.0, abs(values[0])) * 4, quantity


@pytest.mark.parametrize(("name", "given"), STARTS)
def test_truth_moves_as_its_velocities_say(name: str, given: dict[str, str]) -> None:
    instance, small = discovery.case(name).at(**given), Fraction(1, 2**20)
    rates = {"x": "vx", "y": "vy", "z": "vz", "theta": "thetadot"}
    rates |= {f"r{i}.{a}": f"v{i}.{a}" for i in (1, 2) for a in AXES}
    t = Fraction(float(instance.times[3]))
    before, now, after = (instance.truth().at(s) for s in (t - small, t, t + small))
    for place, rate in rates.items():
        rate = rate if rate in now else "v"
        if place in now and rate in now:
            slope = (after[place].mid - before[place].mid) / (2 * small)
            turns = round(float(slope * 2 * small) / (2 * np.pi))
            expected, scale = float(now[rate].mid), instance.quantities[rate].scale
            assert abs(float(slope) - turns * np.pi / float(small) - expected) < 1e-4 * scale, place


def test_every_default_has_a_truth() -> None:
    for name in CATALOGUE:
        try:
            found = discovery.case(name).at().truth().at(Fraction(1, 4))
        except NotCertifiedError as error:
            raise AssertionError(name) from error
        assert all(ball.radius <= Fraction(1, 10**20) for ball in found.values())
